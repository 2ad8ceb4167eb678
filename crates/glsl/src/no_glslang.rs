//! In the place of `glslang.rs` in a library without its feature `glsl`: programs that ship are all there are.

use super::error::LinkError;
use super::stage::Stage;

/// What is not compiled.
#[expect(dead_code, reason = "it is not read")]
pub(super) struct Text<'a> {
    pub(super) name: &'a str,
    pub(super) text: &'a str,
    pub(super) stage: Stage,
    pub(super) is_optimized: bool,
}

/// Fails.
pub(super) fn started() -> Result<(), LinkError> {
    Err(LinkError::NoCompiler)
}

/// A file that a text includes: path and text.
type Include<'a> = dyn Fn(&str, bool) -> Result<(String, String), String> + 'a;

/// Fails.
pub(super) fn compiled(_: &Text<'_>, _: &Include<'_>) -> Result<Vec<u32>, LinkError> {
    Err(LinkError::NoCompiler)
}
