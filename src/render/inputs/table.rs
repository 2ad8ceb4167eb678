//! Tabulated module functions: the evaluator runs the module itself, so that its formula is written once.

use super::uniforms::{Values, blocks};
use crate::eval::{Inputs, Invocations, Program};
use crate::render::error::RenderError;
use crate::render::variant::{Resource, Use, Variant};
use crate::shader::{Library, Linker};
use std::collections::BTreeMap;

/// Entry file of the opacity of a path; the input is a density, and the rate times the path.
pub(crate) const OPACITY: &str = "opacity_table.frag";
/// Entry file of the density at a distance, object units.
pub(crate) const DENSITY: &str = "density_table.frag";

/// A module function, ready for evaluation.
pub(crate) struct Function {
    program: Program,
    inputs: Inputs,
    /// Whether the function reads module parameters.
    pub(crate) reads_parameters: bool,
}

impl Function {
    /// Links and reads one of the entry files above.
    pub(crate) fn new(
        entry: &'static str,
        variant: &Variant,
        library: &Library,
        values: &Values,
    ) -> Result<Function, RenderError> {
        let linked = variant.table(entry, library)?.program(library, Linker::new)?;
        let moves = |resource: &Resource| resource.name == "View" || !matches!(resource.holds, Use::Block(_));
        if linked.resources.iter().any(moves) {
            return Err(RenderError::Table);
        }
        let reads_parameters = linked.reads("Parameters");
        let inputs = Inputs { blocks: blocks(&linked, values)?, ..Inputs::default() };
        Ok(Function { program: Program::read(&linked.fragment, &[])?, inputs, reads_parameters })
    }

    /// Evaluates the function at each input.
    pub(crate) fn at(&self, given: impl Iterator<Item = [f32; 2]>) -> Result<Vec<f32>, RenderError> {
        let given: Vec<_> = given.map(|[a, b]| [f64::from(a), f64::from(b), 0.0, 0.0]).collect();
        let lanes =
            Invocations { fragment_coordinates: vec![[0.0; 4]; given.len()], varyings: BTreeMap::from([(0, given)]) };
        let values = self.program.bind(&self.inputs)?.run::<f64>(&lanes)?.remove(&0).unwrap_or_default();
        Ok(values.into_iter().map(|value| value[0] as f32).collect())
    }
}
