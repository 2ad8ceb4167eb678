//! Sub-frames, whose mean is the picture: each has a subpixel offset, a time and a jitter phase.
//!
//! Source: PH 3.1 suggests jittered rays and motion blur by rays over time.

use crate::scene::{Jitter, Scene};
use hypertexture_support::random::SplitMix;

/// Multiples of the golden ratio leave no large gap in [0, 1], whatever their number.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_8;

/// One of the pictures that are averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SubFrame {
    /// Subpixel offset of a ray from the pixel center: right and down, each in (-1/2, 1/2).
    pub(crate) offset: [f32; 2],
    /// Time, seconds.
    pub(crate) time: f64,
    /// Seed of the pixels' phases: an integer below 2^24, which f32 holds; for blue noise the shift of the phases in
    /// units of 2^-24.
    pub(crate) jitter_seed: f32,
}

impl SubFrame {
    /// The sub-frames of a scene: one through the pixel centers, or several that cover pixel and exposure evenly.
    pub(crate) fn all(scene: &Scene) -> impl Iterator<Item = SubFrame> {
        let (count, seed) = (scene.quality.supersampling, scene.quality.seed);
        let (time, shutter) = (scene.camera.time, scene.camera.shutter);
        (0..count).map(move |index| {
            let moment = (f64::from(index) + 0.5) / f64::from(count);
            SubFrame {
                offset: offset(index, count),
                time: time + f64::from(shutter) * moment,
                jitter_seed: match scene.quality.jitter {
                    Jitter::None | Jitter::Hash => {
                        (SplitMix(u64::from(seed) << 32 | u64::from(index)).bits() >> 40) as f32
                    }
                    Jitter::Blue => {
                        let place = SplitMix(u64::from(seed)).unit() + f64::from(index) * GOLDEN_RATIO;
                        (place.fract() * f64::from(1 << 24)).floor() as f32
                    }
                },
            }
        })
    }
}

/// Subpixel offset from a lattice whose projections on either axis, and on time, are equidistant. The lattice steps are
/// those of the R2 sequence (Roberts 2018), rounded to the nearest number that is coprime to `count`.
fn offset(index: u32, count: u32) -> [f32; 2] {
    // 1 / g and 1 / g^2 with g^3 = g + 1.
    const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    STEP.map(|step| {
        let wanted = (step * f64::from(count)).round() as u32;
        let coprime = |k: &u32| gcd(*k, count) == 1;
        let step = (1..=count).rev().filter(coprime).min_by_key(|k| k.abs_diff(wanted)).unwrap_or(1);
        ((f64::from(index * step % count) + 0.5) / f64::from(count) - 0.5) as f32
    })
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sub_frame_is_the_pixel_center_at_the_scene_time() {
        let mut scene = Scene::default();
        scene.camera.time = 2.5;
        let all: Vec<_> = SubFrame::all(&scene).collect();
        assert_eq!((all.len(), all[0].offset, all[0].time), (1, [0.0; 2], 2.5));
    }

    #[test]
    fn p48_blue_phases_cover_the_step_evenly_however_many_they_are() {
        let mut scene = Scene::default();
        (scene.quality.supersampling, scene.quality.jitter, scene.quality.seed) = (55, Jitter::Blue, 3);
        let all: Vec<f32> = SubFrame::all(&scene).map(|sub| sub.jitter_seed / 16_777_216.0).collect();
        for count in [5, 8, 20, 55] {
            let mut phases = all[..count].to_vec();
            phases.sort_by(f32::total_cmp);
            phases.push(1.0 + phases[0]);
            let gap = phases.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f32::max);
            assert!(gap < 1.9 / count as f32, "{count}: a gap of {gap}");
        }
    }

    #[test]
    fn p49_sub_frames_cover_the_pixel_and_the_time_evenly() {
        let mut scene = Scene::default();
        (scene.quality.supersampling, scene.camera.shutter) = (64, 1.0);
        let all: Vec<_> = SubFrame::all(&scene).collect();
        for axis in [0, 1] {
            let mean: f32 = all.iter().map(|sub| sub.offset[axis]).sum::<f32>() / 64.0;
            assert!(mean.abs() < 1e-6, "axis {axis}: {mean}");
            let mut places: Vec<f32> = all.iter().map(|sub| sub.offset[axis]).collect();
            places.sort_by(f32::total_cmp);
            assert!(places.windows(2).all(|pair| (pair[1] - pair[0] - 1.0 / 64.0).abs() < 1e-6));
        }
        assert!(all.windows(2).all(|pair| (pair[1].time - pair[0].time - 1.0 / 64.0).abs() < 1e-6));
        assert!(all[0].time > 0.0 && all[63].time < 1.0);
        assert!(all.windows(2).all(|pair| pair[0].jitter_seed != pair[1].jitter_seed));
    }
}
