//! Density of a scene anywhere in object space.
//!
//! Invariant: the density is that of the scene's program, evaluated by [`eval`](crate::eval) in f64 and in bounds.

use super::error::PolygonizeError;
use crate::eval::{self, Affine, ExactError, F32Interval, Interval};
use crate::render::camera::View;
use crate::render::cells::{LOOKED_UP, bounded};
use crate::render::custom_modules::scattered;
use crate::render::error::RenderError;
use crate::render::inputs::CpuInputs;
use crate::render::subject::Subject;
use crate::render::variant::{Checkable, OCTAVES_ID, Purpose, Variant, as_density};
use crate::scene::{Projection, Scene};
use crate::shader::slots::MAIN;
use crate::shader::{Library, Linker};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Points in a batch.
const BATCH: usize = 1024;

/// Density of a scene at its first moment.
pub(crate) struct DensityProgram {
    code: eval::Program,
    inputs: eval::Inputs,
    /// Bounds of the soft region.
    pub view: View,
    library: Library,
    variant: Variant,
    octaves: [(u32, u32); 1],
    cpu_inputs: CpuInputs,
}

impl DensityProgram {
    /// Links and loads the density of a scene.
    pub fn of(library: &Library, drawn: &Variant, subject: &Subject) -> Result<DensityProgram, PolygonizeError> {
        let (library, variant) = as_density(library, &drawn.for_purpose(Purpose::Cells, library)?);
        let program = variant.program(&library, Linker::new).map_err(RenderError::from)?;
        let cpu_inputs = CpuInputs::new(&library, drawn, subject, &program)?;
        let mut inputs = cpu_inputs.exact();
        inputs.blocks = cpu_inputs.moments(&program)?.into_iter().next().unwrap_or_default();
        let octaves = [(OCTAVES_ID, drawn.scene.effect.octaves)];
        let code = eval::Program::read_channel(&program.fragment, &octaves, (0, 3))?;
        let view = View::of(drawn, subject);
        Ok(DensityProgram { code, inputs, view, library, variant, octaves, cpu_inputs })
    }

    /// Bounds of the density along segments in object space, each from one of these places to the next.
    fn between(&self, places: &[DVec3]) -> Result<Vec<Interval>, PolygonizeError> {
        let (own, inputs) = match bounded(&self.variant, &self.library) {
            None => (None, self.inputs.clone()),
            Some((program, noise)) => {
                let code = eval::Program::read_channel(&program.fragment, &self.octaves, (0, 3))?;
                let noises = program.image(LOOKED_UP).map(|lookup| (lookup, noise)).into_iter().collect();
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

    /// Binds the inputs of the program.
    pub fn bound(&self, level: f64) -> Result<Density<'_>, ExactError> {
        Ok(Density { bound: self.code.bind(&self.inputs)?, level })
    }
}

/// A density program with its inputs.
pub(crate) struct Density<'a> {
    bound: eval::BoundProgram<'a>,
    /// Lowest density inside.
    pub level: f64,
}

impl Density<'_> {
    /// Evaluates the density at points in object space.
    pub fn at(&self, places: &[DVec3]) -> Result<Vec<f64>, ExactError> {
        let places = places.iter().map(|place| [place.x, place.y, place.z, 0.0]).collect();
        let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places)].into() };
        let outputs = self.bound.run::<f64>(&lanes)?;
        Ok(outputs[&0].iter().map(|[density, ..]| *density).collect())
    }

    /// Classifies boxes: true if completely inside, false if completely outside, `None` if undecided.
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

/// Density of a scene at a place, object space.
///
/// # Errors
/// As [`densities`].
pub(crate) fn density_at(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    at: Vec3,
) -> Result<f64, PolygonizeError> {
    let program = DensityProgram::of(library, &*scene.checked(library)?, subject)?;
    let found = program.bound(0.0)?.at(&[at.as_dvec3()])?;
    Ok(found.first().copied().unwrap_or_default())
}

/// Histogram of the density over the soft region, at the first moment of a scene: `places` points of the plastic number
/// sequence (M. Roberts 2018), counted in `bins` equal bins of the densities above 0, up to 1.
///
/// The error of a count is about its square root; points without matter are not counted.
///
/// # Errors
/// As [`polygonize`](crate::render::polygonize), except for its settings.
pub fn densities(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    places: u32,
    bins: usize,
) -> Result<Vec<u32>, PolygonizeError> {
    let program = DensityProgram::of(library, &*scene.checked(library)?, subject)?;
    let density = program.bound(0.0)?;
    let (low, high) = (program.view.box_min.as_dvec3(), program.view.box_max.as_dvec3());
    let all: Vec<DVec3> = (0..places).map(|index| low + (high - low) * DVec3::from(scattered(index))).collect();
    let found: Vec<Vec<f64>> = all.par_chunks(BATCH).map(|places| density.at(places)).collect::<Result<_, _>>()?;
    let mut counts = vec![0; bins];
    for density in found.into_iter().flatten().filter(|density| *density > 0.0) {
        counts[((density * bins as f64) as usize).min(bins - 1)] += 1;
    }
    Ok(counts)
}

/// Density at a point of a ray, with bounds up to the next point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Along {
    /// Distance from the origin of the ray, object units.
    pub depth: f64,
    /// Density at the point.
    pub density: f64,
    /// Bounds of the density up to the next point; at the last point, its density.
    pub range: [f64; 2],
}

/// Tolerance for constants of noise in f32, which bounds and f64 round differently.
const ROUNDING: f64 = 1e-6;

/// The line of sight through the middle of a pixel, in object space.
struct Sight {
    from: DVec3,
    /// Direction; one of it is a depth of 1 along the axis of view.
    along: DVec3,
    /// Its length in eye space.
    unit: f64,
    /// Depths at which it enters and leaves the box around the soft region.
    enters: f64,
    leaves: f64,
}

impl Sight {
    /// `None` where it misses the box.
    fn of(scene: &Scene, view: &View, pixel: [u32; 2]) -> Option<Sight> {
        let ndc = [0, 1].map(|axis| {
            let side = f64::from(scene.image.size[axis]);
            (2.0 * f64::from(pixel[axis]) + 1.0) / side - 1.0 - f64::from(view.pan[axis])
        });
        let across = DVec3::new(ndc[0] * f64::from(view.ray_scale[0]), -ndc[1] * f64::from(view.ray_scale[1]), 0.0);
        let [from, to] = match scene.projection() {
            Projection::Perspective => [DVec3::ZERO, across - DVec3::Z],
            Projection::Parallel => [across, across - DVec3::Z],
        };
        let unit = from.distance(to);
        let [from, to] = [from, to].map(|place| view.texture_matrix.as_dmat4().transform_point3(place));
        let along = to - from;
        let (low, high) = (view.box_min.as_dvec3(), view.box_max.as_dvec3());
        let (a, b) = ((low - from) / along, (high - from) / along);
        let (enters, leaves) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        (enters < leaves).then_some(Sight { from, along, unit, enters, leaves })
    }

    /// Equidistant depths from the entry to the exit.
    fn depths(&self, places: usize) -> impl Iterator<Item = f64> {
        let step = (self.leaves - self.enters) / places.saturating_sub(1).max(1) as f64;
        (0..places).map(move |index| self.enters + index as f64 * step)
    }

    /// The points at these depths.
    fn places(&self, places: usize) -> Vec<DVec3> {
        self.depths(places).map(|depth| self.from + self.along * depth).collect()
    }
}

/// Distances from the origin of a pixel's ray to its samples within the box around the soft region, object units: those of
/// slices and of rays without jitter, in [`density_along`]'s unit. Empty for half-angle slices, which have another axis.
///
/// # Errors
/// The scene is not valid.
pub fn samples_along(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    pixel: [u32; 2],
) -> Result<Vec<f64>, PolygonizeError> {
    let checked = scene.checked(library)?;
    let view = View::of(&checked, subject);
    let (scene, sight) = (&checked.scene, Sight::of(&checked.scene, &view, pixel));
    let Some(sight) = sight.filter(|_| !scene.is_half_angle()) else { return Ok(Vec::new()) };
    let planes = view.planes(scene.quality.samples);
    let depths = (0..planes.count).map(|plane| f64::from(planes.depth(plane)));
    Ok(depths.filter(|depth| (sight.enters..=sight.leaves).contains(depth)).map(|depth| depth * sight.unit).collect())
}

/// Name of the object whose soft region holds the first matter on the ray through the middle of a pixel, found at `places` equal
/// distances; `main` for that of the scene. `None` where the ray meets no matter, or that of custom formulas only.
///
/// # Errors
/// As [`density_along`].
pub fn object_along(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    pixel: [u32; 2],
    places: usize,
) -> Result<Option<String>, PolygonizeError> {
    let checked = scene.checked(library)?;
    let program = DensityProgram::of(library, &checked, subject)?;
    let Some(sight) = Sight::of(&checked.scene, &program.view, pixel) else { return Ok(None) };
    let all = sight.places(places);
    let found = program.bound(0.0)?.at(&all)?;
    let Some((place, _)) = all.iter().zip(found).find(|(_, density)| *density > 0.0) else { return Ok(None) };
    let beyond = program.view.objects.iter().filter_map(|own| {
        let of = subject.parts.get(&own.name).unwrap_or(subject);
        let distance = of.distance()?(own.place.inverse().transform_point3(place.as_vec3()));
        Some(((distance - own.outer_iso) * own.scale, if own.name.is_empty() { MAIN } else { &own.name }))
    });
    Ok(beyond.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, name)| name.into()))
}

/// The density of a scene at its first moment along the ray through the middle of a pixel: at `places` equal distances from
/// where the ray enters the box around the soft region to where it leaves it, and bounds between them, in which noise is taken
/// to about 1e-6. Empty where the ray misses the box. Of a ray that bends, it is the straight one.
///
/// # Errors
/// As [`polygonize`](crate::render::polygonize), except for its settings.
pub fn density_along(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    pixel: [u32; 2],
    places: usize,
) -> Result<Vec<Along>, PolygonizeError> {
    let checked = scene.checked(library)?;
    let program = DensityProgram::of(library, &checked, subject)?;
    let scene = &checked.scene;
    let Some(sight) = Sight::of(scene, &program.view, pixel) else { return Ok(Vec::new()) };
    let all = sight.places(places);
    let found = program.bound(0.0)?.at(&all)?;
    let kept = |place: &DVec3| match scene.camera.clip {
        Some([a, b, c, d]) => place.dot(DVec3::new(a.into(), b.into(), c.into())) <= f64::from(d),
        None => true,
    };
    let densities = all.iter().zip(found).map(|(place, density)| if kept(place) { density } else { 0.0 });
    let mut along: Vec<Along> = (sight.depths(places).zip(densities))
        .map(|(depth, density)| Along { depth: depth * sight.unit, density, range: [density; 2] })
        .collect();
    for (index, range) in program.between(&all)?.into_iter().enumerate() {
        let range = [range.lo - ROUNDING, range.hi + ROUNDING];
        along[index].range = match [index, index + 1].map(|end| kept(&all[end])) {
            [true, true] => range,
            [false, false] => [0.0; 2],
            _ => [range[0].min(0.0), range[1].max(0.0)],
        };
    }
    Ok(along)
}
