//! Stand-in for `glslang.rs` without the feature `compiler`.

use super::error::LinkError;
use super::stage::Stage;

/// Source text of a shader.
#[expect(dead_code, reason = "it is not read")]
pub(super) struct Text<'a> {
    pub(super) name: &'a str,
    pub(super) text: &'a str,
    pub(super) stage: Stage,
    pub(super) is_optimized: bool,
}

/// Always fails.
pub(super) fn started() -> Result<(), LinkError> {
    Err(LinkError::NoCompiler)
}

/// Resolves an include to path and text.
type Include<'a> = dyn Fn(&str, bool) -> Result<(String, String), String> + 'a;

/// Always fails.
pub(super) fn compiled(_: &Text<'_>, _: &Include<'_>) -> Result<Vec<u32>, LinkError> {
    Err(LinkError::NoCompiler)
}
