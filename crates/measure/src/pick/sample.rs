//! A random sample of squares of pixels, and an upper bound of the sum over all squares.
//!
//! Role: a square is in the sample if its fixed random number is below its chance, which is in proportion to its score. So a sample
//! only grows, and the sum of the values, each divided by its chance, is unbiased. Squares of chance 1 are known. Invariant: a bound
//! fails with a probability of [`RISK`] at most, if no square outside of the sample has a larger value, in parts of its score, than
//! the worst of chance 1, or [`UNSAMPLED_FACTOR`] times the worst of the others. Sources: Horvitz and Thompson 1952
//! (weights); Chernoff 1952 (the lower tail of a sum of independent terms).

use hypertexture_support::random::SplitMix;

/// Probability of a broken bound. Lower: more pixels are compared. Higher: one of the thousand bounds of 200 picks breaks.
const RISK: f64 = 1e-5;
/// Largest value of a square outside of the sample, in parts of its score and of the worst in the sample. Lower: bounds break where few
/// pixels have most of the error. Higher: more pixels are compared.
const UNSAMPLED_FACTOR: f64 = 3.0;

/// Squares of pixels, each with its chance and its random number.
pub(super) struct Sample {
    random: Vec<f64>,
    chance: Vec<f64>,
}

impl Sample {
    /// An empty sample of `squares` squares, reproducible by its seed.
    pub(super) fn new(squares: usize, seed: u64) -> Sample {
        let mut numbers = SplitMix(seed);
        Sample { random: (0..squares).map(|_| numbers.unit()).collect(), chance: vec![0.0; squares] }
    }

    /// Raises chances in proportion to scores, all above 0, to an expected size of `wanted` squares. Result: the new squares.
    pub(super) fn raise(&mut self, scores: &[f64], wanted: usize) -> Vec<usize> {
        let rate = rate(scores, wanted);
        let mut new = Vec::new();
        for (square, score) in scores.iter().enumerate() {
            let before = self.chance[square];
            self.chance[square] = before.max((rate * score).min(1.0));
            if (before..self.chance[square]).contains(&self.random[square]) {
                new.push(square);
            }
        }
        new
    }

    /// Number of squares that one in the sample stands for.
    pub(super) fn weight(&self, square: usize) -> f64 {
        1.0 / self.chance[square]
    }

    /// Upper bound of the sum over all squares, from the values in the sample. `most`: the largest possible value of a square, if
    /// known.
    pub(super) fn at_most(&self, seen: &[(usize, f64)], scores: &[f64], most: Option<f64>) -> f64 {
        let is_known = |square: usize| self.chance[square] >= 1.0;
        let known: f64 = seen.iter().filter(|(square, _)| is_known(*square)).map(|(_, value)| value).sum();
        let others = seen.iter().filter(|(square, _)| !is_known(*square));
        let stands_for: f64 = others.map(|(square, value)| value * self.weight(*square)).sum();
        let worst = |(square, value): &(usize, f64)| {
            value / scores[*square] * if is_known(*square) { 1.0 } else { UNSAMPLED_FACTOR }
        };
        let worst = seen.iter().map(worst).fold(1.0, f64::max);
        let holds = |square: usize| most.unwrap_or(worst * scores[square]) * self.weight(square);
        let largest = (0..self.chance.len()).filter(|square| !is_known(*square)).map(holds).fold(0.0, f64::max);
        known + mean_at_most(stands_for, largest)
    }
}

/// Factor from scores to chances with an expected size of `wanted` squares.
fn rate(scores: &[f64], wanted: usize) -> f64 {
    if wanted >= scores.len() {
        return f64::INFINITY;
    }
    let mut sorted = scores.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let mut left: f64 = sorted.iter().sum();
    for (sure, score) in sorted.iter().enumerate() {
        let rate = wanted.saturating_sub(sure) as f64 / left;
        if rate * score <= 1.0 {
            return rate;
        }
        left -= score;
    }
    f64::INFINITY
}

/// Largest mean of a sum of independent terms in [0, `largest`] that is as low as `sum` with a probability of [`RISK`]: of mean m it is at most x with a chance of exp(-(x ln(x / m) - x + m) / largest).
fn mean_at_most(sum: f64, largest: f64) -> f64 {
    let allowed = -RISK.ln() * largest;
    let is_plausible = |mean: f64| {
        let below = if sum > 0.0 { sum * (sum / mean).ln() } else { 0.0 };
        below - sum + mean <= allowed
    };
    let (mut low, mut high) = (sum, sum + 2.0 * allowed + (2.0 * allowed * sum).sqrt());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if is_plausible(middle) { &mut low } else { &mut high }) = middle;
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARES: usize = 16_384;
    const WANTED: usize = 1024;

    /// Scores over six decades, and what they stand for: so many times as much, by a number drawn for each.
    fn values(scale: impl Fn(&mut SplitMix) -> f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = SplitMix(7);
        (0..SQUARES)
            .map(|_| {
                let score = 10f64.powf(-8.0 + 6.0 * random.unit());
                (score + 1e-4, score * scale(&mut random))
            })
            .unzip()
    }

    /// Of 400 samples, how often a bound is below the truth; median of bound by truth; mean of the estimate by truth.
    fn bounds(scores: &[f64], values: &[f64]) -> (usize, f64, f64) {
        let truth: f64 = values.iter().sum();
        let (mut above, mut estimates) = (Vec::new(), 0.0);
        for seed in 0..400 {
            let mut sample = Sample::new(SQUARES, seed);
            let seen: Vec<(usize, f64)> =
                sample.raise(scores, WANTED).into_iter().map(|square| (square, values[square])).collect();
            above.push(sample.at_most(&seen, scores, None) / truth);
            estimates += seen.iter().map(|(square, value)| value * sample.weight(*square)).sum::<f64>() / truth / 400.0;
        }
        above.sort_by(f64::total_cmp);
        (above.iter().filter(|bound| **bound < 1.0).count(), above[200], estimates)
    }

    #[test]
    fn a_bound_is_above_the_truth_of_heavy_tails_and_not_far_above() {
        let even = values(|random| 2.0 * random.unit());
        // Log-normal: its mean is 8 times its median.
        let heavy = values(|random| {
            let normal = (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
            (2.0 * normal).exp()
        });
        // Ten squares of the upper half hold three quarters of all, and half of what they hold is in their score.
        let (mut scores, mut few) = values(|random| 0.1 * random.unit());
        let share = 0.3 * few.iter().sum::<f64>();
        for square in (0..10).map(|place| 1000 * place + 77) {
            (scores[square], few[square]) = (0.5 * share, share);
        }
        for ((scores, values), most) in [(even, 1.5), (heavy, 9.0), ((scores, few), 2.6)] {
            let (broken, median, estimate) = bounds(&scores, &values);
            assert!(broken <= 2, "{broken} of 400 bounds are broken");
            assert!(median < most, "{median} times the truth");
            assert!((estimate - 1.0).abs() < 0.05, "{estimate}: the weights keep the mean");
        }
    }

    #[test]
    fn the_mean_of_the_sampled_alone_breaks_every_other_bound() {
        let (scores, values) = values(|random| 2.0 * random.unit());
        let truth: f64 = values.iter().sum();
        let below = |seed: &u64| {
            let mut sample = Sample::new(SQUARES, *seed);
            let new = sample.raise(&scores, WANTED);
            new.iter().map(|square| values[*square] * sample.weight(*square)).sum::<f64>() < truth
        };
        assert!((140..260).contains(&(0..400).filter(below).count()));
    }

    #[test]
    fn a_sample_only_grows_and_knows_all_at_last() {
        let (scores, values) = values(|random| 3.0 * random.unit());
        let mut sample = Sample::new(SQUARES, 1);
        let (mut seen, mut before) = (Vec::new(), f64::INFINITY);
        for wanted in [256, 1024, 1024, 4096, SQUARES] {
            let new = sample.raise(&scores, wanted);
            seen.extend(new.into_iter().map(|square| (square, values[square])));
            let near = (wanted as f64 - 4.0 * (wanted as f64).sqrt())..=(wanted as f64 + 4.0 * (wanted as f64).sqrt());
            assert!(near.contains(&(seen.len() as f64)), "{} of {wanted}", seen.len());
            let bound = sample.at_most(&seen, &scores, None);
            assert!(bound <= before * 1.001, "{wanted}: {bound} after {before}");
            before = bound;
        }
        let truth: f64 = values.iter().sum();
        assert!((before / truth - 1.0).abs() < 1e-9 && seen.len() == SQUARES);
    }

    #[test]
    fn what_is_seen_nowhere_is_bounded_by_how_much_was_looked_at() {
        // With n zeros seen among N squares, the sum is at most (N / n) ln(1 / RISK): here N / n = 16.
        let mut sample = Sample::new(SQUARES, 1);
        let seen: Vec<(usize, f64)> =
            sample.raise(&vec![1.0; SQUARES], WANTED).into_iter().map(|square| (square, 0.0)).collect();
        let bound = sample.at_most(&seen, &vec![1.0; SQUARES], Some(1.0));
        assert!((bound / (16.0 * (1.0 / RISK).ln()) - 1.0).abs() < 1e-6, "{bound}");
    }
}
