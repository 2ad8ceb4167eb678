//! What a picture will cost, from small ones.
//!
//! Role: render a ladder of probes, 32 pixels along the longest side and up, and extrapolate: a fixed cost (program,
//! upload), and one that grows with the number of pixels. Invariant: a probe is the scene itself, smaller; it differs in
//! nothing else. Source: PH 3.1 (seconds at 32 x 32 foretell hours at 512 x 512).
//!
//! How good it is, on lavapipe with two cores that others used as well: of 48 pictures (lit, fur, fire and melting on a
//! teapot and a torus, both passes, 256 to 768 pixels wide), 47 took a time inside the interval, and half of them
//! between 0.7 and 1.12 times the best guess.

use hypertexture::render::{RenderError, Renderer};
use hypertexture::scene::{Pass, Scene};
use serde::Serialize;
use std::time::Instant;

/// Longest side of the smallest probe, pixels.
const FIRST_SIDE: u32 = 32;
/// Probing goes on while the next probe should end within this many milliseconds from the start. Less: the largest
/// probe is too small to keep a device busy, and what it takes says little. More: nobody waits for a prediction.
const BUDGET_MS: f64 = 1200.0;
/// Each time that the number of pixels grows to four times that of the largest probe, the truth may be this much less
/// than the extrapolation, and this much more. Nearer to 1: devices that only a large picture fills, and objects that
/// only a large picture resolves, fall outside. Farther: the interval says nothing.
const PER_QUADRUPLING: [f64; 2] = [0.7, 1.25];
/// What a busy machine adds, whatever the probes say.
const NOISE: f64 = 1.2;
/// Milliseconds to read back and decode a million pixels, at most: too short to be seen in a probe.
const READ_MS: f64 = 250.0;

/// A number that is not known yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Hardly less than this.
    pub low: f64,
    /// The best guess.
    pub expected: f64,
    /// Hardly more than this.
    pub high: f64,
}

/// A small picture that was rendered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Probe {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Milliseconds on the device.
    pub device_ms: f64,
    /// Milliseconds of everything else.
    pub fixed_ms: f64,
    /// Fragments shaded, where the device counts them.
    pub fragments: Option<u64>,
}

/// What a picture will cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// The probes, from the smallest; the first one compiled the program.
    pub probes: Vec<Probe>,
    /// Milliseconds of the probes together.
    pub spent_ms: f64,
    /// Milliseconds of the slices or rays on the device.
    pub device_ms: Estimate,
    /// Milliseconds of a rendering as [`hypertexture::render::render`] measures it: without the distance field, and without
    /// writing a file.
    pub total_ms: Estimate,
    /// Slices, or samples of a ray at most.
    pub slices: u32,
    /// Fragments of all slices, or rays; `None` where the device does not count fragments.
    pub fragments: Option<Estimate>,
}

/// Predicts what a scene will cost, in about a second, or in the time of three probes of 32 pixels if that is longer.
///
/// # Errors
/// As [`hypertexture::render::render`].
pub fn predict(renderer: &mut Renderer, scene: &Scene) -> Result<Prediction, RenderError> {
    let start = Instant::now();
    let mut small = scene.clone();
    let (mut probes, mut slices) = (Vec::new(), 0);
    renderer.preview_of(scene.image.size);
    let mut probe = |side: u32| -> Result<(Probe, f64), RenderError> {
        small.image.size = fit(scene.image.size, side);
        let m = renderer.render(&small)?.measurements;
        slices = m.slices;
        let fixed_ms = m.total_ms - m.gpu_ms;
        Ok((Probe { size: small.image.size, device_ms: m.gpu_ms, fixed_ms, fragments: m.fragments }, m.total_ms))
    };
    let longest = scene.image.size[0].max(scene.image.size[1]);
    let mut side = FIRST_SIDE.min(longest);
    probes.push(probe(side)?.0);
    loop {
        let (last, total_ms) = probe(side)?;
        probes.push(last);
        let spent_ms = start.elapsed().as_secs_f64() * 1e3;
        // A probe of four times the pixels, once to climb and once more to see the spread.
        let climb_ms = total_ms + 3.0 * last.device_ms;
        if 2 * side < longest && (probes.len() < 3 || spent_ms + climb_ms < BUDGET_MS) {
            side *= 2;
        } else if probes.len() < 3 || spent_ms + total_ms < BUDGET_MS && probes.len() < 12 {
            continue;
        } else {
            break;
        }
    }
    let spent_ms = start.elapsed().as_secs_f64() * 1e3;
    let device_ms = device(&probes, scene.image.size);
    let fixed = probes.iter().map(|probe| probe.fixed_ms);
    let (least, most) = (fixed.clone().fold(f64::INFINITY, f64::min), fixed.fold(0.0, f64::max));
    let total_ms = Estimate {
        low: least / NOISE + device_ms.low,
        expected: probes[0].fixed_ms + device_ms.expected,
        high: most * NOISE + READ_MS * 1e-6 * pixels(scene.image.size) + device_ms.high,
    };
    let fragments = match scene.quality.pass {
        Pass::March => Some(exactly(pixels(scene.image.size))),
        Pass::Slices => fragments(&probes, scene.image.size),
    };
    Ok(Prediction { probes, spent_ms, device_ms, total_ms, slices, fragments })
}

/// The size of a picture whose longest side is `side`, with the aspect of `size`.
fn fit(size: [u32; 2], side: u32) -> [u32; 2] {
    let longest = f64::from(size[0].max(size[1]));
    size.map(|own| ((f64::from(own) * f64::from(side) / longest).round() as u32).max(1))
}

fn pixels([width, height]: [u32; 2]) -> f64 {
    f64::from(width) * f64::from(height)
}

fn exactly(value: f64) -> Estimate {
    Estimate { low: value, expected: value, high: value }
}

/// Pixels, and the least, mean and most milliseconds of the probes of each size; the first probe warmed up.
fn rungs(probes: &[Probe]) -> Vec<(f64, [f64; 3])> {
    let warm = &probes[1..];
    let same = warm.chunk_by(|a, b| a.size == b.size);
    same.map(|same| {
        let ms = same.iter().map(|probe| probe.device_ms);
        let mean = ms.clone().sum::<f64>() / same.len() as f64;
        (pixels(same[0].size), [ms.clone().fold(f64::INFINITY, f64::min), mean, ms.fold(0.0, f64::max)])
    })
    .collect()
}

/// A line through the two largest sizes: small pictures pay for the start of each submission.
fn device(probes: &[Probe], size: [u32; 2]) -> Estimate {
    let rungs = rungs(probes);
    let (most, [least_ms, ms, most_ms]) = rungs[rungs.len() - 1];
    let ratio = (pixels(size) / most).max(1.0);
    let in_proportion = ms / most;
    let slope = match rungs.len().checked_sub(2).map(|index| rungs[index]) {
        Some((fewer, [_, less_ms, _])) => {
            ((ms - less_ms) / (most - fewer)).clamp(0.5 * in_proportion, 1.1 * in_proportion)
        }
        None => in_proportion,
    };
    let expected = ms + slope * most * (ratio - 1.0);
    let [low, high] = PER_QUADRUPLING.map(|factor: f64| factor.powf(ratio.log(4.0)));
    Estimate { low: expected * low * least_ms / ms / NOISE, expected, high: expected * high * most_ms / ms * NOISE }
}

/// The fragments of the inside of the object grow with the pixels, those on the edges of its triangles with their root.
fn fragments(probes: &[Probe], size: [u32; 2]) -> Option<Estimate> {
    let counted: Vec<(f64, f64)> =
        probes.iter().map(|probe| Some((pixels(probe.size), probe.fragments? as f64))).collect::<Option<_>>()?;
    let &(most, count) = counted.last()?;
    let in_proportion = count * pixels(size) / most;
    let Some(&(fewer, less)) = counted.iter().rev().find(|(pixels, _)| *pixels < most) else {
        return Some(Estimate { low: 0.7 * in_proportion, expected: in_proportion, high: in_proportion });
    };
    let inside = (count / most.sqrt() - less / fewer.sqrt()) / (most.sqrt() - fewer.sqrt());
    let edge = (count - inside * most) / most.sqrt();
    let expected = inside * pixels(size) + edge * pixels(size).sqrt();
    let (low, high) = (inside * pixels(size), in_proportion);
    Some(Estimate { low: low.min(high) * 0.95, expected, high: low.max(high) * 1.02 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probes(cost: impl Fn(f64) -> f64) -> Vec<Probe> {
        let probe = |side: u32| {
            let size = [side; 2];
            Probe { size, device_ms: cost(pixels(size)), fixed_ms: 200.0, fragments: Some(cost(pixels(size)) as u64) }
        };
        [32, 32, 64, 128, 128].map(probe).to_vec()
    }

    #[test]
    fn p51_a_cost_that_grows_with_the_pixels_is_found_exactly() {
        let found = device(&probes(|pixels| 3.0 + 2e-3 * pixels), [512, 512]);
        assert!((found.expected - (3.0 + 2e-3 * 262_144.0)).abs() < 1e-6, "{found:?}");
        assert!(found.low < found.expected && found.expected < found.high);
    }

    #[test]
    fn p51_fragments_on_edges_grow_with_the_side() {
        let truth = |pixels: f64| 60.0 * pixels + 2000.0 * pixels.sqrt();
        let found = fragments(&probes(truth), [512, 512]).unwrap();
        assert!((found.expected / truth(262_144.0) - 1.0).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_probe_keeps_the_aspect() {
        assert_eq!(fit([800, 600], 32), [32, 24]);
        assert_eq!(fit([9, 3000], 32), [1, 32]);
    }
}
