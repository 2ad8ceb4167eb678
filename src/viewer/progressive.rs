//! Pictures that get better: how coarse one may be while the scene moves, and how good a mean of many is.

use crate::measure::statistics::rms_difference;
use crate::scene::{Jitter, RayPath, Scene, TargetFormat};

/// Ways to save work: every so many pixels in a row, and one of so many samples. From the best.
const LEVELS: [[u32; 2]; 9] = [[1, 1], [1, 2], [2, 1], [2, 2], [3, 2], [4, 2], [4, 4], [6, 4], [8, 4]];
/// A level is taken only where it fills at most this part of the budget by prediction. Nearer to 1: levels change with
/// every noise in the time, and each change costs a pipeline.
const HEADROOM: f64 = 0.7;
/// Fewer samples than this show slices, not matter.
const FEWEST_SAMPLES: u32 = 32;
/// Pictures of which a converged one is the mean, at most: what `quality.supersampling` allows.
pub(super) const MOST: u32 = 256;
/// The mean of fewer pictures than this is noisier than the scene's own picture.
pub(super) const FEWEST: u32 = 4;

/// How coarse a picture is while the scene moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Level(usize);

impl Level {
    /// What a device is first tried with.
    pub(super) fn first(cpu: bool) -> Level {
        Level(if cpu { 5 } else { 2 })
    }

    /// The scene with fewer pixels and samples.
    pub(super) fn scene(self, scene: &Scene) -> Scene {
        let [pixels, samples] = LEVELS[self.0];
        let mut coarse = scene.clone();
        coarse.image.size = scene.image.size.map(|side| side.div_ceil(pixels));
        let quality = &mut coarse.quality;
        quality.samples = (quality.samples / samples).max(FEWEST_SAMPLES).min(quality.samples);
        (quality.msaa, quality.supersampling, coarse.camera.shutter) = (1, 1, 0.0);
        coarse
    }

    /// Work of a picture, as a part of that of all pixels and samples.
    fn work(self) -> f64 {
        let [pixels, samples] = LEVELS[self.0].map(f64::from);
        1.0 / (pixels * pixels * samples)
    }

    /// Milliseconds of a picture with all pixels and samples, by those of one of this level.
    pub(super) fn whole(self, ms: f64) -> f64 {
        ms / self.work()
    }

    /// The level for the next picture, by what one of this level has taken on the device.
    pub(super) fn next(self, ms: f64, budget_ms: f64) -> Level {
        let whole = self.whole(ms);
        let fits = |level: &usize| whole * Level(*level).work() <= HEADROOM * budget_ms;
        match ms <= budget_ms {
            // It is good enough, unless a better one is sure to be.
            true => Level((0..self.0).find(fits).unwrap_or(self.0)),
            false => Level((self.0..LEVELS.len()).find(fits).unwrap_or(LEVELS.len() - 1)),
        }
    }
}

/// The scene of which each sub-frame is a step towards the converged image.
pub(super) fn reference(scene: &Scene) -> Scene {
    let mut fine = scene.clone();
    let quality = &mut fine.quality;
    (quality.supersampling, quality.msaa, quality.target) = (MOST, 1, TargetFormat::Float32);
    if quality.jitter == Jitter::None && scene.effect.ray_path == RayPath::Straight {
        quality.jitter = Jitter::Hash; // rays that bend have no phase
    }
    fine
}

/// The number of the next sub-frame after `count` of them: their bits in reverse order, so that every 2^n of them cover
/// the pixel and the time evenly.
pub(super) fn number(count: u32) -> u32 {
    count.reverse_bits() >> (u32::BITS - MOST.ilog2())
}

/// A mean of pictures, and how good it is.
#[derive(Clone, Debug, Default)]
pub(super) struct Mean {
    sum: Vec<[f64; 4]>,
    /// Of the squares of all values.
    squares: f64,
    /// How many pictures.
    pub(super) count: u32,
    /// The mean at the last power of two.
    before: Vec<[f32; 4]>,
    /// Root mean square difference of the last two powers of two, and the count of the latter.
    doubling: Option<(f64, u32)>,
}

impl Mean {
    /// Adds a picture.
    pub(super) fn add(&mut self, pixels: &[[f32; 4]]) {
        self.sum.resize(pixels.len(), [0.0; 4]);
        let mut squares = 0.0;
        for (sum, pixel) in self.sum.as_flattened_mut().iter_mut().zip(pixels.as_flattened()) {
            let value = f64::from(*pixel);
            *sum += value;
            squares += value * value;
        }
        self.squares += squares;
        self.count += 1;
        if self.count.is_power_of_two() {
            let mean = self.pixels();
            if self.count > 1 {
                self.doubling = Some((rms_difference(&mean, &self.before), self.count));
            }
            self.before = mean;
        }
    }

    /// The mean.
    pub(super) fn pixels(&self) -> Vec<[f32; 4]> {
        let factor = 1.0 / f64::from(self.count.max(1));
        self.sum.iter().map(|sum| sum.map(|channel| (channel * factor) as f32)).collect()
    }

    /// Root mean square error against the mean of infinitely many, about. Of pictures that are independent, a mean of 2 n
    /// differs from that of the first n by the variance of one over 2 n, which is the square of its own error; from one
    /// power of two to the next it falls as the square root. Pictures that are not independent but fill each other's gaps
    /// are better than that.
    pub(super) fn error(&self) -> Option<f64> {
        self.doubling.map(|(error, count)| error * (f64::from(count) / f64::from(self.count)).sqrt())
    }

    /// Standard error of a value, root mean square over all, as if the pictures were independent.
    pub(super) fn standard_error(&self) -> Option<f64> {
        let count = f64::from(self.count);
        let values = 4.0 * self.sum.len() as f64;
        let of_means: f64 = self.sum.as_flattened().iter().map(|sum| sum * sum / count).sum();
        (self.count > 1).then(|| ((self.squares - of_means).max(0.0) / values / (count - 1.0) / count).sqrt())
    }
}

/// A picture with more pixels, each that of the nearest.
pub(super) fn enlarge(pixels: &[[f32; 4]], from: [u32; 2], to: [u32; 2]) -> Vec<[f32; 4]> {
    let [width, height] = to;
    let place = |index: u32, axis: usize| {
        (u64::from(2 * index + 1) * u64::from(from[axis]) / (2 * u64::from(to[axis]))) as usize
    };
    let columns: Vec<usize> = (0..width).map(|column| place(column, 0)).collect();
    let row = |row: u32| {
        let start = place(row, 1) * from[0] as usize;
        columns.iter().map(move |column| pixels[start + column])
    };
    (0..height).flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::random::SplitMix;
    use std::collections::BTreeSet;

    #[test]
    fn every_sub_frame_has_its_turn_and_powers_of_two_are_even() {
        let all: BTreeSet<u32> = (0..MOST).map(number).collect();
        assert_eq!(all.len(), MOST as usize);
        for count in [2, 8, 64] {
            let mut first: Vec<u32> = (0..count).map(number).collect();
            first.sort_unstable();
            assert!(first.windows(2).all(|pair| pair[1] - pair[0] == MOST / count), "{first:?}");
        }
    }

    #[test]
    fn the_level_follows_the_budget_and_stays_where_it_is_good() {
        let level = Level::first(true);
        assert!(level.next(500.0, 50.0).work() < level.work());
        assert_eq!(level.next(45.0, 50.0), level);
        assert_eq!(level.next(0.1, 50.0), Level(0));
        assert_eq!(Level(8).next(1e9, 50.0), Level(8));
        // What it steps to, it does not step back from.
        for ms in [1.0, 3.0, 10.0, 49.0, 51.0, 80.0, 200.0] {
            let next = level.next(ms, 50.0);
            let then = ms * next.work() / level.work();
            assert_eq!(next.next(then, 50.0), next, "{ms}");
        }
    }

    #[test]
    fn the_error_of_a_mean_of_independent_pictures_is_what_it_says() {
        let mut random = SplitMix(7);
        let mut noise = || (random.unit() as f32 - 0.5) * 12f32.sqrt() * 0.1; // deviation 0.1
        let mut mean = Mean::default();
        for count in 1..=64 {
            let picture: Vec<[f32; 4]> =
                (0..4096).map(|_| [0.5 + noise(), 0.2 + noise(), noise(), 1.0 + noise()]).collect();
            mean.add(&picture);
            let expected = 0.1 / f64::from(count).sqrt();
            let truth = rms_difference(&mean.pixels(), &vec![[0.5, 0.2, 0.0, 1.0]; 4096]);
            assert!((truth / expected - 1.0).abs() < 0.05);
            if count > 1 {
                let (error, standard) = (mean.error().unwrap(), mean.standard_error().unwrap());
                assert!((error / truth - 1.0).abs() < 0.06, "{count}: {error} {truth}");
                assert!((standard / truth - 1.0).abs() < 0.06, "{count}: {standard} {truth}");
            }
        }
    }

    #[test]
    fn an_enlarged_picture_has_the_nearest_pixels() {
        let small: Vec<[f32; 4]> = (0..6).map(|index| [index as f32; 4]).collect();
        let large = enlarge(&small, [3, 2], [6, 4]);
        let row: Vec<f32> = large[6..12].iter().map(|pixel| pixel[0]).collect();
        assert_eq!(row, [0.0, 0.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!(large[12][0], 3.0);
        assert_eq!(enlarge(&small, [3, 2], [3, 2]), small);
    }
}
