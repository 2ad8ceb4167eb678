//! Opacity of a ray that bounds leave undecided.
//!
//! Role: the transmittance of consecutive pieces by their samples, against bounds of the mean extinction over all of them; runs of
//! pieces that remain undecided are halved. Invariant: whatever the samples saw, the transmittance of a ray is off by no more than
//! the sum over its runs: a product of transmittances changes by at most the sum of the changes of its factors, each behind what is
//! in front of it. Pieces of the shortest length right before a surface count nothing: the surface is there.

use super::integral::{Extinction, Limits, RayIntegral};
use super::parts::Beam;
use std::ops::Range;

/// Opacity below which a run is decided. Lower: more bounds. Higher: a proven ray of many runs may hide what can be seen.
pub(super) const DECIDED: f64 = super::UNSEEN / 16.0;
/// Most bounds of a ray. Lower: less is proven. Higher: rays whose bounds prove nothing take longer.
const BOUNDS: usize = 64;
/// From this round on, bounds must pay: of what was undecided a round ago, less than [`PAYS`] still is.
const FREE_ROUNDS: u32 = 3;
const PAYS: f64 = 0.9;

/// Consecutive pieces of a ray.
#[derive(Clone, Debug)]
struct Run {
    pieces: Range<usize>,
    /// Transmittance before it and in it, by samples.
    before: f64,
    seen: f64,
    /// Undecided opacity of its pieces one by one, and of all together.
    apart: f64,
    open: f64,
}

/// Undecided opacity of a ray.
pub(super) struct Proof {
    /// Front to back.
    runs: Vec<Run>,
    /// Undecided opacity of pieces of the shortest length.
    floor: f64,
    /// The least undecided opacity of all rounds: each round is a proof, and halves begin with the sum of their pieces.
    least: f64,
    /// Runs that bounds are computed of.
    asking: Vec<usize>,
    bounds: usize,
    rounds: u32,
}

impl Proof {
    /// The proof by bounds of single pieces; `vain`: no further bounds are computed.
    pub(super) fn new(ray: &RayIntegral, limits: &Limits, vain: bool) -> Proof {
        let bounds = if vain { 0 } else { BOUNDS };
        let least = f64::INFINITY;
        let mut proof = Proof { runs: Vec::new(), floor: 0.0, least, asking: Vec::new(), bounds, rounds: 0 };
        let (mut before, mut open, mut end) = (1.0, 0.0, f64::NEG_INFINITY);
        let mut last = None;
        for (index, piece) in ray.pieces.iter().enumerate() {
            let is_floor = limits.is_floor(piece);
            // Open pieces of the shortest length in a row, up to a surface or not.
            if !is_floor || piece.from > end + 0.5 * limits.shortest {
                proof.floor += std::mem::take(&mut open);
            }
            end = piece.from + piece.length;
            let kind = (!is_floor).then(|| (piece.looks_empty(), piece.has_edge()));
            match before * piece.overlooked() {
                hidden if is_floor => open += hidden,
                hidden => match proof.runs.last_mut().filter(|_| kind == last && !piece.has_edge()) {
                    Some(run) => {
                        run.pieces.end = index + 1;
                        run.seen *= piece.fine.transmittance;
                        (run.apart, run.open) = (run.apart + hidden, run.open + hidden);
                    }
                    None => proof.runs.push(Run {
                        pieces: index..index + 1,
                        before,
                        seen: piece.fine.transmittance,
                        apart: hidden,
                        open: hidden,
                    }),
                },
            }
            if is_floor && piece.is_hit() {
                open = 0.0;
            }
            last = kind;
            before *= piece.fine.transmittance;
        }
        proof.floor += open;
        proof.least = proof.open();
        proof.asking = (0..proof.runs.len()).filter(|run| proof.runs[*run].open > DECIDED).collect();
        proof.hold();
        proof
    }

    /// Undecided opacity of the ray.
    pub(super) fn open(&self) -> f64 {
        (self.floor + self.runs.iter().map(|run| run.open).sum::<f64>()).min(self.least).min(1.0)
    }

    /// Keeps to the number of bounds: the runs of which most is undecided.
    fn hold(&mut self) {
        if self.open() <= super::UNSEEN {
            self.asking.clear();
        }
        let runs = &self.runs;
        self.asking.sort_by(|a, b| runs[*b].open.total_cmp(&runs[*a].open));
        self.asking.truncate(self.bounds);
        self.asking.sort_unstable();
        self.bounds -= self.asking.len();
    }

    /// The runs that bounds are wanted of: from where on and how long.
    pub(super) fn wanted(&self, ray: &RayIntegral, pixel: [u32; 2]) -> impl Iterator<Item = Beam> {
        self.asking.iter().map(move |run| {
            let pieces = &ray.pieces[self.runs[*run].pieces.clone()];
            Beam::of(pixel, [pieces[0].from, length(pieces.iter().map(|piece| [piece.from, piece.length]))])
        })
    }

    /// Learns the bounds of the runs that wanted them, and decides which runs to halve next.
    pub(super) fn learn(&mut self, ray: &RayIntegral, bounds: &mut impl Iterator<Item = Extinction>) {
        let was = self.least;
        let asking = std::mem::take(&mut self.asking);
        for &run in &asking {
            let (run, Some(bound)) = (&mut self.runs[run], bounds.next()) else { break };
            let pieces = &ray.pieces[run.pieces.clone()];
            let all = length(pieces.iter().map(|piece| [piece.from, piece.length]));
            run.open = run.apart.min(run.before * bound.undecided(all, run.seen));
        }
        self.least = self.open();
        self.rounds += 1;
        if self.rounds >= FREE_ROUNDS && self.open() > PAYS * was {
            self.bounds = 0;
        }
        if self.bounds == 0 || self.open() <= super::UNSEEN {
            return;
        }
        let halved: Vec<usize> = (asking.into_iter())
            .filter(|run| self.runs[*run].open > DECIDED && self.runs[*run].pieces.len() > 1)
            .take(self.bounds / 2)
            .collect();
        let mut next = halved.into_iter().peekable();
        for (index, run) in std::mem::take(&mut self.runs).into_iter().enumerate() {
            match next.next_if_eq(&index) {
                None => self.runs.push(run),
                Some(_) => {
                    let at = self.runs.len();
                    self.asking.extend([at, at + 1]);
                    self.runs.extend(run.halves(ray));
                }
            }
        }
        self.hold();
    }
}

/// From the first of some intervals to the end of the last.
fn length(mut all: impl Iterator<Item = [f64; 2]>) -> f64 {
    let Some([from, first]) = all.next() else { return 0.0 };
    all.last().map_or(first, |[last, length]| last + length - from)
}

impl Run {
    /// The run in two, as near to its middle as its pieces allow.
    fn halves(&self, ray: &RayIntegral) -> [Run; 2] {
        let pieces = &ray.pieces[self.pieces.clone()];
        let all = length(pieces.iter().map(|piece| [piece.from, piece.length]));
        let middle = pieces[0].from + 0.5 * all;
        let at = pieces.partition_point(|piece| piece.from + 0.5 * piece.length < middle).clamp(1, pieces.len() - 1);
        let at = self.pieces.start + at;
        let mut before = self.before;
        [self.pieces.start..at, at..self.pieces.end].map(|own| {
            let (mut run, mut left) = (Run { pieces: own.clone(), before, seen: 1.0, apart: 0.0, open: 0.0 }, before);
            for piece in &ray.pieces[own] {
                run.apart += left * piece.overlooked();
                run.seen *= piece.fine.transmittance;
                left *= piece.fine.transmittance;
            }
            (run.open, before) = (run.apart, left);
            run
        })
    }
}
