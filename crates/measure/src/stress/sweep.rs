//! A scene's own parameters over their ranges: where its picture is farthest from the truth, and where it jumps.

use super::{Row, StressError, twins};
use crate::reference::{TOLERANCE, reference_pixels, truth_of};
use crate::statistics::largest;
use hypertexture::field::Progress;
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, Renderer, Subject, try_custom_modules};
use hypertexture::scene::{ParameterValue, Scene};
use hypertexture::shader::{Library, ParameterKind};

/// Pixels along a side of the pictures.
pub const SIDE: u32 = 48;
/// Pixels along a side that are held against the reference: spread evenly over the picture.
const KNOWN: u32 = 6;
/// Neighbors of a value are so much of its range away.
const APART: f32 = 1e-5;
/// Where a range is tried, from its low end to its high one.
const PLACES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Values of parameters, and what the picture is like there.
#[derive(Clone, Debug)]
pub struct Corner {
    /// The parameters that are not as in the scene, with their values.
    pub changes: Vec<(String, f32)>,
    /// Largest error of linear light of the known pixels; `None` where there is no picture to tell one of.
    pub error: Option<f64>,
    /// How far that may be off: the error of the reference itself, as far as samples say, and with all that they may have
    /// overlooked.
    pub known_to: [f64; 2],
    /// How much more a pixel changes from a value to its neighbor than from that to the next: a jump.
    pub jump: f64,
    /// Why there is no picture, or no reference; empty where there are both.
    pub why: String,
    /// Whether that is as it must be: a finite picture, or a refusal that names what is refused.
    pub ok: bool,
}

/// What was found of a scene.
#[derive(Clone, Debug)]
pub struct Swept {
    /// One for each value of each parameter.
    pub corners: Vec<Corner>,
    /// The one with the largest error, and then other parameters too as long as it grows.
    pub worst: Option<Corner>,
    /// What must not change the picture, of the scene itself and of the worst corner.
    pub twins: Vec<Row>,
    /// Values a decade beyond their range that were taken, where they should have been refused.
    pub taken: Vec<(String, f32)>,
}

impl Swept {
    /// Whether every picture is finite, or refused by name, what must not change a picture does not, and nothing beyond its
    /// range is taken.
    pub fn ok(&self) -> bool {
        self.taken.is_empty()
            && self.twins.iter().all(Row::ok)
            && self.corners.iter().chain(&self.worst).all(|corner| corner.ok)
    }
}

/// A parameter of a scene.
struct Ranged {
    name: String,
    range: [f32; 2],
}

/// What pictures are made with.
struct Work<'a> {
    gpu: &'a Gpu,
    library: &'a Library,
    scene: &'a Scene,
}

/// Sweeps each parameter of a scene over its range, and tries the worst values together.
///
/// # Errors
/// The scene itself is refused.
pub fn sweep(gpu: &Gpu, library: &Library, scene: &Scene, progress: Progress<'_>) -> Result<Swept, StressError> {
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
    Subject::load(&scene, library, &|_| ())?; // what cannot be read is no corner
    let work = Work { gpu, library, scene: &scene };
    let (mut corners, mut taken) = (vec![work.corner(&[])], Vec::new());
    let mut worst_of: Vec<(String, f32, f64)> = Vec::new();
    for (done, Ranged { name, range: [low, high] }) in parameters.iter().enumerate() {
        progress(0.9 * done as f32 / parameters.len() as f32);
        let mut worst: Option<(f32, f64)> = None;
        for place in PLACES {
            let value = low + place * (high - low);
            let corner = work.corner(&[(name.clone(), value)]);
            if let Some(error) = corner.error.filter(|error| worst.is_none_or(|(_, most)| *error > most)) {
                worst = Some((value, error));
            }
            corners.push(corner);
        }
        worst_of.extend(worst.map(|(value, error)| (name.clone(), value, error)));
        // A decade beyond: there a scene is refused.
        for value in [low - 10.0 * (high - low), high + 10.0 * (high - low)] {
            if work.changed(&[(name.clone(), value)]).check(library).is_ok() {
                taken.push((name.clone(), value));
            }
        }
    }
    progress(0.9);
    // The worst value of the worst parameter, and with it those of the others, worst first, while the error grows.
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
        let corner = work.corner(&changes);
        if corner.error > now.error || !corner.ok {
            worst = Some(corner);
        }
    }
    progress(0.95);
    let mut twins = twins::rows(gpu, library, &scene, "the scene itself")?;
    if let Some(worst) = worst.as_ref().filter(|worst| !worst.changes.is_empty()) {
        twins.extend(twins::rows(gpu, library, &work.changed(&worst.changes), "the worst corner")?);
    }
    progress(1.0);
    Ok(Swept { corners, worst, twins, taken })
}

impl Work<'_> {
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
            known_to: [0.0; 2],
            jump: 0.0,
            why: String::new(),
            ok: true,
        };
        let scene = self.changed(changes);
        if let Err(error) = scene.check(self.library) {
            corner.why = error.to_string(); // with others, a value may be refused by name
            return corner;
        }
        if let Err(error) = self.measure(&scene, changes, &mut corner) {
            (corner.why, corner.ok) = (error.to_string(), false);
        }
        corner
    }

    fn measure(&self, scene: &Scene, changes: &[(String, f32)], corner: &mut Corner) -> Result<(), StressError> {
        let subject = Subject::load(scene, self.library, &|_| ())?;
        if let Some(fault) = try_custom_modules(self.library, scene, &subject)? {
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
                corner.known_to = [reference.error(), reference.bound()];
            }
            Err(error) => corner.why = error.to_string(),
        }
        // From a value to its neighbor, and from that to the next: where it changes steadily, by as much.
        if let Some((name, value)) = changes.last() {
            let range = scene.check(self.library)?;
            let range = range.iter().find_map(|(parameter, _)| match parameter.kind {
                ParameterKind::Number(_, range) if parameter.name == *name => Some(range),
                _ => None,
            });
            let Some([low, high]) = range else { return Ok(()) };
            let step = if *value > 0.5 * (low + high) { -APART } else { APART } * (high - low);
            let mut at = |count: f32| -> Result<Frame, StressError> {
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
