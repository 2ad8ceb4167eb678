//! Time of a picture, predicted from smaller ones.
//!
//! Role: [`predict`] renders the scene in doubling sizes for about a second and scales the largest by its pixels. Invariant:
//! a probe differs from the scene in nothing but its size. Source: PH 3.1 (seconds at 32 x 32 predict hours at 512 x 512).

use hypertexture::render::{Measurements, RenderError, Renderer};
use hypertexture::scene::{Pass, Scene};
use serde::Serialize;
use std::time::Instant;

/// Longest side of the smallest probe, pixels.
const FIRST_SIDE: u32 = 32;
/// Milliseconds for probes after the first one, which compiles. Lower: the largest probe does not fill a device. Higher:
/// predicting takes too long to be useful.
const BUDGET_MS: f64 = 1200.0;
/// Range of the time per pixel where a picture has four times the pixels of the probe, relative to that of the probe.
/// Closer to 1: devices that only a large picture fills fall outside. Wider: the interval says nothing.
const PER_QUADRUPLING: [f64; 2] = [0.6, 1.25];
/// The same range of fragments per pixel: those at the edges of triangles grow with the side alone.
const FRAGMENTS_PER_QUADRUPLING: [f64; 2] = [0.8, 1.02];
/// Factor for the load of other programs.
const NOISE: f64 = 1.2;
/// Upper bound of the milliseconds to read back and decode a million pixels, which probes are too small to show.
const READ_MS: f64 = 250.0;

/// An estimate and its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Lower end of the interval.
    pub low: f64,
    /// Best guess.
    pub expected: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Estimate {
    /// Scales a value of the probe to a picture of `ratio` times its pixels.
    fn scaled(value: f64, ratio: f64, per_quadrupling: [f64; 2]) -> Estimate {
        let expected = value * ratio;
        let [low, high] = per_quadrupling.map(|factor| expected * factor.powf(ratio.log(4.0)));
        Estimate { low, expected, high }
    }
}

/// Predicted cost of a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Width and height of the largest probe.
    pub probe: [u32; 2],
    /// Milliseconds spent on all probes.
    pub spent_ms: f64,
    /// Milliseconds of the slices or rays on the device.
    pub device_ms: Estimate,
    /// Milliseconds of [`hypertexture::render::render`]: without the distance field and without writing a file.
    pub total_ms: Estimate,
    /// Slices, or the most samples of a ray.
    pub slices: u32,
    /// Fragments of all slices, or rays; `None` where the device does not count fragments.
    pub fragments: Option<Estimate>,
}

/// Predicts the cost of a scene in about a second, or in the time of two probes of 32 pixels if that is longer.
///
/// # Errors
/// As [`hypertexture::render::render`].
pub fn predict(renderer: &mut Renderer, scene: &Scene) -> Result<Prediction, RenderError> {
    renderer.set_full_size(scene.image.size);
    let longest = scene.image.size[0].max(scene.image.size[1]);
    let mut side = FIRST_SIDE.min(longest);
    let mut render = |side: u32| -> Result<Measurements, RenderError> {
        let mut probe = scene.clone();
        probe.image.size = fit(scene.image.size, side);
        Ok(renderer.render(&probe)?.measurements)
    };
    let mut start = Instant::now();
    let first = render(side)?;
    let compiling_ms = milliseconds(start);
    start = Instant::now();
    let mut last = render(side)?;
    while 2 * side < longest && milliseconds(start) + last.total_ms + 3.0 * last.gpu_ms < BUDGET_MS {
        side *= 2;
        last = render(side)?;
    }
    let (probe, all) = (fit(scene.image.size, side), pixels(scene.image.size));
    let ratio = all / pixels(probe);
    let mut device_ms = Estimate::scaled(last.gpu_ms, ratio, PER_QUADRUPLING);
    (device_ms.low, device_ms.high) = (device_ms.low / NOISE, device_ms.high * NOISE);
    let [fixed_once, fixed] = [first, last.clone()].map(|measured| measured.total_ms - measured.gpu_ms);
    let total_ms = Estimate {
        low: fixed.min(fixed_once) / NOISE + device_ms.low,
        expected: fixed_once + device_ms.expected,
        high: fixed.max(fixed_once) * NOISE + READ_MS * 1e-6 * all + device_ms.high,
    };
    let fragments = match scene.quality.pass {
        Pass::March => Some(Estimate { low: all, expected: all, high: all }),
        Pass::Slices => last.fragments.map(|n| Estimate::scaled(n as f64, ratio, FRAGMENTS_PER_QUADRUPLING)),
    };
    let spent_ms = compiling_ms + milliseconds(start);
    Ok(Prediction { probe, spent_ms, device_ms, total_ms, slices: last.slices, fragments })
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Size with the aspect of `size` and this longest side.
fn fit(size: [u32; 2], longest: u32) -> [u32; 2] {
    let factor = f64::from(longest) / f64::from(size[0].max(size[1]));
    size.map(|side| ((f64::from(side) * factor).round() as u32).max(1))
}

fn pixels([width, height]: [u32; 2]) -> f64 {
    f64::from(width) * f64::from(height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probe_keeps_the_aspect() {
        assert_eq!(fit([800, 600], 32), [32, 24]);
        assert_eq!(fit([9, 3000], 32), [1, 32]);
    }
}
