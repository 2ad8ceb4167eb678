//! The density of a scene anywhere in object space.
//!
//! Role: what is measured of matter without a picture: its surface, how much of it there is of each density, and what is on a
//! ray. Invariant: the density is that of the scene's own program, evaluated by [`exact`] in f64, and in bounds of it.

use super::cells::{LOOKED_UP, bounded};
use super::cpu_inputs::CpuInputs;
use super::shot::Shot;
use super::view::View;
use super::{OCTAVES_ID, PolygonizeError, RenderError, Subject};
use crate::eval::{self, Affine, ExactError, F32Interval, Interval};
use crate::render::variant::Variant;
use crate::scene::{Projection, Scene};
use crate::shader::{Library, Linker};
use glam::DVec3;
use rayon::prelude::*;

/// The opacity of the program: the density itself, of whatever path.
const DENSITY: &str = "// The density in place of the opacity of a path.
float opacity(float density, float amount) { return density; }
float segment_opacity(float d0, float d1, float amount) { return 0.5 * (d0 + d1); }
";
/// Places that are evaluated together.
const TOGETHER: usize = 1024;

/// What gives the density of a scene at its first moment.
pub(super) struct DensityProgram {
    code: eval::Program,
    inputs: eval::Inputs,
    /// Where the soft region is.
    pub view: View,
    library: Library,
    variant: Variant,
    octaves: [(u32, u32); 1],
    cpu_inputs: CpuInputs,
}

impl DensityProgram {
    /// That of a scene.
    pub fn of(library: &Library, scene: &Scene, subject: &Subject) -> Result<DensityProgram, PolygonizeError> {
        let library = library.clone().with_module("opacity", "density", DENSITY);
        let drawn = Variant::of(scene, &library)?;
        let variant = drawn.cells_by("density", scene, &library)?;
        let program = variant.program(&library, Linker::new).map_err(RenderError::from)?;
        let cpu_inputs = CpuInputs::new(&library, scene, subject, &drawn, &program)?;
        let mut inputs = cpu_inputs.exact();
        inputs.blocks = cpu_inputs.moments(&program)?.into_iter().next().unwrap_or_default();
        let octaves = [(OCTAVES_ID, scene.effect.octaves)];
        let code = eval::Program::read_channel(&program.fragment, &octaves, (0, 3))?;
        let view = Shot::of(scene, subject, &drawn).view;
        Ok(DensityProgram { code, inputs, view, library, variant, octaves, cpu_inputs })
    }

    /// Bounds of the density along segments in object space, each from one of these places to the next.
    fn between(&self, places: &[DVec3]) -> Result<Vec<Interval>, PolygonizeError> {
        let (own, inputs) = match bounded(&self.variant, &self.library) {
            None => (None, self.inputs.clone()),
            Some((program, noise)) => {
                let code = eval::Program::read_channel(&program.fragment, &self.octaves, (0, 3))?;
                let lookup = program.resources.iter().find(|resource| resource.name == LOOKED_UP);
                let noises = lookup.map(|lookup| (lookup.binding, noise)).into_iter().collect();
                let blocks = self.cpu_inputs.moments(&program)?.into_iter().next().unwrap_or_default();
                (Some(code), eval::Inputs { blocks, noises, ..self.inputs.clone() })
            }
        };
        let bound = own.as_ref().unwrap_or(&self.code).bind(&inputs)?;
        let places = places.windows(2).map(|ends| {
            let [from, to] = [ends[0], ends[1]].map(|end| end.to_array());
            let [x, y, z] = [0, 1, 2].map(|axis| Affine::between(from[axis], to[axis]));
            [x, y, z, eval::Number::new(0.0)]
        });
        let segments = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places.collect())].into() };
        let outputs = bound.run::<Affine>(&segments)?;
        Ok(outputs[&0].iter().map(|[density, ..]| density.all).collect())
    }

    /// With what it reads.
    pub fn bound(&self, level: f64) -> Result<Density<'_>, ExactError> {
        Ok(Density { bound: self.code.bind(&self.inputs)?, level })
    }
}

/// The program of a density, and what it reads.
pub(super) struct Density<'a> {
    bound: eval::BoundProgram<'a>,
    /// What is inside is at least as dense.
    pub level: f64,
}

impl Density<'_> {
    /// At places in object space.
    pub fn at(&self, places: &[DVec3]) -> Result<Vec<f64>, ExactError> {
        let places = places.iter().map(|place| [place.x, place.y, place.z, 0.0]).collect();
        let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places)].into() };
        let outputs = self.bound.run::<f64>(&lanes)?;
        Ok(outputs[&0].iter().map(|[density, ..]| *density).collect())
    }

    /// On which side boxes are: true where all is inside, false where nothing is.
    pub fn sides(&self, boxes: &[[DVec3; 2]]) -> Result<Vec<Option<bool>>, ExactError> {
        let interval = |lo, hi| F32Interval(Interval { lo, hi });
        let places = boxes.iter().map(|[low, high]| {
            let [x, y, z] = [0, 1, 2].map(|axis| interval(low[axis], high[axis]));
            [x, y, z, interval(0.0, 0.0)]
        });
        let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places.collect())].into() };
        let outputs = self.bound.run::<F32Interval>(&lanes)?;
        let side = |density: Interval| match density {
            Interval { lo, .. } if lo >= self.level => Some(true),
            Interval { hi, .. } if hi < self.level => Some(false),
            _ => None,
        };
        Ok(outputs[&0].iter().map(|[density, ..]| side(density.0)).collect())
    }
}

/// How much of the soft region has which density, at the first moment of a scene: counts of `places` points, spread evenly
/// by the sequence of the plastic number (M. Roberts 2018), in `bins` equal parts of the densities above 0, up to 1.
///
/// Each count is within about sqrt(count) of its part of the region; points without matter are in none.
///
/// # Errors
/// Those of [`polygonize`](super::polygonize), but for its settings.
pub fn densities(
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    places: u32,
    bins: usize,
) -> Result<Vec<u32>, PolygonizeError> {
    let program = DensityProgram::of(library, scene, subject)?;
    let density = program.bound(0.0)?;
    let (low, high) = (program.view.box_min.as_dvec3(), program.view.box_max.as_dvec3());
    const PLASTIC: f64 = 1.220_744_084_605_759_5; // x^4 = x + 1
    let steps = DVec3::from([1, 2, 3].map(|power| PLASTIC.powi(-power)));
    let all: Vec<DVec3> =
        (0..places).map(|index| low + (high - low) * (0.5 + steps * f64::from(index)).fract()).collect();
    let found: Vec<Vec<f64>> = all.par_chunks(TOGETHER).map(|places| density.at(places)).collect::<Result<_, _>>()?;
    let mut counts = vec![0; bins];
    for density in found.into_iter().flatten().filter(|density| *density > 0.0) {
        counts[((density * bins as f64) as usize).min(bins - 1)] += 1;
    }
    Ok(counts)
}

/// The density at a place on a ray, and what is known from there to the next place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Along {
    /// Distance from where the ray begins, object units.
    pub depth: f64,
    /// The density at the place.
    pub density: f64,
    /// Bounds of the density from there to the next place; behind the last one, the density at it.
    pub range: [f64; 2],
}

/// Noise has its constants in 32 bits, which bounds of it and its values in f64 round differently.
const ROUNDED: f64 = 1e-6;

/// The density of a scene at its first moment along the ray through the middle of a pixel: at `places` equal distances from
/// where the ray enters the box around the soft region to where it leaves it, and bounds between them, in which noise is taken
/// to about 1e-6. Empty where the ray misses the box. Of a ray that bends, it is the straight one.
///
/// # Errors
/// Those of [`polygonize`](super::polygonize), but for its settings.
pub fn density_along(
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    pixel: [u32; 2],
    places: usize,
) -> Result<Vec<Along>, PolygonizeError> {
    let program = DensityProgram::of(library, scene, subject)?;
    let view = &program.view;
    let ndc = [0, 1].map(|axis| {
        let side = f64::from(scene.image.size[axis]);
        (2.0 * f64::from(pixel[axis]) + 1.0) / side - 1.0 - f64::from(view.pan[axis])
    });
    let across = DVec3::new(ndc[0] * f64::from(view.ray_scale[0]), -ndc[1] * f64::from(view.ray_scale[1]), 0.0);
    let [from, to] = match scene.camera.projection {
        Projection::Perspective => [DVec3::ZERO, across - DVec3::Z],
        Projection::Parallel => [across, across - DVec3::Z],
    };
    let unit = from.distance(to);
    let [from, to] = [from, to].map(|place| view.texture_matrix.as_dmat4().transform_point3(place));
    let along = to - from;
    let (low, high) = (view.box_min.as_dvec3(), view.box_max.as_dvec3());
    let (a, b) = ((low - from) / along, (high - from) / along);
    let (enters, leaves) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
    if enters >= leaves || enters.is_nan() || leaves.is_nan() {
        return Ok(Vec::new());
    }
    let step = (leaves - enters) / places.saturating_sub(1).max(1) as f64;
    let depths: Vec<f64> = (0..places).map(|index| enters + index as f64 * step).collect();
    let all: Vec<DVec3> = depths.iter().map(|depth| from + along * *depth).collect();
    let found = program.bound(0.0)?.at(&all)?;
    let kept = |place: &DVec3| match scene.camera.clip {
        Some([a, b, c, d]) => place.dot(DVec3::new(a.into(), b.into(), c.into())) <= f64::from(d),
        None => true,
    };
    let densities = all.iter().zip(found).map(|(place, density)| if kept(place) { density } else { 0.0 });
    let mut along: Vec<Along> = (depths.iter().zip(densities))
        .map(|(depth, density)| Along { depth: depth * unit, density, range: [density; 2] })
        .collect();
    for (index, range) in program.between(&all)?.into_iter().enumerate() {
        let range = [range.lo - ROUNDED, range.hi + ROUNDED];
        along[index].range = match [index, index + 1].map(|end| kept(&all[end])) {
            [true, true] => range,
            [false, false] => [0.0; 2],
            _ => [range[0].min(0.0), range[1].max(0.0)],
        };
    }
    Ok(along)
}
