//! Changes of any scene that must not change its picture.

use crate::cases::{CaseError, Row, Rows, same};
use crate::statistics::rms_difference;
use hypertexture::field::{ClosestPoints, DistanceField, Grid};
use hypertexture::gpu::Gpu;
use hypertexture::noise::Period;
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, RenderError, Renderer, Subject};
use hypertexture::scene::{EmptySpace, Integration, Order, Pass, RayPath, Scene};
use hypertexture::shader::Library;
use std::sync::Arc;

/// A change that must not change the picture.
struct Equivalence {
    what: &'static str,
    /// Largest difference of a channel of linear light.
    bound: f64,
    /// Two scenes with the same picture, most often the scene and a changed one; `None` where the change does not apply.
    pair: fn(&Scene, &Library) -> Option<[Scene; 2]>,
}

/// Rounding of blending in the other order.
const BLENDED: f64 = 2e-5;
/// Period of Perlin's tables, cells.
const TABLE: u32 = 256;
/// Root mean square difference from rounding distant places to f32, for matter with edges.
const MOVED: f64 = 2e-3;
/// Rounding of the places of a bent ray, which add up from step to step.
const BENT: f64 = 1e-4;

const EQUIVALENCES: [Equivalence; 7] = [
    Equivalence { what: "drawn again", bound: 0.0, pair: |scene, _| changed(scene, true, |_| ()) },
    Equivalence {
        what: "a turn of the camera later",
        bound: 0.0,
        pair: |scene, _| {
            let [before, later] = [scene.camera.azimuth, scene.camera.azimuth + 360.0];
            // In f32 the sum may not be a whole turn.
            let is_whole = later - 360.0 == before && scene.camera.rotation.is_none();
            changed(scene, is_whole, |scene| scene.camera.azimuth = later)
        },
    },
    Equivalence {
        what: "every sample taken",
        bound: 0.0,
        pair: |scene, _| {
            let is_other = scene.quality.empty_space != EmptySpace::Sample;
            changed(scene, is_other, |scene| scene.quality.empty_space = EmptySpace::Sample)
        },
    },
    Equivalence {
        what: "terms of 0 kept",
        bound: 0.0,
        pair: |scene, _| changed(scene, true, |scene| scene.quality.fold_zero_terms = false),
    },
    Equivalence {
        what: "slices from the other end",
        bound: BLENDED,
        pair: |scene, _| {
            let plain = scene.quality.early_termination == 0.0 && !scene.is_half_angle();
            changed(scene, plain && scene.quality.pass == Pass::Slices, |scene| {
                scene.quality.order = match scene.quality.order {
                    Order::FrontToBack => Order::BackToFront,
                    Order::BackToFront => Order::FrontToBack,
                };
            })
        },
    },
    Equivalence {
        what: "a soft edge of no width, and a hard one",
        bound: 0.0,
        pair: |scene, library| {
            let middle = 0.5 * (scene.object.inner_iso + scene.object.outer_iso);
            let mut soft = scene.clone();
            (soft.object.inner_iso, soft.object.outer_iso) = (middle, middle);
            // Segments place the edge within a step, and an effect may set a width of its own.
            let is_soft = scene.effect.softness != "hard" && scene.quality.integration == Integration::Point;
            let is_own = Variant::of(scene, library).is_ok_and(|variant| variant.parameters.outer_iso().is_none());
            changed(&soft, is_soft && is_own, |scene| scene.effect.softness = "hard".into())
        },
    },
    Equivalence {
        what: "an index of 1 along a bent ray, and a straight one",
        bound: BENT,
        pair: |scene, _| {
            let mut clear = scene.clone();
            clear.transfer.stops.iter_mut().for_each(|stop| stop.index = 1.0);
            let is_bent = scene.effect.ray_path == RayPath::Refracted && scene.effect.index == "transfer";
            changed(&clear, is_bent, |scene| scene.effect.ray_path = RayPath::Straight)
        },
    },
];

/// A scene, and the scene with a change.
fn changed(scene: &Scene, applies: bool, change: impl FnOnce(&mut Scene)) -> Option<[Scene; 2]> {
    let mut other = scene.clone();
    change(&mut other);
    applies.then(|| [scene.clone(), other])
}

/// The modules of a scene with noise and turbulence looked up two periods away, which also covers periods that are mirrored;
/// `None` where they are not read or endless.
fn periods_away(scene: &Scene, library: &Library) -> Option<Library> {
    let variant = Variant::of(scene, library).ok()?;
    let modules = [("noise", &scene.effect.noise), ("turbulence", &scene.effect.turbulence)];
    let slots = modules.into_iter().zip(scene.periods(library)).filter(|((slot, _), _)| variant.reads(slot));
    slots.fold(None, |moved, ((slot, module), period)| {
        // All periods are powers of two: of a lattice, a block, or Perlin's tables.
        let cells = match library.header(slot, module).ok()?.period.as_deref() {
            Some("memory") => TABLE.max(scene.quality.block_size).max(scene.quality.turbulence_cells),
            _ if period == Period::ENDLESS => return moved,
            _ => period.cells,
        };
        let is_module = |path: &str| path.strip_prefix(slot).is_some_and(|rest| rest.starts_with('/'));
        Some(moved.as_ref().unwrap_or(library).moved(is_module, &format!("place + vec3({}.0)", 2 * cells)))
    })
}

/// The object in units 2^20 times as large, which is exact in f32.
fn enlarged(subject: &Subject) -> Subject {
    const BY: f32 = 1048576.0;
    let mut enlarged = subject.clone();
    (enlarged.center, enlarged.scale) = (BY * subject.center, subject.scale / BY);
    let grid = |grid: &Grid| Grid { origin: BY * grid.origin, spacing: BY * grid.spacing, ..*grid };
    enlarged.field = subject.field.as_ref().map(|field| {
        let values = field.values.iter().map(|distance| BY * distance).collect();
        Arc::new(DistanceField { grid: grid(&field.grid), values })
    });
    enlarged.closest = subject.closest.as_ref().map(|closest| {
        let points = closest.points.iter().map(|point| BY * *point).collect();
        Arc::new(ClosestPoints { grid: grid(&closest.grid), points })
    });
    enlarged
}

/// Differences between the pictures of a scene and its equivalents.
pub(super) fn rows(gpu: &Gpu, library: &Library, scene: &Scene, setting: &str) -> Result<Vec<Row>, CaseError> {
    let subject = Subject::load(scene, library, &|_| ())?;
    let mut renderer = Renderer::new(gpu, library, &subject);
    let frame = renderer.render(scene)?;
    let mut rows = Rows::default();
    let mut add = |what: &str, bound: f64, pair: Result<[Frame; 2], RenderError>| match pair {
        Ok([one, other]) => {
            rows.worst(what, setting, same(&one, &other, bound));
        }
        Err(error) => rows.holds(what, setting, "the same picture", error.to_string(), false),
    };
    for Equivalence { what, bound, pair } in EQUIVALENCES {
        let is_valid = |pair: &[Scene; 2]| pair.iter().all(|scene| scene.check(library).is_ok());
        if let Some([one, other]) = pair(scene, library).filter(is_valid) {
            let one = if one == *scene { Ok(frame.clone()) } else { renderer.render(&one) };
            add(what, bound, one.and_then(|one| Ok([one, renderer.render(&other)?])));
        }
    }
    if subject.field.is_some() && subject.parts.is_empty() {
        let other = Renderer::new(gpu, library, &enlarged(&subject)).render(scene);
        add("a world of larger units", 0.0, other.map(|other| [frame.clone(), other]));
    }
    let [width, height] = scene.image.size;
    let cuts = [0, height / 3, height - height / 4, height];
    let mut pixels = Vec::new();
    for rows in cuts.windows(2).map(|rows| rows[0]..rows[1]).filter(|rows| !rows.is_empty()) {
        let of_rows = (rows.start * width) as usize..(rows.end * width) as usize;
        pixels.extend_from_slice(&renderer.render_bands(scene, &[rows])?.pixels[of_rows]);
    }
    add("drawn in bands", 0.0, Ok([frame.clone(), Frame { pixels, ..frame.clone() }]));
    if let Some(moved) = periods_away(scene, library) {
        let what = "noise whole periods away";
        match Renderer::new(gpu, &moved, &subject).render(scene) {
            Ok(other) => {
                rows.worst(what, setting, [(0.0, rms_difference(&frame.pixels, &other.pixels), MOVED)]);
            }
            Err(error) => rows.holds(what, setting, "the same picture", error.to_string(), false),
        }
    }
    Ok(rows.into_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::gpu::Options;
    use hypertexture::scene::preset;
    use hypertexture::shader::shipped;

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn noise_that_repeats_is_the_same_whole_periods_away() {
        let gpu = Gpu::new(&Options::from_env()).unwrap();
        let away = |library: &Library, name: &str, noise: &str, turbulence: &str| {
            let mut scene = preset(name).unwrap();
            (scene.effect.noise, scene.effect.turbulence) = (noise.into(), turbulence.into());
            (scene.image.size, scene.quality.samples) = ([32, 32], 48);
            let rows = rows(&gpu, library, &scene, "").unwrap();
            rows.into_iter().find(|row| row.what.contains("whole periods")).map(|row| (row.ok, row.error, row.found))
        };
        let library = shipped();
        for noise in ["block", "tables"] {
            let found = away(&library, "noisy_sphere", noise, "procedural");
            assert!(found.as_ref().is_some_and(|(ok, ..)| *ok), "{noise}: {found:?}");
        }
        for turbulence in ["encoded", "channels", "lookups4"] {
            let found = away(&library, "fire_ball", "procedural", turbulence);
            assert!(found.as_ref().is_some_and(|(ok, ..)| *ok), "{turbulence}: {found:?}");
        }
        assert_eq!(away(&library, "noisy_sphere", "procedural", "procedural"), None, "endless noise");
        let endless =
            library.source("noise/procedural.glsl").unwrap().replace("// @loops 1", "// @loops 1\n// @period memory");
        let found = away(&library.with_module("noise", "tables", &endless), "noisy_sphere", "tables", "procedural");
        assert!(found.as_ref().is_some_and(|(ok, error, _)| !ok && *error > 0.01), "{found:?}");
    }
}
