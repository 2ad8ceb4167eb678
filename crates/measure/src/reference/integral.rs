//! Adaptive quadrature of the light along one ray.
//!
//! Role: emission and absorption, `dC = (1 - A) c e dt`, `dA = (1 - A) e dt`, from samples of the color c and the
//! extinction e alone. Each piece of a ray has five samples: Simpson's rule over the whole and over its halves; their
//! difference is its error, and pieces whose error shows are halved until it does not. A piece in which matter becomes
//! opaque is halved until it is too short to be seen: that is where the surface is. A piece whose samples find nothing
//! is left alone only where bounds of the extinction say that nothing in it can be seen. Invariants: colors of a piece
//! are mixed with positive weights and an opacity in [0, 1], so stiff matter stays stable. The opacity that bounds
//! leave undecided is stated beside the error estimated from samples, all of it: see [`proof`](super::proof).

use super::transport::{Matter, Transport};

/// A piece of a ray with samples at its ends, its middle and between.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) from: f64,
    pub(super) length: f64,
    samples: [Matter; 5],
    pub(super) extinction: Extinction,
    /// Its halves get bounds of their own.
    asks: bool,
    pub(super) fine: Transport,
    error: f64,
}

impl Piece {
    fn new(from: f64, length: f64, samples: [Matter; 5], extinction: Extinction) -> Piece {
        let [a, b, c, d, e] = samples;
        let coarse = Transport::of([a, c, e], length);
        let fine = Transport::of([a, b, c], 0.5 * length).then(Transport::of([c, d, e], 0.5 * length));
        let opaque = |matter: &Matter| matter.extinction.is_infinite();
        // Where it becomes opaque within, Simpson's rule says nothing about its error.
        let hit = !opaque(&a) && samples.iter().any(opaque);
        let error = if hit { 1.0 } else { coarse.differs(fine) };
        let mut piece = Piece { from, length, samples, extinction, asks: false, fine, error };
        if !hit {
            // Both rules call a piece dark in which one sample met a thin shell.
            let by_chance = if fine.transmittance < SATURATED && piece.has_edge() { piece.clear() } else { 0.0 };
            let [most, least] = extinction.transmittance(length);
            let disproved = (fine.transmittance - most).max(least - fine.transmittance);
            piece.error = error.max(by_chance - fine.transmittance).max(disproved);
        }
        piece
    }

    /// Whether all samples are clear.
    pub(super) fn looks_empty(&self) -> bool {
        self.samples.iter().all(|matter| matter.extinction <= 0.0)
    }

    /// Whether matter begins or ends between samples.
    pub(super) fn has_edge(&self) -> bool {
        !self.looks_empty() && self.samples.iter().any(|matter| matter.extinction <= 0.0)
    }

    /// The most light that comes through, by bounds or by samples: between two of these, matter is at least as thick as
    /// at the thinner.
    fn clear(&self) -> f64 {
        if self.is_hit() {
            return 0.0;
        }
        let [most, _] = self.extinction.transmittance(self.length);
        let thinner = self.samples.windows(2).map(|pair| pair[0].extinction.min(pair[1].extinction));
        most.min((-0.25 * self.length * thinner.sum::<f64>()).exp())
    }

    /// Bound of the error of its sampled opacity.
    pub(super) fn overlooked(&self) -> f64 {
        self.extinction.undecided(self.length, self.fine.transmittance)
    }

    /// How many of its halves can be seen: where the first is opaque in its middle, it hides the other.
    fn seen_halves(&self) -> usize {
        if self.samples[..3].iter().any(|matter| matter.extinction.is_infinite()) { 1 } else { 2 }
    }

    /// Whether a sample is opaque.
    pub(super) fn is_hit(&self) -> bool {
        self.samples.iter().any(|matter| matter.extinction.is_infinite())
    }
}

/// Bounds of the extinction over a part of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extinction {
    /// Everywhere in it.
    pub(super) range: [f64; 2],
    /// Of its mean, which light depends on.
    pub(super) mean: [f64; 2],
}

impl Extinction {
    /// Bounds that exclude nothing.
    pub(super) const ANY: Extinction = Extinction::within([0.0, f64::INFINITY]);

    /// Of which no more is known than this, everywhere.
    pub(super) const fn within(range: [f64; 2]) -> Extinction {
        Extinction { range, mean: range }
    }

    /// The same where it is also in the range of the whole that this is a part of.
    fn in_part_of(self, whole: Extinction) -> Extinction {
        let held = |[low, high]: [f64; 2]| [low.max(whole.range[0]), high.min(whole.range[1])];
        Extinction { range: held(self.range), mean: held(self.mean) }
    }

    /// In a part of a part: of its mean nothing is known.
    fn part(self) -> Extinction {
        Extinction::within(self.range)
    }

    /// The most and the least light that comes through a part of this length.
    pub(super) fn transmittance(self, length: f64) -> [f64; 2] {
        // Infinitely thick matter of no length is opaque all the same.
        self.mean.map(|extinction| if extinction > 0.0 { (-extinction * length).exp() } else { 1.0 })
    }

    /// How far the transmittance of a part of this length may be from the one that is `seen`.
    pub(super) fn undecided(self, length: f64, seen: f64) -> f64 {
        let [most, least] = self.transmittance(length);
        (most - seen).max(seen - least).max(0.0)
    }
}

/// A part of a ray, and bounds of the extinction in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) from: f64,
    pub(super) length: f64,
    pub(super) extinction: Extinction,
}

impl Part {
    /// Splits an open part into equal pieces no longer than `longest`.
    pub(super) fn cut(&self, longest: f64) -> impl Iterator<Item = Part> + use<> {
        let whole = *self;
        let open = whole.extinction.range[0] < whole.extinction.range[1];
        let count = if open { (whole.length / longest).ceil().max(1.0) as u32 } else { 1 };
        whole.pieces(count)
    }

    /// Splits the part into `count` pieces of equal length.
    pub(super) fn pieces(self, count: u32) -> impl Iterator<Item = Part> + use<> {
        let length = self.length / f64::from(count);
        let extinction = if count == 1 { self.extinction } else { self.extinction.part() };
        (0..count).map(move |index| Part { from: self.from + f64::from(index) * length, length, extinction })
    }

    /// Intersection of the part with an interval of depths.
    pub(super) fn within(&self, [enters, leaves]: [f64; 2]) -> Option<Part> {
        let (from, to) = (self.from.max(enters), (self.from + self.length).min(leaves));
        (from < to).then_some(Part { from, length: to - from, extinction: self.extinction.part() })
    }

    /// Whether it begins where another ends, up to rounding.
    fn follows(&self, end: Option<f64>) -> bool {
        end.is_some_and(|end| (self.from - end).abs() < 1e-6 * self.length)
    }
}

/// Which of these parts, front to back, bounds have to be made narrower for: those of which samples might see nothing
/// like what is there. What is empty, or behind opaque matter, is dropped.
pub(super) fn undecided(parts: &mut Vec<Part>, shortest: f64) -> Vec<usize> {
    let (mut left, mut found) = (1.0, Vec::new());
    parts.retain(|part| part.extinction.range[1] > 0.0);
    let mut seen = 0;
    for (index, part) in parts.iter().enumerate() {
        seen = index + 1;
        let [most, least] = part.extinction.transmittance(part.length);
        if left * (most - least) > OPEN && part.length > shortest {
            found.push(index);
        }
        left *= most;
        if left < DARK {
            break;
        }
    }
    parts.truncate(seen);
    found
}

/// A ray cut into pieces, front to back.
pub(super) struct RayIntegral {
    pub(super) pieces: Vec<Piece>,
    /// The most light that comes through the pieces before they are halved.
    left: f64,
    /// Remaining number of bounds.
    bounds: usize,
}

/// Limits of the halving of pieces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Error of a ray below which none of its pieces is halved for its error.
    pub(super) error: f64,
    /// Length below which pieces are not halved.
    pub(super) shortest: f64,
    /// Most pieces of a ray.
    pub(super) pieces: usize,
}

impl Limits {
    /// Whether a piece is as short as pieces get.
    pub(super) fn is_floor(&self, piece: &Piece) -> bool {
        piece.length <= self.shortest
    }
}

/// Bounds are made narrower until no part of a ray can hide or show more than this; then samples are enough. Less: more
/// bounds. More: samples of thin matter agree by chance.
pub(super) const OPEN: f64 = 0.05;
/// The same of a piece in which samples find nothing.
const FAINT: f64 = 1e-4;
/// Transmittance below which a ray ends.
const DARK: f64 = 1e-8;
/// Transmittance below which two rules may agree whatever is between their samples.
const SATURATED: f64 = 1e-2;

/// The rules of a piece agree by chance this many times better than those of the piece beside it. Less: twice the
/// pieces where one would do. More: with noise finer than a piece, estimates are too small.
const BY_CHANCE: f64 = 4.0;

/// Estimated error of a ray over the root of the sum of the squared errors of its pieces. Less: one of a thousand
/// pixels of noise with kinks is off by more than 0.9 of its estimate. More: more pieces.
const SUM_FACTOR: f64 = 3.0;
/// Share of the allowed squared error that pieces which stay whole may have together. More: more rounds of halving.
const KEPT_SHARE: f64 = 0.5;
/// A piece stays whole if its error is below that of its ray over this. More: rays of thousands of pieces are halved
/// endlessly.
const KEEP_BELOW: f64 = 16.0;

impl RayIntegral {
    /// A ray through nothing yet, and how many bounds it may ask for.
    pub(super) fn new(bounds: usize) -> RayIntegral {
        RayIntegral { pieces: Vec::new(), left: 1.0, bounds }
    }

    /// Where samples are wanted of parts behind its pieces: five at equal distances, of which the first may be known.
    pub(super) fn first<'a>(&self, parts: &'a [Part]) -> impl Iterator<Item = f64> + use<'a> {
        let mut end = self.pieces.last().map(|before| before.from + before.length);
        parts.iter().flat_map(move |part| {
            let known = part.follows(end.replace(part.from + part.length));
            (u32::from(known)..5).map(move |quarter| part.from + 0.25 * f64::from(quarter) * part.length)
        })
    }

    /// Adds a piece behind the others, by the samples that were wanted of it.
    pub(super) fn push(&mut self, part: &Part, samples: &mut impl Iterator<Item = Matter>) {
        let known = self.pieces.last().filter(|before| part.follows(Some(before.from + before.length)));
        let first = known.map(|before| before.samples[4]);
        let mut all = first.into_iter().chain(samples);
        let samples = std::array::from_fn(|_| all.next().unwrap_or_default());
        let piece = Piece::new(part.from, part.length, samples, part.extinction);
        self.left *= piece.clear();
        self.pieces.push(piece);
    }

    /// Whether nothing behind the pieces is visible.
    pub(super) fn is_dark(&self) -> bool {
        self.left < DARK
    }

    /// The pieces to be halved, as indices from the front; what is behind opaque matter is dropped.
    pub(super) fn coarse(&mut self, limits: &Limits) -> Vec<usize> {
        let (mut left, mut clear) = (1.0, 1.0);
        let (mut wrong, mut asking, mut seen) = (Vec::new(), Vec::new(), 0);
        for (index, piece) in self.pieces.iter().enumerate() {
            seen = index + 1;
            if piece.length > limits.shortest {
                let allowed = if piece.looks_empty() { FAINT } else { OPEN };
                let asks = left * piece.overlooked() > allowed && self.bounds >= 2;
                if asks {
                    self.bounds -= 2;
                    asking.push(index);
                }
                wrong.push((left * self.error(index, limits), index));
            }
            left *= piece.fine.transmittance;
            clear *= piece.clear();
            if clear < DARK {
                break;
            }
        }
        self.pieces.truncate(seen);
        // The least wrong stay whole, as many as are right enough together; if all are, none is halved.
        wrong.sort_by(|a, b| a.0.total_cmp(&b.0));
        let allowed = (limits.error / SUM_FACTOR).powi(2);
        let all: f64 = wrong.iter().map(|(error, _)| error * error).sum();
        let (mut sum, allowed) = (0.0, if all <= allowed { allowed } else { KEPT_SHARE * allowed });
        let mut coarse: Vec<usize> = (wrong.iter())
            .skip_while(|(error, _)| {
                sum += error * error;
                sum <= allowed || *error < limits.error / KEEP_BELOW
            })
            .map(|(_, index)| *index)
            .chain(asking.iter().copied())
            .collect();
        coarse.sort_unstable();
        coarse.dedup();
        if self.pieces.len() + coarse.len() > limits.pieces {
            coarse.clear();
        } else {
            asking.into_iter().for_each(|index| self.pieces[index].asks = true);
        }
        coarse
    }

    /// How wrong a piece may be: its two rules may agree by chance, but hardly where those of the pieces beside it do
    /// not. A piece that a surface was found in says nothing about others.
    fn error(&self, index: usize, limits: &Limits) -> f64 {
        let beside = [index.checked_sub(1), Some(index + 1)].into_iter().flatten();
        let others = beside.filter_map(|other| self.pieces.get(other)).filter(|piece| piece.length > limits.shortest);
        let others = others.map(|piece| piece.error).filter(|error| *error < 1.0);
        others.fold(self.pieces[index].error, |worst, error| worst.max(error / BY_CHANCE))
    }

    /// Where samples are wanted to halve these pieces: two for each half that can be seen.
    pub(super) fn wanted(&self, coarse: &[usize]) -> impl Iterator<Item = f64> {
        coarse.iter().flat_map(|&index| {
            let piece = &self.pieces[index];
            let eighths = [1.0, 3.0, 5.0, 7.0].into_iter().take(2 * piece.seen_halves());
            eighths.map(|eighth| piece.from + piece.length * eighth / 8.0)
        })
    }

    /// The halves of these pieces that get bounds of their own, front to back: from where on and how long.
    pub(super) fn asking(&self, coarse: &[usize]) -> impl Iterator<Item = [f64; 2]> {
        let asking = coarse.iter().map(|&index| &self.pieces[index]).filter(|piece| piece.asks);
        asking.flat_map(|piece| {
            let halves = [0.0, 0.5].into_iter().take(piece.seen_halves());
            halves.map(|part| [piece.from + part * piece.length, 0.5 * piece.length])
        })
    }

    /// Halves these pieces with the samples that were wanted, and the bounds of those that ask for them.
    pub(super) fn halve(
        &mut self,
        coarse: &[usize],
        samples: &mut impl Iterator<Item = Matter>,
        bounds: &mut impl Iterator<Item = Extinction>,
    ) {
        let mut halved = Vec::with_capacity(self.pieces.len() + coarse.len());
        let mut next = coarse.iter().peekable();
        for (index, piece) in self.pieces.iter().enumerate() {
            if next.next_if(|coarse| **coarse == index).is_none() {
                halved.push(*piece);
                continue;
            }
            let half = 0.5 * piece.length;
            for side in 0..piece.seen_halves() {
                let extinction = match piece.asks.then(|| bounds.next()).flatten() {
                    Some(own) => own.in_part_of(piece.extinction),
                    None => piece.extinction.part(),
                };
                let [Some(p), Some(q)] = [samples.next(), samples.next()] else { break };
                let [a, b, c] = [0, 1, 2].map(|sample| piece.samples[2 * side + sample]);
                let from = piece.from + side as f64 * half;
                halved.push(Piece::new(from, half, [a, p, b, q, c], extinction));
            }
        }
        halved.retain(|piece| piece.extinction.range[1] > 0.0);
        self.pieces = halved;
    }

    /// Light of the ray, and how wrong it may be as its samples say: [`SUM_FACTOR`] times the root of the sum of the
    /// squared errors of its pieces, behind what hides them: they have no common sign, and each is that of the coarser
    /// rule, while the light is by the finer one. Of a piece that was halved down to `shortest` because a surface is in
    /// it, nothing is left to be wrong.
    pub(super) fn light(&self, limits: &Limits) -> (Transport, f64) {
        let (mut whole, mut error) = (Transport::CLEAR, 0.0);
        for (index, piece) in self.pieces.iter().enumerate() {
            if !limits.is_floor(piece) {
                error += (whole.transmittance * self.error(index, limits)).powi(2);
            }
            whole = whole.then(piece.fine);
        }
        (whole, SUM_FACTOR * error.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { error: 1e-9, shortest: 1e-9, pieces: 20_000 };

    fn integrate(length: f64, pieces: u32, matter: impl Fn(f64) -> Matter) -> (Transport, f64) {
        let mut ray = RayIntegral::new(0);
        let step = length / f64::from(pieces);
        for k in 0..pieces {
            let from = f64::from(k) * step;
            let part = [Part { from, length: step, extinction: Extinction::ANY }];
            let samples: Vec<Matter> = ray.first(&part).map(&matter).collect();
            ray.push(&part[0], &mut samples.into_iter());
        }
        loop {
            let coarse = ray.coarse(&LIMITS);
            if coarse.is_empty() {
                return ray.light(&LIMITS);
            }
            let samples: Vec<Matter> = ray.wanted(&coarse).map(&matter).collect();
            ray.halve(&coarse, &mut samples.into_iter(), &mut std::iter::empty());
        }
    }

    #[test]
    fn a_slab_colored_by_depth_is_exact() {
        // numerics 3.2, truth 2: C = (1 - exp(-k) (1 + k)) / k.
        let (light, error) = integrate(1.0, 8, |t| Matter { color: [t, 1.0, 0.0], extinction: 5.0 });
        assert!((light.color[0] - 0.191_914_46).abs() < 1e-8, "{light:?}");
        assert!((light.color[1] - (1.0 - (-5.0f64).exp())).abs() < 1e-8);
        assert!((light.transmittance - (-5.0f64).exp()).abs() < 1e-9);
        assert!(error < 1e-7, "{error}");
    }

    #[test]
    fn extinction_that_grows_without_bound_ends_in_the_surface() {
        // -c ln u with u falling to 0 at the surface: its integral to there is c, and light exp(-c) reaches it.
        let (light, error) = integrate(1.3, 16, |t| {
            if t < 1.0 {
                Matter { color: [0.0; 3], extinction: -2.0 * (1.0 - t).ln() }
            } else {
                Matter { color: [1.0; 3], extinction: f64::INFINITY }
            }
        });
        assert!((light.color[0] - (-2.0f64).exp()).abs() < 1e-7, "{light:?}");
        assert_eq!(light.transmittance, 0.0);
        assert!(error < 1e-5, "{error}");
    }

    #[test]
    fn stiff_matter_is_opaque_and_no_more() {
        let (light, _) =
            integrate(1.0, 4, |t| Matter { color: [0.25; 3], extinction: if t > 0.3 { 1e9 } else { 0.0 } });
        assert!((light.color[0] - 0.25).abs() < 1e-9 && light.transmittance >= 0.0, "{light:?}");
    }

    #[test]
    fn kinks_are_followed_to_the_error_asked_for() {
        // exp(-integral of |sin(20 t)|) over [0, pi]: 40.
        let (light, error) =
            integrate(std::f64::consts::PI, 40, |t| Matter { color: [1.0; 3], extinction: (20.0 * t).sin().abs() });
        assert!((light.transmittance - (-2.0f64).exp()).abs() < 1e-8, "{light:?} {error}");
    }
}
