//! A picture on disk against its own scene, with two verdicts: whether it is what the scene gives here, and how accurate
//! that is.
//!
//! Role: the scene is drawn again, in the encoding of the file; and random pixels are held against a truth, where a person
//! sees them: colors of a PNG count as much as their alpha. Invariant: on the device that drew the picture no code differs;
//! elsewhere a pixel may round another way, or be of the other side of an edge, but has no value that is not around it.

use super::agreement::Agreement;
use super::redrawn::{Redrawn, apart, around, index, redraw};
use crate::metric::{Errors, Metric, NotFinite};
use crate::reference::Reference;
use crate::statistics::largest;
use hypertexture::field::Progress;
use hypertexture::gpu::Gpu;
use hypertexture::output::{self, OutputError, PROGRAM, Stored};
use hypertexture::render::{Frame, RenderError, Subject, render};
use hypertexture::scene::{Reach, Scene, SceneError};
use hypertexture::shader::Library;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use support::random::SplitMix;

/// A pixel may be off by so many times what the step explains around it, and a picture by so many times what it explains
/// on the mean. Fewer: a kink that the step happens to meet looks like an error. More: an error looks like a kink.
const STEPS: f64 = 4.0;
/// No step and no end of a ray explains a larger root mean square than this: a picture beyond it is not of its scene.
const MOST: f64 = 0.1;
/// What the rounding of f32 may add up to.
const ROUNDING: f64 = 1e-5;

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct CheckOptions {
    /// Pixels to be held against the truth.
    pub pixels: u32,
    /// Which ones.
    pub seed: u64,
    /// The root mean square that is allowed; without one, the most that any step explains.
    pub bound: Option<f64>,
    /// Files that its scene may name.
    pub reach: Reach,
}

/// What some pixels really are.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The pixels that were asked for, without the background.
    pub reference: Reference,
    /// What knows them.
    pub source: &'static str,
}

/// Says what some pixels of a scene are.
pub type Knows<'a> = &'a dyn Fn(&Scene, &Subject, &[[u32; 2]], Progress<'_>) -> Result<Truth, Box<dyn Error>>;

/// Why a picture cannot be checked.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// It cannot be read, or does not say where it comes from.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Its scene is not valid in this version.
    #[error("{path}: {source}")]
    Scene {
        /// The picture.
        path: String,
        /// What is wrong.
        source: Box<SceneError>,
    },
    /// Its scene cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// It was scaled or cut.
    #[error("{path} has {} x {} pixels, and its scene {} x {}: it was scaled or cut, and its pixels are no longer those of the scene", size[0], size[1], said[0], said[1])]
    Size {
        /// The picture.
        path: String,
        /// Width and height of the file.
        size: [u32; 2],
        /// Those of the scene.
        said: [u32; 2],
    },
    /// Some of its pixels are NaN or infinite.
    #[error("{path}: this is not what its scene gives: {found}")]
    NotFinite {
        /// The picture.
        path: String,
        /// How many, and where.
        found: NotFinite,
    },
    /// The truth is not to be had.
    #[error("no truth for this picture: {0}")]
    Truth(Box<dyn Error>),
}

/// Pixels of a picture, each once: as many as asked for, or all of them.
pub fn draw_pixels(size: [u32; 2], count: u32, seed: u64) -> Vec<[u32; 2]> {
    let all = u64::from(size[0]) * u64::from(size[1]);
    let mut random = SplitMix(seed);
    // The first of a shuffle, of which only what was exchanged is kept.
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

/// Holds a picture against its scene. `truth` says what the asked pixels of a scene are.
///
/// # Errors
/// [`CheckError`].
pub fn check(
    gpu: &Gpu,
    library: &Library,
    path: &Path,
    asked: &CheckOptions,
    progress: Progress<'_>,
    truth: Knows<'_>,
) -> Result<Agreement, CheckError> {
    let provenance = output::read_provenance(path)?;
    let name = || path.display().to_string();
    let of = |source| OutputError::Provenance { path: name(), source };
    let scene = provenance.scene(path, asked.reach).map_err(of)?;
    provenance.check_inputs(path, asked.reach).map_err(of)?;
    scene.check(library).map_err(|source| CheckError::Scene { path: name(), source: source.into() })?;
    // Before it is decoded: a small file may hold a huge picture.
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
    let redrawn = redraw(&stored, &scene, &drawn, same_device);
    Ok(compare(&stored, &scene, &redrawn, &step, (&pixels, &truth), asked.bound))
}

/// The scene with twice the samples, or half of them where a ray cannot have so many; and by what its difference is to
/// be multiplied to give the error of the scene, where that is of first order.
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

/// Two drawings of a scene that differ in their step.
struct Step<'a> {
    drawn: &'a Frame,
    other: &'a Frame,
    /// What their difference is to be multiplied by to give the error of the first.
    share: f64,
}

/// The agreement of a picture with the truth.
fn compare(
    stored: &Stored,
    scene: &Scene,
    redrawn: &Redrawn,
    step: &Step<'_>,
    (pixels, truth): (&[[u32; 2]], &Truth),
    bound: Option<f64>,
) -> Agreement {
    let Stored { size, encoding, .. } = *stored;
    let background = scene.image.background;
    let seen = |pixel: [f32; 4]| encoding.of(pixel, background);
    let shown = |pixel: [f32; 4]| encoding.linear(pixel).map(f64::from);
    let exact: Vec<[f32; 4]> =
        truth.reference.pixels.iter().map(|pixel| seen(pixel.map(|channel| channel as f32))).collect();
    let found: Vec<[f32; 4]> = pixels.iter().map(|&at| stored.pixels[index(size, at)]).collect();
    let [drawn, other] = [step.drawn, step.other].map(|frame| |at| seen(frame.pixels[index(size, at)]));

    let explained = |at: [u32; 2]| step.share * largest(apart(drawn(at), other(at), encoding));
    let is_explained = |(index, &at): (usize, &[u32; 2])| {
        let off = largest(apart(found[index], exact[index], encoding));
        let most = STEPS * largest(around(size, at).map(explained));
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
    Agreement {
        encoding,
        samples: scene.quality.samples,
        redrawn: [redrawn.differs, stored.pixels.len()],
        foreign: redrawn.foreign,
        redrawn_worst: redrawn.worst,
        same_device: redrawn.same_device,
        source: truth.source,
        pixels: pixels.len(),
        errors: between(&found, &exact),
        metric,
        worst: worst.map_or([0, 0], |index| pixels[index]),
        codes: between(&rounded, &exact).by(metric),
        step: step.share * between(&drawn, &other).by(metric),
        own: [truth.reference.error(), truth.reference.bound()],
        proven: truth.reference.proven(),
        beyond,
        bound: bound.unwrap_or(MOST + f64::from(scene.quality.early_termination)),
        asked: bound.is_some(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::output::Encoding;

    #[test]
    fn pixels_are_drawn_once_each_and_again_by_their_seed() {
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
    fn the_rounding_to_codes_is_what_it_is_said_to_explain() {
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
        let truth = |off: f64| Truth {
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
            let redrawn = redraw(stored, &scene, &drawn, same);
            compare(stored, &scene, &redrawn, &step, (&pixels, &truth(off)), bound)
        };
        let exact = agree(&stored, 0.0, None, true);
        assert!(exact.is_of_scene() && exact.is_accurate() && exact.redrawn == [0, 4096], "{exact:?}");
        assert!((exact.error() / exact.codes - 1.0).abs() < 1e-6 && exact.beyond == 0, "{exact:?}");
        // Half a code at white, where sRGB is steepest: 2.4 / 1.055 of the linear light.
        assert!(exact.errors.max <= 0.502 / 255.0 * 2.4 / 1.055 && exact.errors.max > 0.4 / 255.0, "{exact:?}");
        assert!(!agree(&stored, 5e-3, Some(4e-3), true).is_accurate());
        assert!(!agree(&stored, 0.3, None, true).is_accurate() && agree(&stored, 5e-3, None, true).is_accurate());
        // One altered pixel is enough, wherever it is; another device may round it so.
        stored.pixels[77][1] += 1.0 / 255.0;
        let altered = agree(&stored, 0.0, None, true);
        assert!(!altered.is_of_scene() && altered.redrawn[0] == 1 && altered.redrawn_worst.0 == [13, 1], "{altered:?}");
        assert!(agree(&stored, 0.0, None, false).is_of_scene());
        // But not so far, where nothing around it is like it.
        stored.pixels[77][1] += 40.0 / 255.0;
        let altered = agree(&stored, 0.0, None, false);
        assert!(!altered.is_of_scene() && altered.foreign == 1, "{altered:?}");
    }

    #[test]
    fn another_device_may_put_a_pixel_to_the_other_side_of_an_edge_and_few_of_them() {
        let encoding = Encoding::Codes(255);
        let half = |x: usize| if x < 32 { [0.0, 0.0, 0.0, 1.0] } else { [1.0; 4] };
        let linear: Vec<[f32; 4]> = (0..4096).map(|i| half(i % 64)).collect();
        let mut scene = Scene::default();
        scene.image.size = [64, 64];
        let drawn = Frame { size: [64, 64], pixels: linear.clone(), measurements: Default::default() };
        let of_scene = |rows: usize| {
            let mut pixels = linear.clone();
            (0..rows).for_each(|y| pixels[64 * y + 32] = half(0));
            let redrawn = redraw(&Stored { size: [64, 64], pixels, encoding }, &scene, &drawn, false);
            (redrawn.differs, redrawn.foreign)
        };
        assert_eq!((of_scene(20), of_scene(64)), ((20, 0), (64, 0)));
    }
}
