//! The light along one ray, by adaptive quadrature.
//!
//! Role: emission and absorption, `dC = (1 - A) c e dt`, `dA = (1 - A) e dt`, from samples of the color c and the
//! extinction e alone. Each piece of a ray has five samples: Simpson's rule over the whole and over its halves; their
//! difference is its error, and pieces whose error shows are halved until it does not. A piece in which matter becomes
//! opaque is halved until it is too short to be seen: that is where the surface is.
//! Invariant: colors of a piece are mixed with positive weights and an opacity in [0, 1], so stiff matter stays stable.

/// What a sample of a ray says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Matter {
    /// Linear RGB of what is there.
    pub(super) color: [f64; 3],
    /// Extinction per depth; infinite in the hard region.
    pub(super) extinction: f64,
}

/// What a piece of a ray does to light: color that it adds, and the part that it lets through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transport {
    pub(super) color: [f64; 3],
    pub(super) transmittance: f64,
}

impl Transport {
    /// An empty piece.
    pub(super) const CLEAR: Transport = Transport { color: [0.0; 3], transmittance: 1.0 };

    /// This piece, and another behind it.
    fn then(self, behind: Transport) -> Transport {
        let color = std::array::from_fn(|c| self.color[c] + self.transmittance * behind.color[c]);
        Transport { color, transmittance: self.transmittance * behind.transmittance }
    }

    /// The largest difference in any channel, opacity among them.
    fn differs(self, other: Transport) -> f64 {
        let colors = (0..3).map(|c| (self.color[c] - other.color[c]).abs());
        colors.fold((self.transmittance - other.transmittance).abs(), f64::max)
    }

    /// A piece of length `length` by its ends and its middle. Of three samples of which the first is opaque nothing but
    /// its color is seen; one that becomes opaque farther on is taken as opaque from its middle or its end on.
    fn of([near, middle, far]: [Matter; 3], length: f64) -> Transport {
        let opaque = |matter: Matter| Transport { color: matter.color, transmittance: 0.0 };
        if near.extinction.is_infinite() {
            return opaque(near);
        }
        if middle.extinction.is_infinite() {
            return Transport::even(near, 0.5 * length).then(opaque(middle));
        }
        if far.extinction.is_infinite() {
            return Transport::even(middle, length).then(opaque(far));
        }
        // Optical depths of both halves by the parabola through the three extinctions; never negative.
        let [e0, e1, e2] = [near, middle, far].map(|matter| matter.extinction);
        let depth = length / 6.0 * (e0 + 4.0 * e1 + e2);
        if depth <= 0.0 {
            return Transport::CLEAR;
        }
        let half = (length / 24.0 * (5.0 * e0 + 8.0 * e1 - e2)).clamp(0.0, depth);
        // What each sample shines, seen through what is before it; from the first that shines on, so that none is lost.
        let depths = [(e0, 0.0), (4.0 * e1, half), (e2, depth)];
        let first = depths.iter().find(|(shines, _)| *shines > 0.0).map_or(0.0, |(_, depth)| *depth);
        let weights = depths.map(|(shines, depth)| shines * (first - depth).min(0.0).exp());
        let sum: f64 = weights.iter().sum();
        let alpha = -(-depth).exp_m1();
        let mixed = |c: usize| {
            let colors = [near.color[c], middle.color[c], far.color[c]];
            colors.iter().zip(weights).map(|(color, weight)| color * weight).sum::<f64>() / sum
        };
        Transport { color: std::array::from_fn(|c| alpha * mixed(c)), transmittance: (-depth).exp() }
    }

    fn even(matter: Matter, length: f64) -> Transport {
        let transmittance = (-matter.extinction * length).exp();
        Transport { color: matter.color.map(|color| (1.0 - transmittance) * color), transmittance }
    }
}

/// A piece of a ray with samples at its ends, its middle and between.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    length: f64,
    samples: [Matter; 5],
    fine: Transport,
    error: f64,
}

impl Piece {
    fn new(from: f64, length: f64, samples: [Matter; 5]) -> Piece {
        let [a, b, c, d, e] = samples;
        let coarse = Transport::of([a, c, e], length);
        let fine = Transport::of([a, b, c], 0.5 * length).then(Transport::of([c, d, e], 0.5 * length));
        let opaque = |matter: &Matter| matter.extinction.is_infinite();
        // Where it becomes opaque within, Simpson's rule says nothing about its error.
        let hit = !opaque(&a) && samples.iter().any(opaque);
        let error = if hit { 1.0 } else { coarse.differs(fine) };
        Piece { from, length, samples, fine, error }
    }
}

/// A ray cut into pieces, front to back.
pub(super) struct RayIntegral {
    pieces: Vec<Piece>,
    /// Light that the pieces let through, as they were added.
    left: f64,
}

/// How far pieces are halved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Pieces whose error is less than this, behind what hides them, stay whole.
    pub(super) error: f64,
    /// Pieces shorter than this stay whole.
    pub(super) shortest: f64,
    /// So many pieces of a ray, at most.
    pub(super) pieces: usize,
}

/// Light that is fainter than this is not followed.
const DARK: f64 = 1e-8;

/// The rules of a piece agree by chance this many times better than those of the piece beside it. Less: twice the pieces
/// where one would do. More: with noise finer than a piece, estimates are too small.
const BY_CHANCE: f64 = 4.0;

impl RayIntegral {
    /// A ray through nothing yet.
    pub(super) fn new() -> RayIntegral {
        RayIntegral { pieces: Vec::new(), left: 1.0 }
    }

    /// Adds a piece behind the others, by its five samples at equal distances.
    pub(super) fn push(&mut self, from: f64, length: f64, samples: [Matter; 5]) {
        if samples.iter().any(|matter| matter.extinction > 0.0) {
            let piece = Piece::new(from, length, samples);
            self.left *= piece.fine.transmittance;
            self.pieces.push(piece);
        }
    }

    /// Whether nothing behind the last piece can be seen.
    pub(super) fn is_dark(&self) -> bool {
        self.left < DARK
    }

    /// The pieces to be halved, as indices from the front; what is behind opaque matter is dropped.
    pub(super) fn coarse(&mut self, limits: &Limits) -> Vec<usize> {
        let mut left = 1.0;
        let (mut coarse, mut seen) = (Vec::new(), 0);
        for (index, piece) in self.pieces.iter().enumerate() {
            seen = index + 1;
            if left * self.error(index, limits) > limits.error && piece.length > limits.shortest {
                coarse.push(index);
            }
            left *= piece.fine.transmittance;
            if left < DARK {
                break;
            }
        }
        self.pieces.truncate(seen);
        if self.pieces.len() + coarse.len() > limits.pieces {
            coarse.clear();
        }
        coarse
    }

    /// How wrong a piece may be: its two rules may agree by chance, but hardly where those of the pieces beside it do not.
    /// A piece that a surface was found in says nothing about others.
    fn error(&self, index: usize, limits: &Limits) -> f64 {
        let beside = [index.checked_sub(1), Some(index + 1)].into_iter().flatten();
        let others = beside.filter_map(|other| self.pieces.get(other)).filter(|piece| piece.length > limits.shortest);
        let others = others.map(|piece| piece.error).filter(|error| *error < 1.0);
        others.fold(self.pieces[index].error, |worst, error| worst.max(error / BY_CHANCE))
    }

    /// Where samples are wanted to halve these pieces: four for each.
    pub(super) fn wanted(&self, coarse: &[usize]) -> impl Iterator<Item = f64> {
        coarse.iter().flat_map(|&index| {
            let Piece { from, length, .. } = self.pieces[index];
            [1.0, 3.0, 5.0, 7.0].map(|eighth| from + length * eighth / 8.0)
        })
    }

    /// Halves these pieces with the samples that were wanted.
    pub(super) fn halve(&mut self, coarse: &[usize], samples: &[Matter]) {
        let mut halved = Vec::with_capacity(self.pieces.len() + coarse.len());
        let mut next = coarse.iter().zip(samples.as_chunks::<4>().0).peekable();
        for (index, piece) in self.pieces.iter().enumerate() {
            match next.next_if(|(coarse, _)| **coarse == index) {
                None => halved.push(*piece),
                Some((_, [p, q, r, s])) => {
                    let [a, b, c, d, e] = piece.samples;
                    let half = 0.5 * piece.length;
                    halved.push(Piece::new(piece.from, half, [a, *p, b, *q, c]));
                    halved.push(Piece::new(piece.from + half, half, [c, *r, d, *s, e]));
                }
            }
        }
        self.pieces = halved;
    }

    /// Light of the ray, and how wrong it may be: three times the root of the sum of the squared errors of its pieces,
    /// behind what hides them. They have no common sign, and each is that of the coarser rule, while the light is by the
    /// finer one. Of a piece that was halved down to `shortest` because a surface is in it, nothing is left to be wrong.
    pub(super) fn light(&self, limits: &Limits) -> (Transport, f64) {
        let (mut whole, mut error) = (Transport::CLEAR, 0.0);
        for (index, piece) in self.pieces.iter().enumerate() {
            if piece.length > limits.shortest {
                error += (whole.transmittance * self.error(index, limits)).powi(2);
            }
            whole = whole.then(piece.fine);
        }
        (whole, 3.0 * error.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { error: 1e-9, shortest: 1e-9, pieces: 20_000 };

    fn integrate(length: f64, pieces: u32, matter: impl Fn(f64) -> Matter) -> (Transport, f64) {
        let mut ray = RayIntegral::new();
        let step = length / f64::from(pieces);
        for k in 0..pieces {
            let from = f64::from(k) * step;
            ray.push(from, step, [0.0, 0.25, 0.5, 0.75, 1.0].map(|part| matter(from + part * step)));
        }
        loop {
            let coarse = ray.coarse(&LIMITS);
            if coarse.is_empty() {
                return ray.light(&LIMITS);
            }
            let samples: Vec<Matter> = ray.wanted(&coarse).map(&matter).collect();
            ray.halve(&coarse, &samples);
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
        let (light, error) = integrate(1.3, 16, |t| match t < 1.0 {
            true => Matter { color: [0.0; 3], extinction: -2.0 * (1.0 - t).ln() },
            false => Matter { color: [1.0; 3], extinction: f64::INFINITY },
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
