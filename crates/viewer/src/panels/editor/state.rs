//! State of the editor.

use super::complete::Completion;
use super::find::Find;

/// State of the editor.
#[derive(Default)]
pub(in crate::panels) struct Editor {
    /// Whether long lines wrap.
    pub(super) wraps: bool,
    pub(super) find: Find,
    pub(super) completion: Completion,
    /// Bytes of the text to scroll to and to select.
    pub(super) go_to: Option<std::ops::Range<usize>>,
}
