//! The comparison of a picture with its scene.
//!
//! Role: renders the scene again in the encoding of the file, and compares random pixels with the ground truth; colors of a
//! PNG are weighted by their alpha. Invariant: on the device of the picture no code differs; on another one a pixel may
//! round differently or lie on the other side of an edge, within the range of its neighbors.

use super::rerender::{Difference, compare_rendering, difference, index, neighborhood};
use super::verdict::Verdict;
use crate::metric::{Errors, Metric, NotFinite};
use crate::reference::Reference;
use crate::statistics::largest;
use hypertexture::field::Progress;
use hypertexture::gpu::Gpu;
use hypertexture::output::{self, OutputError, PROGRAM, Stored};
use hypertexture::render::{Frame, RenderError, Subject, render};
use hypertexture::scene::{Reach, Scene, SceneError};
use hypertexture::shader::Library;
use hypertexture_support::random::SplitMix;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

/// Error of a pixel, relative to that of the step in its neighborhood, from which it counts as unexplained. Lower: kinks
/// that a step happens to meet count as errors. Higher: errors count as kinks.
const STEPS: f64 = 4.0;
/// Default bound of the error: the largest that steps explain.
const DEFAULT_BOUND: f64 = 0.1;
/// Accumulated rounding of f32.
const ROUNDING: f64 = 1e-5;

/// Options of [`check`].
#[derive(Clone, Copy, Debug)]
pub struct CheckOptions {
    /// Number of pixels to compare with the ground truth.
    pub pixels: u32,
    /// Seed of their choice.
    pub seed: u64,
    /// Largest error allowed; the default is the largest that steps explain.
    pub bound: Option<f64>,
    /// Files that the scene may name.
    pub reach: Reach,
}

/// Ground truth of some pixels.
#[derive(Clone, Debug)]
pub struct PixelTruth {
    /// The pixels, without the background.
    pub reference: Reference,
    /// Source in words.
    pub source: &'static str,
}

/// Computes the ground truth of some pixels of a scene.
pub type GroundTruth<'a> =
    &'a dyn Fn(&Scene, &Subject, &[[u32; 2]], Progress<'_>) -> Result<PixelTruth, Box<dyn Error>>;

/// Failure to check a picture.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The picture cannot be read, or has no provenance.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The scene is not valid in this version.
    #[error("{path}: {source}")]
    Scene {
        /// The picture.
        path: String,
        /// Cause.
        source: Box<SceneError>,
    },
    /// The scene cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The picture was scaled or cropped.
    #[error("{path} has {} x {} pixels, and its scene {} x {}: it was scaled or cut, and its pixels are no longer those of the scene", size[0], size[1], said[0], said[1])]
    Size {
        /// The picture.
        path: String,
        /// Width and height of the file.
        size: [u32; 2],
        /// Width and height of the scene.
        said: [u32; 2],
    },
    /// Some pixels are NaN or infinite.
    #[error("{path}: its scene gives another picture: {found}")]
    NotFinite {
        /// The picture.
        path: String,
        /// Their number and the first place.
        found: NotFinite,
    },
    /// The ground truth is missing.
    #[error("no truth for this picture: {0}")]
    Truth(Box<dyn Error>),
}

/// Random distinct pixels of a picture; all of them if `count` is larger.
pub(crate) fn draw_pixels(size: [u32; 2], count: u32, seed: u64) -> Vec<[u32; 2]> {
    let all = u64::from(size[0]) * u64::from(size[1]);
    let mut random = SplitMix(seed);
    // The beginning of a Fisher-Yates shuffle; only exchanged places are stored.
    let mut exchanged: BTreeMap<u64, u64> = BTreeMap::new();
    let picked = (0..all.min(u64::from(count))).map(|first| {
        let other = first + random.bits() % (all - first);
        let at = |exchanged: &BTreeMap<u64, u64>, place| exchanged.get(&place).copied().unwrap_or(place);
        let (pick, displaced) = (at(&exchanged, other), at(&exchanged, first));
        exchanged.insert(other, displaced);
        [(pick % u64::from(size[0])) as u32, (pick / u64::from(size[0])) as u32]
    });
    picked.collect()
}

/// Compares a picture with its scene. `truth` computes the ground truth of pixels.
///
/// # Errors
/// [`CheckError`].
pub fn check(
    gpu: &Gpu,
    library: &Library,
    path: &Path,
    asked: &CheckOptions,
    progress: Progress<'_>,
    truth: GroundTruth<'_>,
) -> Result<Verdict, CheckError> {
    let provenance = output::read_provenance(path)?;
    let name = || path.display().to_string();
    let of = |source| OutputError::Provenance { path: name(), source };
    let scene = provenance.scene(path, asked.reach).map_err(of)?;
    provenance.check_inputs(path, asked.reach).map_err(of)?;
    scene.check(library).map_err(|source| CheckError::Scene { path: name(), source: source.into() })?;
    // Before decoding: a small file may hold a huge picture.
    let size = output::size(path)?;
    if size != scene.image.size {
        return Err(CheckError::Size { path: name(), size, said: scene.image.size });
    }
    let stored = output::read(path)?;
    if let Some(found) = NotFinite::of(&stored.pixels, size[0]) {
        return Err(CheckError::NotFinite { path: name(), found });
    }
    let subject = Subject::load(&scene, library, &|done| progress(0.3 * done))?;
    let drawn = render(gpu, library, &scene, &subject)?;
    progress(0.4);
    let (other, share) = other_samples(&scene, library);
    let other = render(gpu, library, &other, &subject)?;
    progress(0.5);
    let pixels = draw_pixels(scene.image.size, asked.pixels, asked.seed);
    let truth = truth(&scene, &subject, &pixels, &|done| progress(0.5 + 0.5 * done)).map_err(CheckError::Truth)?;
    let same_device = provenance.program == PROGRAM && provenance.device == gpu.info().title();
    let step = Step { drawn: &drawn, other: &other, share };
    let rerendered = compare_rendering(&stored, &scene, &drawn, same_device);
    Ok(compare(&stored, &scene, &rerendered, &step, (&pixels, &truth), asked.bound))
}

/// The scene with twice the samples, or half where a ray cannot have twice; and the factor from the difference of the two
/// to the error of the scene at first order.
fn other_samples(scene: &Scene, library: &Library) -> (Scene, f64) {
    let with = |samples| {
        let mut other = scene.clone();
        other.quality.samples = samples;
        other
    };
    let more = with(scene.quality.samples.saturating_mul(2));
    match more.check(library) {
        Ok(_) => (more, 2.0),
        Err(_) => (with((scene.quality.samples / 2).max(1)), 1.0),
    }
}

/// Two renderings of a scene that differ in their step.
struct Step<'a> {
    drawn: &'a Frame,
    other: &'a Frame,
    /// Factor from their difference to the error of the first.
    share: f64,
}

/// The verdict on a picture.
fn compare(
    stored: &Stored,
    scene: &Scene,
    rerendered: &Difference,
    step: &Step<'_>,
    (pixels, truth): (&[[u32; 2]], &PixelTruth),
    bound: Option<f64>,
) -> Verdict {
    let Stored { size, encoding, .. } = *stored;
    let background = scene.image.background;
    let seen = |pixel: [f32; 4]| encoding.of(pixel, background);
    let shown = |pixel: [f32; 4]| encoding.linear(pixel).map(f64::from);
    let exact: Vec<[f32; 4]> =
        truth.reference.pixels.iter().map(|pixel| seen(pixel.map(|channel| channel as f32))).collect();
    let found: Vec<[f32; 4]> = pixels.iter().map(|&at| stored.pixels[index(size, at)]).collect();
    let [drawn, other] = [step.drawn, step.other].map(|frame| |at| seen(frame.pixels[index(size, at)]));

    let explained = |at: [u32; 2]| step.share * largest(difference(drawn(at), other(at), encoding));
    let is_explained = |(index, &at): (usize, &[u32; 2])| {
        let off = largest(difference(found[index], exact[index], encoding));
        let most = STEPS * largest(neighborhood(size, at).map(explained));
        off <= 0.5 * encoding.quantum() + most + truth.reference.estimate[index] + ROUNDING
    };
    let beyond = pixels.iter().enumerate().filter(|pixel| !is_explained(*pixel)).count();

    let between =
        |a: &[[f32; 4]], b: &[[f32; 4]]| Errors::of(a.iter().zip(b).map(|(a, b)| (shown(*a), shown(*b), 1.0)));
    let metric = if background.is_some() { Metric::Rgb } else { Metric::Rmse };
    let rounded: Vec<[f32; 4]> = exact.iter().map(|pixel| encoding.rounded(*pixel)).collect();
    let [drawn, other]: [Vec<[f32; 4]>; 2] =
        [pixels.iter().map(|&at| drawn(at)).collect(), pixels.iter().map(|&at| other(at)).collect()];
    let off = |index: usize| largest((0..4).map(|c| (shown(found[index])[c] - shown(exact[index])[c]).abs()));
    let worst = (0..pixels.len()).max_by(|&a, &b| off(a).total_cmp(&off(b)));
    Verdict {
        encoding,
        samples: scene.quality.samples,
        rerendered: [rerendered.differs, stored.pixels.len()],
        foreign: rerendered.foreign,
        rerendered_worst: rerendered.worst,
        same_device: rerendered.same_device,
        source: truth.source,
        pixels: pixels.len(),
        errors: between(&found, &exact),
        metric,
        worst: worst.map_or([0, 0], |index| pixels[index]),
        codes: between(&rounded, &exact).by(metric),
        step: step.share * between(&drawn, &other).by(metric),
        truth_error: [truth.reference.error(), truth.reference.bound()],
        proven: truth.reference.proven(),
        beyond,
        bound: bound.unwrap_or(DEFAULT_BOUND + f64::from(scene.quality.early_termination)),
        asked: bound.is_some(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::output::Encoding;

    #[test]
    fn pixels_are_distinct_and_repeat_with_their_seed() {
        let drawn = draw_pixels([30, 20], 250, 7);
        let mut sorted = drawn.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!((drawn.len(), sorted.len()), (250, 250));
        assert!(drawn.iter().all(|[x, y]| *x < 30 && *y < 20));
        assert_eq!(draw_pixels([30, 20], 250, 7), drawn);
        assert_ne!(draw_pixels([30, 20], 250, 8), drawn);
        assert_eq!(draw_pixels([3, 2], 100, 0).len(), 6);
    }

    #[test]
    fn rounding_to_codes_is_explained() {
        // A ramp in linear light, rounded to 8 bits as a writer does.
        let encoding = Encoding::Codes(255);
        let linear: Vec<[f32; 4]> =
            (0..4096).map(|i| [i as f32 / 4095.0, 0.3, 0.1 + 0.2 * (i % 7) as f32, 1.0]).collect();
        let rounded = |pixel: &[f32; 4]| encoding.rounded(encoding.of(*pixel, None));
        let mut stored = Stored { size: [64, 64], pixels: linear.iter().map(rounded).collect(), encoding };
        let mut scene = Scene::default();
        scene.image.size = [64, 64];
        let drawn = Frame { size: [64, 64], pixels: linear.clone(), measurements: Default::default() };
        let pixels = draw_pixels([64, 64], 4096, 0);
        let moved = |at: &[u32; 2], off: f64| linear[index([64, 64], *at)].map(|c| f64::from(c) + off);
        let truth = |off: f64| PixelTruth {
            reference: Reference {
                size: [64, 64],
                pixels: pixels.iter().map(|at| moved(at, off)).collect(),
                estimate: vec![0.0; 4096],
                open: vec![0.0; 4096],
            },
            source: "the test",
        };
        let step = Step { drawn: &drawn, other: &drawn, share: 1.0 };
        let agree = |stored: &Stored, off: f64, bound, same| {
            let rerendered = compare_rendering(stored, &scene, &drawn, same);
            compare(stored, &scene, &rerendered, &step, (&pixels, &truth(off)), bound)
        };
        let exact = agree(&stored, 0.0, None, true);
        assert!(exact.is_of_scene() && exact.is_accurate() && exact.rerendered == [0, 4096], "{exact:?}");
        assert!((exact.error() / exact.codes - 1.0).abs() < 1e-6 && exact.beyond == 0, "{exact:?}");
        // Half a code at white, where sRGB is steepest: 2.4 / 1.055 of the linear light.
        assert!(exact.errors.max <= 0.502 / 255.0 * 2.4 / 1.055 && exact.errors.max > 0.4 / 255.0, "{exact:?}");
        assert!(!agree(&stored, 5e-3, Some(4e-3), true).is_accurate());
        assert!(!agree(&stored, 0.3, None, true).is_accurate() && agree(&stored, 5e-3, None, true).is_accurate());
        // One altered pixel is enough; another device may round it that way.
        stored.pixels[77][1] += 1.0 / 255.0;
        let altered = agree(&stored, 0.0, None, true);
        assert!(
            !altered.is_of_scene() && altered.rerendered[0] == 1 && altered.rerendered_worst.0 == [13, 1],
            "{altered:?}"
        );
        assert!(agree(&stored, 0.0, None, false).is_of_scene());
        // Beyond the range of its neighbors it is an error on any device.
        stored.pixels[77][1] += 40.0 / 255.0;
        let altered = agree(&stored, 0.0, None, false);
        assert!(!altered.is_of_scene() && altered.foreign == 1, "{altered:?}");
    }

    #[test]
    fn few_edge_pixels_may_differ_on_another_device() {
        let encoding = Encoding::Codes(255);
        let half = |x: usize| if x < 32 { [0.0, 0.0, 0.0, 1.0] } else { [1.0; 4] };
        let linear: Vec<[f32; 4]> = (0..4096).map(|i| half(i % 64)).collect();
        let mut scene = Scene::default();
        scene.image.size = [64, 64];
        let drawn = Frame { size: [64, 64], pixels: linear.clone(), measurements: Default::default() };
        let of_scene = |rows: usize| {
            let mut pixels = linear.clone();
            (0..rows).for_each(|y| pixels[64 * y + 32] = half(0));
            let rerendered = compare_rendering(&Stored { size: [64, 64], pixels, encoding }, &scene, &drawn, false);
            (rerendered.differs, rerendered.foreign)
        };
        assert_eq!((of_scene(20), of_scene(64)), ((20, 0), (64, 0)));
    }
}
