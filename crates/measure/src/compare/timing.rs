//! Spread of repeated runs, and their order.
//!
//! Runs of all candidates of a batch are mixed in random order, so that a slow moment of the machine slows all alike. No
//! run is dropped.

use crate::statistics::quantile;
use hypertexture_support::random::SplitMix;
use serde::{Deserialize, Serialize};

/// Factor of the 95th percentile above the median from which on times are unsteady.
const UNSTEADY: f64 = 1.25;
/// Confidence of the interval around a median.
const CONFIDENCE: f64 = 0.95;
/// Fewest runs whose extremes contain the median with a confidence of 95 %: 1 - 2 / 2^6 = 0.97.
pub(crate) const FEWEST_RUNS: usize = 6;

/// Times of one run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Run {
    /// Milliseconds on the device by its timestamps, shadow volume included.
    pub gpu_ms: f64,
    /// Milliseconds of the processor, all threads, where the processor is the device and the system reports them.
    pub processor_ms: Option<f64>,
    /// Milliseconds of wall clock from scene to pixels in memory, without compiling.
    pub wall_ms: f64,
}

/// Spread of repeated times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Interval of the median with a confidence of 95 % from 6 runs on; with fewer, least and largest time.
    pub interval: [f64; 2],
    /// Least time.
    pub min: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Number of runs.
    pub runs: usize,
}

impl Spread {
    /// The spread of one time or more.
    pub fn of(times: &[f64]) -> Spread {
        let mut sorted = times.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
        let low = lower_rank(n);
        let p95 = quantile(times.to_vec(), 0.95);
        Spread { median, interval: [sorted[low], sorted[n - 1 - low]], min: sorted[0], p95, runs: n }
    }

    /// Whether the intervals of both medians overlap, so that neither is known to be faster.
    pub fn overlaps(&self, other: &Spread) -> bool {
        self.interval[0] <= other.interval[1] && other.interval[0] <= self.interval[1]
    }

    /// Whether the machine was disturbed: the 95th percentile is far above the median.
    pub(crate) fn is_unsteady(&self) -> bool {
        self.p95 > UNSTEADY * self.median
    }
}

/// Number of `n` ordered values below the interval of the median: the most k for which at most k of n fair coins show
/// heads with a probability of at most (1 - confidence) / 2.
fn lower_rank(n: usize) -> usize {
    let mut term = 0.5f64.powi(n as i32); // probability of no heads
    let mut tail = term;
    let mut rank = 0;
    while tail <= 0.5 * (1.0 - CONFIDENCE) {
        rank += 1;
        term *= (n + 1 - rank) as f64 / rank as f64;
        tail += term;
    }
    rank.saturating_sub(1)
}

/// Order of interleaved runs: in each round, everything with runs left, shuffled.
pub fn interleave(runs: &[usize], random: &mut SplitMix) -> Vec<usize> {
    let rounds = runs.iter().copied().max().unwrap_or(0);
    let round = |round: usize| {
        let mut due: Vec<usize> = (0..runs.len()).filter(|&index| runs[index] > round).collect();
        random.shuffle(&mut due);
        due
    };
    (0..rounds).flat_map(round).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_median_has_the_ranks_of_the_tables() {
        // Published ranks of the 95 % interval of a median, counted from 1.
        for (n, rank) in [(6, 1), (8, 1), (9, 2), (15, 4), (20, 6), (31, 10), (50, 18), (100, 40)] {
            assert_eq!(lower_rank(n) + 1, rank, "{n} values");
        }
        assert_eq!(lower_rank(1), 0);
    }

    #[test]
    fn a_spread_is_that_of_its_times() {
        let times: Vec<f64> = (1..=31).rev().map(f64::from).collect();
        let spread = Spread::of(&times);
        assert_eq!(spread, Spread { median: 16.0, interval: [10.0, 22.0], min: 1.0, p95: 30.0, runs: 31 });
        assert!(spread.is_unsteady());
        assert!(!Spread::of(&[1.0, 1.1, 1.2]).is_unsteady());
        assert_eq!(Spread::of(&[2.0, 4.0]).median, 3.0);
        let [slow, like] = [&[3.0, 4.0], &[2.0, 3.0]].map(|times| Spread::of(times));
        assert!(slow.overlaps(&like) && like.overlaps(&slow) && !slow.overlaps(&Spread::of(&[1.0, 2.9])));
    }

    #[test]
    fn runs_are_interleaved_and_each_happens_as_often_as_it_should() {
        let order = interleave(&[3, 1, 2], &mut SplitMix(7));
        assert_eq!(order.len(), 6);
        assert_eq!([0, 1, 2].map(|i| order.iter().filter(|&&other| other == i).count()), [3, 1, 2]);
        let mut first = order[..3].to_vec();
        first.sort_unstable();
        assert_eq!(first, [0, 1, 2], "a round holds each once");
        assert_eq!(order, interleave(&[3, 1, 2], &mut SplitMix(7)));
        let many = |seed| interleave(&[5; 9], &mut SplitMix(seed));
        assert_ne!(many(1), many(2));
    }
}
