//! Squares of pixels that stand for a picture, and a bound of what those hold that were not looked at.
//!
//! Role: each square has a chance of its own to be looked at, in proportion to a score that is known in all of them, and a
//! random number that never changes; it is looked at where that number is below the chance. So a sample only grows, and the
//! sum of what is found, divided by the chances, is right on the mean. Squares of chance 1 are known. Invariant: a bound is
//! above the truth but for one time in 1 / [`RISK`], if no square that was not looked at is wrong by more, in parts of its score,
//! than the worst of chance 1, or [`UNSEEN`] times the worst of the others. Sources: Horvitz and Thompson 1952 (weights); Chernoff 1952 (the
//! lower tail of a sum of independent terms).

use support::random::SplitMix;

/// How often a bound may be broken by chance, at most. Lower: more pixels are looked at. Higher: of the thousand looks that 200
/// picks take, one breaks its bound.
const RISK: f64 = 1e-5;
/// How many times as wrong a square that was not looked at may be, in parts of its score, as the worst that was and might not
/// have been. Less: bounds
/// are broken where few pixels have most of the error. More: more pixels are looked at.
const UNSEEN: f64 = 3.0;

/// Squares of pixels, each with its chance to be looked at.
pub(super) struct Sample {
    luck: Vec<f64>,
    chance: Vec<f64>,
}

impl Sample {
    /// Of so many squares, none of which is looked at; the same for the same seed.
    pub(super) fn new(squares: usize, seed: u64) -> Sample {
        let mut random = SplitMix(seed);
        Sample { luck: (0..squares).map(|_| random.unit()).collect(), chance: vec![0.0; squares] }
    }

    /// Raises chances in proportion to scores, all of them above 0, until some `wanted` squares would be looked at by these
    /// scores alone. Result: those that are looked at from now on.
    pub(super) fn raise(&mut self, scores: &[f64], wanted: usize) -> Vec<usize> {
        let rate = rate(scores, wanted);
        let mut new = Vec::new();
        for (square, score) in scores.iter().enumerate() {
            let before = self.chance[square];
            self.chance[square] = before.max((rate * score).min(1.0));
            if (before..self.chance[square]).contains(&self.luck[square]) {
                new.push(square);
            }
        }
        new
    }

    /// How many squares one that is looked at stands for.
    pub(super) fn weight(&self, square: usize) -> f64 {
        1.0 / self.chance[square]
    }

    /// The most that a number adds up to over all squares, by those that are looked at and their scores. `most`: what it may be in
    /// a square, if that is known.
    pub(super) fn at_most(&self, seen: &[(usize, f64)], scores: &[f64], most: Option<f64>) -> f64 {
        let is_known = |square: usize| self.chance[square] >= 1.0;
        let known: f64 = seen.iter().filter(|(square, _)| is_known(*square)).map(|(_, value)| value).sum();
        let others = seen.iter().filter(|(square, _)| !is_known(*square));
        let stands_for: f64 = others.map(|(square, value)| value * self.weight(*square)).sum();
        let worst =
            |(square, value): &(usize, f64)| value / scores[*square] * if is_known(*square) { 1.0 } else { UNSEEN };
        let worst = seen.iter().map(worst).fold(1.0, f64::max);
        let holds = |square: usize| most.unwrap_or(worst * scores[square]) * self.weight(square);
        let largest = (0..self.chance.len()).filter(|square| !is_known(*square)).map(holds).fold(0.0, f64::max);
        known + mean_at_most(stands_for, largest)
    }
}

/// The factor by which scores are the chances that some `wanted` squares are looked at.
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

/// The largest mean of a sum of independent terms, none below 0 or above `largest`, that is as low as this once in
/// 1 / [`RISK`] times: of mean m it is at most x with a chance of exp(-(x ln(x / m) - x + m) / largest).
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
        for ((scores, values), most) in [(even, 1.4), (heavy, 6.0), ((scores, few), 1.9)] {
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
        // None of 1024 of 16 384 has it, and each may: 11.5 of those that were looked at might, and each stands for 16.
        let mut sample = Sample::new(SQUARES, 1);
        let seen: Vec<(usize, f64)> =
            sample.raise(&vec![1.0; SQUARES], WANTED).into_iter().map(|square| (square, 0.0)).collect();
        let bound = sample.at_most(&seen, &vec![1.0; SQUARES], Some(1.0));
        assert!((bound / (16.0 * (1.0 / RISK).ln()) - 1.0).abs() < 1e-6, "{bound}");
    }
}
