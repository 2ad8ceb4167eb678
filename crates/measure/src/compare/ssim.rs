//! SSIM, structural similarity of two pictures.
//!
//! Source: Wang, Bovik, Sheikh and Simoncelli 2004, with their constants: a Gaussian window of 11 x 11 pixels and a
//! deviation of 1.5, K1 = 0.01, K2 = 0.03. Deviation from it: at the edges of the picture the window is cut and its
//! weights are scaled up, so that every pixel counts and pictures smaller than the window have a value.

/// Pixels from the center of the window to its edge.
const REACH: usize = 5;
/// Standard deviation of the window, pixels.
const DEVIATION: f64 = 1.5;
/// Bounds the quotient of small means: (K1 L)^2 with a range L of 1.
const C1: f64 = 0.01 * 0.01;
/// Bounds the quotient of small variances: (K2 L)^2.
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity, in \[-1, 1\], of two pictures of one channel, row by row, with values in \[0, 1\].
pub fn ssim(a: &[f64], b: &[f64], width: usize) -> f64 {
    let squares = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let [mean_a, mean_b] = [a, b].map(|values| blur(values, width));
    let [aa, bb, ab] = [(a, a), (b, b), (a, b)].map(|(left, right)| blur(&squares(left, right), width));
    let sum: f64 = (0..a.len())
        .map(|i| {
            let (ma, mb) = (mean_a[i], mean_b[i]);
            let (variance_a, variance_b) = ((aa[i] - ma * ma).max(0.0), (bb[i] - mb * mb).max(0.0));
            let covariance = ab[i] - ma * mb;
            let luminance = (2.0 * ma * mb + C1) / (ma * ma + mb * mb + C1);
            luminance * (2.0 * covariance + C2) / (variance_a + variance_b + C2)
        })
        .sum();
    sum / a.len() as f64
}

/// Gaussian mean around each pixel: along the rows, then along the columns.
fn blur(values: &[f64], width: usize) -> Vec<f64> {
    let height = values.len() / width;
    let rows = pass(values, width, |index| (index % width, width, 1));
    pass(&rows, width, |index| (index / width, height, width))
}

/// Gaussian mean along one direction; `place` returns the coordinate of an index, the extent and the stride.
fn pass(values: &[f64], width: usize, place: impl Fn(usize) -> (usize, usize, usize)) -> Vec<f64> {
    debug_assert_eq!(values.len() % width, 0);
    let weight = |offset: usize| (-0.5 * (offset as f64 / DEVIATION).powi(2)).exp();
    let mean = |index: usize| {
        let (at, count, stride) = place(index);
        let near = at.saturating_sub(REACH)..=(at + REACH).min(count - 1);
        let (sum, weights) = near.fold((0.0, 0.0), |(sum, weights), other| {
            let w = weight(at.abs_diff(other));
            (sum + w * values[index + other * stride - at * stride], weights + w)
        });
        sum / weights
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_have_a_similarity_of_one() {
        let picture: Vec<f64> = (0..24 * 17).map(|i| f64::from(i * 37 % 101) / 101.0).collect();
        assert!((ssim(&picture, &picture, 24) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn two_plain_pictures_differ_by_the_luminance_term_alone() {
        let (a, b) = (0.3, 0.7);
        let expected = (2.0 * a * b + C1) / (a * a + b * b + C1);
        assert!((ssim(&[a; 200], &[b; 200], 20) - expected).abs() < 1e-12);
        assert!((ssim(&[a; 4], &[b; 4], 2) - expected).abs() < 1e-12, "smaller than the window");
    }

    #[test]
    fn a_negative_has_the_similarity_of_its_formula() {
        // Along x a wave of four pixels, whose Gaussian mean at any pixel is close to 1/2: covariance = -variance.
        let wave: Vec<f64> = (0..64 * 8).map(|i| 0.5 + 0.4 * f64::from(i % 64 % 2 * 2 - 1)).collect();
        let negative: Vec<f64> = wave.iter().map(|value| 1.0 - value).collect();
        let variance = 0.4f64.powi(2);
        let expected = (C2 - 2.0 * variance) / (C2 + 2.0 * variance);
        let found = ssim(&wave, &negative, 64);
        assert!((found - expected).abs() < 0.02, "{found} for {expected}");
    }
}
