//! Colors of matter without light.

use super::error::PolygonizeError;
use crate::eval;
use crate::render::error::RenderError;
use crate::render::inputs::CpuInputs;
use crate::render::subject::Subject;
use crate::render::variant::{OCTAVES_ID, Purpose, Variant, as_density, unlit};
use crate::shader::{Library, Linker};
use glam::DVec3;
use rayon::prelude::*;

/// Points in a batch of a thread.
const BATCH: usize = 1024;

/// Color of the matter at places in object space, linear RGB in \[0, 1\]: black where there is no matter.
pub(crate) fn colors(
    library: &Library,
    drawn: &Variant,
    subject: &Subject,
    places: &[DVec3],
) -> Result<Vec<[f32; 3]>, PolygonizeError> {
    let neutral = Variant::of(&unlit(&drawn.scene, library), library)?;
    let (library, mut variant) = as_density(library, &neutral.for_purpose(Purpose::Voxels, library)?);
    variant.entries = ["march.vert", "matter.frag"];
    let program = variant.program(&library, Linker::new)?;
    let cpu_inputs = CpuInputs::new(&library, &neutral, subject, &program)?;
    let mut inputs = cpu_inputs.exact();
    inputs.blocks = cpu_inputs.moments(&program)?.into_iter().next().unwrap_or_default();
    let code = eval::Program::read(&program.fragment, &[(OCTAVES_ID, neutral.scene.effect.octaves)])?;
    let bound = code.bind(&inputs)?;
    let colors = places.par_chunks(BATCH).map(|places| {
        let places = places.iter().map(|place| [place.x, place.y, place.z, 0.0]).collect();
        let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places)].into() };
        let outputs = bound.run::<f64>(&lanes).map_err(RenderError::from)?;
        let color = |[red, green, blue, density]: &[f64; 4]| {
            [red, green, blue].map(|part| (part / density.max(1e-9)).clamp(0.0, 1.0) as f32)
        };
        Ok(outputs[&0].iter().map(color).collect::<Vec<_>>())
    });
    Ok(colors.collect::<Result<Vec<_>, PolygonizeError>>()?.concat())
}
