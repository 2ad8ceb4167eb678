//! Undefined values in SPIR-V, by which slices, rays and compute shaders give different pictures.
//!
//! Found are variables that are read but not written before on every path, functions that can end without `return`, global
//! variables that keep a value from one call to the next, constant indices out of range, `discard`, derivatives, and
//! texture lookups that choose a level by derivatives.

mod flow;
mod model;
mod scalar;
mod state;
mod step;

use crate::find_word;
use flow::Flow;
use model::Model;

/// Variable of a program: whether the sample before this one was taken on the same ray, one step nearer to the eye.
const FOLLOWS: &str = "follows";

/// Undefined values in a module.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Undefined {
    /// A message `file:line: text` for each, in order.
    pub found: Vec<String>,
    /// Arrays that are taken to be filled by stores with an index that is not known: file, line and name of each.
    pub filled: Vec<String>,
}

/// Undefined values in a module of unoptimized SPIR-V with lines, in the files of which `text_of` returns the text. Other
/// files are taken for right. A file that reads `follows` may keep values from sample to sample.
///
/// # Errors
/// The module has too many paths.
pub fn undefined<'t>(module: &[u32], text_of: &dyn Fn(&str) -> Option<&'t str>) -> Result<Undefined, String> {
    let model = Model::read(module);
    let is_own = |file: &str| text_of(file).is_some();
    let keeps = |file: &str| text_of(file).is_some_and(|text| find_word(text, |word| word == FOLLOWS).is_some());
    let mut flow = Flow::new(&model, &is_own, &keeps);
    if !flow.follow() {
        return Err(
            "its functions have too many paths to find what is read before it is written; make them shorter".into()
        );
    }
    let found = flow.found.iter().map(|(file, line, text)| format!("{file}:{line}: {text}")).collect();
    let filled = flow.filled.iter().map(|(file, line, name)| format!("{file}:{line}: `{name}`")).collect();
    Ok(Undefined { found, filled })
}

#[cfg(all(test, feature = "compiler"))]
mod tests;
