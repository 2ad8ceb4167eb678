//! The parameters of a scene over their ranges: largest error against the reference, and jumps.

use super::equivalences;
use crate::cases::{CaseError, Row};
use crate::reference::{TOLERANCE, reference_pixels, truth_of};
use crate::statistics::largest;
use hypertexture::field::Progress;
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, Renderer, Subject, find_module_fault};
use hypertexture::scene::{ParameterValue, Scene};
use hypertexture::shader::{Library, ParameterKind};

/// Pixels along a side of the pictures.
pub const SIDE: u32 = 48;
/// Pixels along a side that are compared with the reference, spread evenly over the picture.
const KNOWN: u32 = 6;
/// Distance of neighboring values, as a share of the range.
const APART: f32 = 1e-5;
/// Places in a range that are tried, from 0 at its low end to 1 at its high end.
const PLACES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Values of parameters, and the picture there.
#[derive(Clone, Debug)]
pub struct Corner {
    /// Changed parameters and their values.
    pub changes: Vec<(String, f32)>,
    /// Largest error of linear light in the compared pixels; `None` without a picture or a reference.
    pub error: Option<f64>,
    /// Error of the reference itself: estimated from samples, and proven.
    pub reference_error: [f64; 2],
    /// Largest second difference of a pixel over three neighboring values.
    pub jump: f64,
    /// Reason for a missing picture or reference; empty if both exist.
    pub why: String,
    /// Whether the picture is finite, or the scene refused.
    pub ok: bool,
}

/// Result of a sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The scene itself, and each value of each parameter.
    pub corners: Vec<Corner>,
    /// The corner with the largest error, with further parameters added as long as the error grows.
    pub worst: Option<Corner>,
    /// Differences of equivalent scenes, for the scene itself and the worst corner.
    pub equivalences: Vec<Row>,
    /// Values ten ranges outside of their range that were accepted.
    pub accepted: Vec<(String, f32)>,
}

impl Sweep {
    /// Whether nothing failed.
    pub fn ok(&self) -> bool {
        self.accepted.is_empty()
            && self.equivalences.iter().all(|row| row.ok)
            && self.corners.iter().chain(&self.worst).all(|corner| corner.ok)
    }
}

/// A parameter of a scene.
struct Ranged {
    name: String,
    range: [f32; 2],
}

/// Device, modules and scene of a sweep.
struct Context<'a> {
    gpu: &'a Gpu,
    library: &'a Library,
    scene: &'a Scene,
}

/// Sweeps each parameter of a scene over its range, and combines the worst values.
///
/// # Errors
/// The scene itself is refused.
pub fn sweep(gpu: &Gpu, library: &Library, scene: &Scene, progress: Progress<'_>) -> Result<Sweep, CaseError> {
    let mut scene = scene.clone();
    scene.image.size = [SIDE; 2];
    let parameters: Vec<Ranged> = scene
        .check(library)?
        .iter()
        .filter_map(|(parameter, _)| match parameter.kind {
            ParameterKind::Number(_, range) => Some(Ranged { name: parameter.name.clone(), range }),
            ParameterKind::Color(_) => None,
        })
        .collect();
    Subject::load(&scene, library, &|_| ())?; // an unreadable object is an error, not a corner
    let context = Context { gpu, library, scene: &scene };
    let (mut corners, mut accepted) = (vec![context.corner(&[])], Vec::new());
    let mut worst_of: Vec<(String, f32, f64)> = Vec::new();
    for (done, Ranged { name, range: [low, high] }) in parameters.iter().enumerate() {
        progress(0.9 * done as f32 / parameters.len() as f32);
        let mut worst: Option<(f32, f64)> = None;
        for place in PLACES {
            let value = low + place * (high - low);
            let corner = context.corner(&[(name.clone(), value)]);
            if let Some(error) = corner.error.filter(|error| worst.is_none_or(|(_, most)| *error > most)) {
                worst = Some((value, error));
            }
            corners.push(corner);
        }
        worst_of.extend(worst.map(|(value, error)| (name.clone(), value, error)));
        for value in [low - 10.0 * (high - low), high + 10.0 * (high - low)] {
            if context.changed(&[(name.clone(), value)]).check(library).is_ok() {
                accepted.push((name.clone(), value));
            }
        }
    }
    progress(0.9);
    // The worst value of the worst parameter, combined with those of the others, worst first, while the error grows.
    worst_of.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut worst = corners
        .iter()
        .filter(|corner| corner.error.is_some())
        .cloned()
        .reduce(|worst, corner| if corner.error > worst.error { corner } else { worst });
    for (name, value, _) in worst_of {
        let Some(now) = &worst else { break };
        if now.changes.iter().any(|(other, _)| *other == name) {
            continue;
        }
        let mut changes = now.changes.clone();
        changes.push((name, value));
        let corner = context.corner(&changes);
        if corner.error > now.error || !corner.ok {
            worst = Some(corner);
        }
    }
    progress(0.95);
    let mut equivalences = equivalences::rows(gpu, library, &scene, "the scene itself")?;
    if let Some(worst) = worst.as_ref().filter(|worst| !worst.changes.is_empty()) {
        equivalences.extend(equivalences::rows(gpu, library, &context.changed(&worst.changes), "the worst corner")?);
    }
    progress(1.0);
    Ok(Sweep { corners, worst, equivalences, accepted })
}

impl Context<'_> {
    fn changed(&self, changes: &[(String, f32)]) -> Scene {
        let mut scene = self.scene.clone();
        for (name, value) in changes {
            scene.parameters.insert(name.clone(), ParameterValue::Number(*value));
        }
        scene
    }

    fn corner(&self, changes: &[(String, f32)]) -> Corner {
        let mut corner = Corner {
            changes: changes.to_vec(),
            error: None,
            reference_error: [0.0; 2],
            jump: 0.0,
            why: String::new(),
            ok: true,
        };
        let scene = self.changed(changes);
        if let Err(error) = scene.check(self.library) {
            corner.why = error.to_string(); // a combination of values may be refused
            return corner;
        }
        if let Err(error) = self.measure(&scene, changes, &mut corner) {
            (corner.why, corner.ok) = (error.to_string(), false);
        }
        corner
    }

    fn measure(&self, scene: &Scene, changes: &[(String, f32)], corner: &mut Corner) -> Result<(), CaseError> {
        let subject = Subject::load(scene, self.library, &|_| ())?;
        if let Some(fault) = find_module_fault(self.library, scene, &subject)? {
            (corner.why, corner.ok) = (fault.to_string(), false);
        }
        let mut renderer = Renderer::new(self.gpu, self.library, &subject);
        let frame = renderer.render(scene)?;
        let pixels: Vec<[u32; 2]> = (0..KNOWN * KNOWN)
            .map(|at| [at % KNOWN, at / KNOWN].map(|place| (2 * place + 1) * SIDE / (2 * KNOWN)))
            .collect();
        let truth = truth_of(scene, self.library).map_err(hypertexture::render::variant::VariantError::from);
        let truth = truth.map_err(hypertexture::render::RenderError::from)?;
        match reference_pixels(self.library, &truth, &subject, &pixels, TOLERANCE, &|_| (), &|| false) {
            Ok(reference) => {
                let off = pixels.iter().zip(&reference.pixels).flat_map(|([x, y], known)| {
                    let found = frame.pixels[(y * SIDE + x) as usize];
                    std::array::from_fn::<f64, 4, _>(|c| (f64::from(found[c]) - known[c]).abs())
                });
                corner.error = Some(largest(off));
                corner.reference_error = [reference.error(), reference.bound()];
            }
            Err(error) => corner.why = error.to_string(),
        }
        if let Some((name, value)) = changes.last() {
            let range = scene.check(self.library)?;
            let range = range.iter().find_map(|(parameter, _)| match parameter.kind {
                ParameterKind::Number(_, range) if parameter.name == *name => Some(range),
                _ => None,
            });
            let Some([low, high]) = range else { return Ok(()) };
            let step = if *value > 0.5 * (low + high) { -APART } else { APART } * (high - low);
            let mut at = |count: f32| -> Result<Frame, CaseError> {
                let mut moved = changes.to_vec();
                moved.last_mut().iter_mut().for_each(|(_, value)| *value += count * step);
                Ok(renderer.render(&self.changed(&moved))?)
            };
            let (next, last) = (at(1.0)?, at(2.0)?);
            let channels = frame.pixels.as_flattened().iter().zip(next.pixels.as_flattened());
            let channels = channels.zip(last.pixels.as_flattened());
            let bends = channels.map(|((a, b), c)| f64::from((a - 2.0 * b + c).abs()));
            corner.jump = largest(bends);
        }
        Ok(())
    }
}
