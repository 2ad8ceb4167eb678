//! Means of sub-frames with their errors, and resampling.

use hypertexture_measure::statistics::rms_difference;
use rayon::prelude::*;

/// A mean of pictures with estimates of its error.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mean {
    sum: Vec<[f64; 4]>,
    /// Sum of the squares of all values.
    squares: f64,
    /// Number of pictures.
    pub(crate) count: u32,
    /// The mean at the last power of two.
    before: Vec<[f32; 4]>,
    /// Root mean square difference between the last two powers of two, and the latter.
    doubling: Option<(f64, u32)>,
}

impl Mean {
    /// Adds a picture.
    pub(crate) fn add(&mut self, pixels: &[[f32; 4]]) {
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
    pub(crate) fn pixels(&self) -> Vec<[f32; 4]> {
        let factor = 1.0 / f64::from(self.count.max(1));
        self.sum.iter().map(|sum| sum.map(|channel| (channel * factor) as f32)).collect()
    }

    /// Estimated root mean square error against the limit. The mean of 2 n independent pictures differs from that of
    /// the first n by the variance of one over 2 n, which is the square of its own error; between powers of two the
    /// error falls as the square root. Sub-frames that fill each other's gaps are better than that.
    pub(crate) fn error(&self) -> Option<f64> {
        self.doubling.map(|(error, count)| error * (f64::from(count) / f64::from(self.count)).sqrt())
    }

    /// Standard error of a value, root mean square over all values, for independent pictures.
    pub(crate) fn standard_error(&self) -> Option<f64> {
        let count = f64::from(self.count);
        let values = 4.0 * self.sum.len() as f64;
        let of_means: f64 = self.sum.as_flattened().iter().map(|sum| sum * sum / count).sum();
        (self.count > 1).then(|| ((self.squares - of_means).max(0.0) / values / (count - 1.0) / count).sqrt())
    }
}

/// Resamples a picture bilinearly. `place` maps a position in the result to one in the source, in fractions of width
/// and height; outside is `beyond`.
pub(crate) fn resampled(
    pixels: &[[f32; 4]],
    from: [u32; 2],
    to: [u32; 2],
    place: impl Fn([f32; 2]) -> [f32; 2] + Sync,
    beyond: [f32; 4],
) -> Vec<[f32; 4]> {
    let row = |row: usize| {
        let place = &place;
        (0..to[0] as usize).map(move |column| {
            let at = place([(column as f32 + 0.5) / to[0] as f32, (row as f32 + 0.5) / to[1] as f32]);
            if at.iter().any(|part| !(0.0..=1.0).contains(part)) {
                return beyond;
            }
            let [x, y] = [0, 1].map(|axis| (at[axis] * from[axis] as f32 - 0.5).clamp(0.0, (from[axis] - 1) as f32));
            let [left, top] = [x, y].map(|side| side as usize);
            let [right, bottom] = [(left + 1).min(from[0] as usize - 1), (top + 1).min(from[1] as usize - 1)];
            let own = |x: usize, y: usize| pixels[y * from[0] as usize + x];
            let mix = |a: [f32; 4], b: [f32; 4], t: f32| std::array::from_fn(|c| a[c] + t * (b[c] - a[c]));
            let across = |y: usize| mix(own(left, y), own(right, y), x - left as f32);
            mix(across(top), across(bottom), y - top as f32)
        })
    };
    (0..to[1] as usize).into_par_iter().flat_map_iter(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

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
    fn b3_an_enlarged_preview_is_a_smooth_picture_and_not_blocks() {
        let same = |at: [f32; 2]| at;
        let ramp: Vec<[f32; 4]> = (0..12).map(|index| [(index % 4) as f32; 4]).collect();
        let large = resampled(&ramp, [4, 3], [32, 24], same, [0.0; 4]);
        let row: Vec<f32> = large[..32].iter().map(|pixel| pixel[0]).collect();
        assert!(row.windows(2).all(|pair| (0.0..=0.126).contains(&(pair[1] - pair[0]))), "{row:?}");
        assert_eq!([row[0], row[31]], [0.0, 3.0]);
        assert_eq!(resampled(&ramp, [4, 3], [4, 3], same, [0.0; 4]), ramp);
        let moved = resampled(&ramp, [4, 3], [4, 3], |[x, y]| [x + 0.5, y], [9.0; 4]);
        let row: Vec<f32> = moved[..4].iter().map(|pixel| pixel[0]).collect();
        assert_eq!(row, [2.0, 3.0, 9.0, 9.0]);
    }
}
