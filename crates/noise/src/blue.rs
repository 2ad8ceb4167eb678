//! Blue noise.

use hypertexture_support::random::SplitMix;

/// Width of the energy around a point, texels. Lower overlooks clusters; higher orders points in a lattice.
const SIGMA: f64 = 1.9;
/// Texels per point of the initial pattern. Lower takes longer to spread the points.
const FIRST: usize = 10;

/// A pattern of points on a torus, with the energy at each texel.
#[derive(Clone)]
struct Pattern {
    side: usize,
    on: Vec<bool>,
    energy: Vec<f64>,
    kernel: Vec<f64>,
}

impl Pattern {
    fn empty(side: usize) -> Pattern {
        let square = |at: usize| (at.min(side - at) as f64).powi(2);
        let kernel = (0..side * side).map(|at| (-0.5 * (square(at % side) + square(at / side)) / SIGMA.powi(2)).exp());
        Pattern { side, on: vec![false; side * side], energy: vec![0.0; side * side], kernel: kernel.collect() }
    }

    fn toggle(&mut self, at: usize) {
        self.on[at] = !self.on[at];
        let sign = if self.on[at] { 1.0 } else { -1.0 };
        let side = self.side;
        for y in 0..side {
            let row = (y + side - at / side) % side * side;
            for x in 0..side {
                self.energy[y * side + x] += sign * self.kernel[row + (x + side - at % side) % side];
            }
        }
    }

    /// The tightest cluster (`on`), or the largest void.
    fn extreme(&self, on: bool) -> usize {
        let sign = if on { -1.0 } else { 1.0 };
        let places = (0..self.on.len()).filter(|at| self.on[*at] == on);
        places.min_by(|a, b| (sign * self.energy[*a]).total_cmp(&(sign * self.energy[*b]))).unwrap_or_default()
    }
}

/// A tile of `side`^2 blue noise values that repeats without seams, x fastest. Each (rank + 1/2) / `side`^2 occurs once.
///
/// Source: R. Ulichney, "The void-and-cluster method for dither array generation", 1993. Its third phase equals the
/// second. Time grows as `side`^4: 0.1 s for 64.
pub fn blue_noise(side: usize) -> Vec<f32> {
    let count = side * side;
    let mut places: Vec<usize> = (0..count).collect();
    SplitMix(1989).shuffle(&mut places);
    let mut pattern = Pattern::empty(side);
    places[..count.div_ceil(FIRST)].iter().for_each(|at| pattern.toggle(*at));
    loop {
        let crowded = pattern.extreme(true);
        pattern.toggle(crowded);
        let empty = pattern.extreme(false);
        pattern.toggle(empty);
        if empty == crowded {
            break;
        }
    }
    let mut ranks = vec![0; count];
    let mut fewer = pattern.clone();
    let first = count.div_ceil(FIRST);
    for rank in (0..first).rev() {
        let at = fewer.extreme(true);
        fewer.toggle(at);
        ranks[at] = rank;
    }
    for rank in first..count {
        let at = pattern.extreme(false);
        pattern.toggle(at);
        ranks[at] = rank;
    }
    ranks.into_iter().map(|rank| ((rank as f64 + 0.5) / count as f64) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power of a tile below and above a frequency, cycles per texel: means over all waves.
    fn power(tile: &[f64], side: usize, limit: f64) -> [f64; 2] {
        let (mut sums, mut counts) = ([0.0; 2], [0.0; 2]);
        for wave in 1..side * side {
            let signed = |k: usize| if k > side / 2 { k as f64 - side as f64 } else { k as f64 };
            let (u, v) = (signed(wave % side) / side as f64, signed(wave / side) / side as f64);
            let turn = |at: usize| std::f64::consts::TAU * (u * (at % side) as f64 + v * (at / side) as f64);
            let part = |f: fn(f64) -> f64| tile.iter().enumerate().map(|(at, value)| value * f(turn(at))).sum::<f64>();
            let band = usize::from(u.hypot(v) >= limit);
            sums[band] += part(f64::cos).powi(2) + part(f64::sin).powi(2);
            counts[band] += 1.0;
        }
        [0, 1].map(|band| sums[band] / counts[band] / tile.len() as f64)
    }

    #[test]
    fn p48_blue_noise_is_a_permutation_with_few_low_frequencies() {
        const SIDE: usize = 32;
        let tile: Vec<f64> = blue_noise(SIDE).into_iter().map(f64::from).collect();
        let mut sorted = tile.clone();
        sorted.sort_by(f64::total_cmp);
        let even = (0..SIDE * SIDE).map(|rank| (rank as f64 + 0.5) / (SIDE * SIDE) as f64);
        assert!(sorted.iter().zip(even).all(|(found, expected)| (found - expected).abs() < 1e-6));
        let mut random = SplitMix(7);
        let white: Vec<f64> = (0..SIDE * SIDE).map(|_| random.unit()).collect();
        let [[low, high], [white_low, white_high]] = [power(&tile, SIDE, 0.15), power(&white, SIDE, 0.15)];
        println!(
            "power per wave below and above 0.15: {low:.5} {high:.5}; of white noise {white_low:.5} {white_high:.5}"
        );
        assert!(low < 0.05 * white_low && high > 0.8 * white_high);
    }
}
