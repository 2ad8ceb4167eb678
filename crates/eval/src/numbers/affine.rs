//! Affine forms of one symbol: bounds along a segment.
//!
//! Role: the symbol s is the position on the segment, from -1 at one end to 1 at the other. A number is
//! `slope * s + rest`, where the interval `rest` holds the constant and all that is not linear. The form keeps the
//! dependency on the position, so bounds narrow with the segment; intervals widen with each repeated variable.
//! Invariant: as for [`Interval`]; the bounds `all` and the form hold at once, and each clips the other.
//! Source: Comba and Stolfi 1993; rests as in Berz and Makino's Taylor models of order 1.

use super::integer_range::{Range, Tri};
use super::interval::{Interval, max_of, min_of};
use super::segment_bounds::SegmentBounds;
use crate::integer_splits::IntegerSplits;
use crate::number::{Binary, Comparison, Domain, Number, Unary, packed};
use crate::texture::Image;
use hypertexture_noise::{Knots, Lattice, ROUNDED};

/// A number along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Bounds over the whole segment.
    pub all: Interval,
    /// Linear change from the middle of the segment to its end.
    slope: f64,
    /// Bounds of the number minus its linear part.
    rest: Interval,
}

/// Longest side of a box, in lattice cells, in which noise is linearized. Higher: its form is wider than its range.
const LINEAR: f64 = 0.25;

/// Relative rounding of a few operations.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Affine {
    /// A number that goes linearly from one value to another along the segment.
    pub fn between(from: f64, to: f64) -> Affine {
        let (middle, slope) = (0.5 * (from + to), 0.5 * (to - from));
        let off = ROUNDING * (from.abs() + to.abs()) + f64::MIN_POSITIVE;
        Affine { all: Interval::of(from, to), slope, rest: Interval { lo: middle - off, hi: middle + off } }
    }

    /// Bounds of the number and of its mean over the segment.
    pub(crate) fn bounds(self) -> SegmentBounds {
        let mean = Interval { lo: max_of(self.rest.lo, self.all.lo), hi: min_of(self.rest.hi, self.all.hi) };
        SegmentBounds { all: self.all, mean: self.all.unless(mean.lo <= mean.hi, mean) }
    }

    /// The form on a part of the segment, rescaled to [-1, 1].
    pub(crate) fn part(self, [from, to]: [f64; 2]) -> Affine {
        if self.slope == 0.0 {
            return self;
        }
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let moved = self.slope * middle;
        let off = ROUNDING * self.slope.abs();
        let rest = Interval::rounded(self.rest.lo + moved - off, self.rest.hi + moved + off);
        Affine::of(self.all, self.slope * half, rest.wider())
    }

    /// A number known by its bounds alone.
    #[inline(always)]
    pub fn bounded(all: Interval) -> Affine {
        Affine { all, slope: 0.0, rest: all }
    }

    /// A form and bounds of one number, each clipped by the other.
    #[inline(always)]
    fn of(all: Interval, slope: f64, rest: Interval) -> Affine {
        let reach = slope.abs();
        let line = Interval::rounded(rest.lo - reach, rest.hi + reach);
        let met = Interval { lo: max_of(all.lo, line.lo), hi: min_of(all.hi, line.hi) };
        let all = all.unless(met.lo <= met.hi, met);
        let gains = rest.hi - rest.lo < all.hi - all.lo; // false for NaN and infinity
        Affine { all, slope: if gains { slope } else { 0.0 }, rest: all.unless(gains, rest) }
    }

    /// Image under a function (mean value form): by its value at the middle of the bounds and its slopes over them.
    #[inline(always)]
    fn along(self, middle: f64, value: Interval, slopes: Interval, all: Interval) -> Affine {
        let (center, off) = slopes.center();
        let slope = center * self.slope;
        let bent = off * self.slope.abs() + ROUNDING * slope.abs();
        let rest = value.add(slopes.mul(self.rest.sub(Interval { lo: middle, hi: middle })));
        Affine::of(all, slope, Interval::rounded(rest.lo - bent, rest.hi + bent))
    }

    /// Image under a smooth function, by bounds of its derivative.
    #[inline(always)]
    fn smooth(self, function: Unary, slopes: impl Fn(Interval) -> Interval) -> Affine {
        let all = self.all.unary(function);
        let middle = 0.5 * (self.all.lo + self.all.hi);
        let value = Interval { lo: middle, hi: middle }.unary(function);
        self.along(middle, value, slopes(self.all), all)
    }

    /// Noise in the mean value form: its value at the middle of the box, and its gradient over the box.
    fn noise(noise: Lattice, at: [Affine; 3], level: Affine, all: [Interval; 4]) -> [Affine; 4] {
        let mut found = all.map(Affine::bounded);
        if level.all.lo != level.all.hi || at.iter().any(|at| at.all == Interval::WHOLE) {
            return found;
        }
        let knots = Knots::of_level(level.all.lo);
        let (low, high) = (at.map(|at| at.all.lo), at.map(|at| at.all.hi));
        if (0..3).any(|axis| high[axis] - low[axis] > LINEAR) {
            return found;
        }
        let middle: [f64; 3] = std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis]));
        let slopes = noise.gradient_range(knots, low, high);
        let mut form = Affine::new(noise.sample_of(knots, middle).1);
        for axis in 0..3 {
            let [low, high] = slopes[axis];
            form =
                form.add(at[axis].sub(Affine::new(middle[axis])).mul(Affine::bounded(Interval { lo: low, hi: high })));
        }
        // The constants of the GLSL are rounded to f32.
        found[3] = Affine::of(all[3], form.slope, Interval { lo: form.rest.lo - ROUNDED, hi: form.rest.hi + ROUNDED });
        found
    }

    #[inline(always)]
    fn negate(self) -> Affine {
        Affine { all: self.all.negate(), slope: -self.slope, rest: self.rest.negate() }
    }

    /// Union of two forms, pointwise along the segment.
    #[inline(always)]
    fn either(self, other: Affine, all: Interval) -> Affine {
        let slope = 0.5 * (self.slope + other.slope);
        let off = (0.5 + ROUNDING) * (self.slope - other.slope).abs() + ROUNDING * slope.abs();
        let rest = self.rest.join(other.rest);
        Affine::of(all, slope, Interval::rounded(rest.lo - off, rest.hi + off))
    }

    #[inline(always)]
    fn unless(self, condition: bool, other: Affine) -> Affine {
        Affine {
            all: self.all.unless(condition, other.all),
            slope: if condition { other.slope } else { self.slope },
            rest: self.rest.unless(condition, other.rest),
        }
    }

    #[inline(always)]
    fn add(self, b: Affine) -> Affine {
        let slope = self.slope + b.slope;
        let off = ROUNDING * slope.abs();
        let rest = Interval::rounded(self.rest.lo + b.rest.lo - off, self.rest.hi + b.rest.hi + off);
        Affine::of(self.all.add(b.all), slope, rest.wider())
    }

    #[inline(always)]
    fn sub(self, b: Affine) -> Affine {
        self.add(b.negate())
    }

    #[inline(always)]
    fn mul(self, b: Affine) -> Affine {
        let ((m, v), (n, w)) = (self.rest.center(), b.rest.center());
        let bent = self.slope * b.slope; // coefficient of s^2, which is in [0, 1]
        // Each factor is within v or w of its line.
        let (line, other) = (self.slope.abs() + m.abs(), b.slope.abs() + n.abs() + w);
        let off = line * w + other * v + (ROUNDING * ((line + v) * other) + f64::MIN_POSITIVE);
        let middle = m * n;
        let rest = Interval::known(middle + min_of(bent, 0.0) - off, middle + max_of(bent, 0.0) + off);
        Affine::of(self.all.mul(b.all), self.slope * n + b.slope * m, rest)
    }

    #[inline(always)]
    fn div(self, b: Affine) -> Affine {
        let all = self.all.div(b.all);
        let middle = 0.5 * (b.all.lo + b.all.hi);
        let one = Interval { lo: 1.0, hi: 1.0 };
        let slopes = one.negate().div(b.all.unary(Unary::Square));
        let inverse = b.along(middle, one.div(Interval { lo: middle, hi: middle }), slopes, one.div(b.all));
        let product = self.mul(inverse);
        Affine::of(all, product.slope, product.rest)
    }

    #[inline(always)]
    fn min(self, b: Affine) -> Affine {
        let all = self.all.min(b.all);
        self.either(b, all).unless(self.all.hi <= b.all.lo, self).unless(b.all.hi <= self.all.lo, b)
    }

    #[inline(never)]
    fn pow(self, b: Affine) -> Affine {
        let all = self.all.pow(b.all);
        if b.all.lo < b.all.hi || self.all.lo <= 0.0 {
            return Affine::bounded(all);
        }
        let middle = 0.5 * (self.all.lo + self.all.hi);
        let slopes = b.all.mul(self.all.pow(b.all.sub(Interval { lo: 1.0, hi: 1.0 })));
        self.along(middle, Interval { lo: middle, hi: middle }.pow(b.all), slopes, all)
    }
}

packed!(Affine as x: 5 f64 { lo: x.all.lo, hi: x.all.hi, slope: x.slope, low: x.rest.lo, high: x.rest.hi } =>
    Affine { all: Interval { lo, hi }, slope, rest: Interval { lo: low, hi: high } });

impl Domain for Affine {
    fn any() -> Affine {
        Affine::bounded(Interval::WHOLE)
    }
    #[inline(always)]
    fn join(self, other: Affine) -> Affine {
        self.either(other, self.all.join(other.all))
    }
    fn is_within(self, other: Affine) -> bool {
        let off = (self.slope - other.slope).abs();
        let rest = Interval { lo: self.rest.lo - off, hi: self.rest.hi + off };
        self.all.is_within(other.all) && (off == 0.0 && self.rest.is_within(other.rest) || rest.is_within(other.rest))
    }
}

impl Number for Affine {
    type Int = Range;
    type Bool = Tri;
    const DECIDED: bool = false;

    #[inline(always)]
    fn new(x: f64) -> Affine {
        Affine::bounded(Interval::new(x))
    }
    #[inline(always)]
    fn select(condition: Tri, a: Affine, b: Affine) -> Affine {
        a.join(b).unless(!condition.may_hold, b).unless(!condition.may_fail, a)
    }
    #[inline(always)]
    fn select_decided(condition: Tri, a: Affine, b: Affine) -> Affine {
        b.unless(condition.may_hold, a)
    }
    fn at_most(self, b: Affine) -> Affine {
        // The whole line may be NaN.
        let hi = min_of(self.all.hi, b.all.hi);
        let known = self.all != Interval::WHOLE && b.all != Interval::WHOLE && self.all.lo <= hi;
        if known { Affine { all: Interval { lo: self.all.lo, hi }, ..self } } else { self }
    }
    #[inline(always)]
    fn unary(self, function: Unary) -> Affine {
        let point = |x: f64| Interval { lo: x, hi: x };
        match function {
            Unary::Negate => self.negate(),
            Unary::Abs => {
                let all = Affine::bounded(self.all.unary(function));
                all.unless(self.all.lo >= 0.0, self).unless(self.all.hi <= 0.0, self.negate())
            }
            Unary::Fract => {
                let base = self.all.unary(Unary::Floor);
                let same = (base.lo == base.hi) & (base.lo.abs() < f64::INFINITY);
                let all = self.all.unary(function);
                let moved = self.sub(Affine::bounded(point(if same { base.lo } else { 0.0 })));
                Affine::bounded(all).unless(same, Affine::of(all, moved.slope, moved.rest))
            }
            Unary::Saturate => {
                let all = self.all.unary(function);
                let within = (self.all.lo >= 0.0) & (self.all.hi <= 1.0);
                let crossed = self.smooth(function, |_| Interval { lo: 0.0, hi: 1.0 });
                Affine::of(all, crossed.slope, crossed.rest).unless(within, self)
            }
            Unary::Square => {
                let product = self.mul(self);
                Affine::of(self.all.unary(function), product.slope, product.rest)
            }
            Unary::Hermite => {
                let steep = Affine::new(3.0).sub(self.add(self));
                let product = self.mul(self).mul(steep);
                Affine::of(self.all.unary(function), product.slope, product.rest)
            }
            Unary::Sqrt => self.smooth(function, |x| Interval { lo: 0.5, hi: 0.5 }.div(x.unary(Unary::Sqrt))),
            Unary::InverseSqrt => self.smooth(function, |x| {
                let cube = x.mul(x.unary(Unary::Sqrt));
                Interval { lo: -0.5, hi: -0.5 }.div(cube)
            }),
            Unary::Exp => self.smooth(function, |x| x.unary(Unary::Exp)),
            Unary::Exp2 => self.smooth(function, |x| x.unary(Unary::Exp2).mul(point(std::f64::consts::LN_2).wider())),
            Unary::Log => self.smooth(function, |x| point(1.0).div(x)),
            Unary::Log2 => self.smooth(function, |x| point(std::f64::consts::LOG2_E).wider().div(x)),
            Unary::Sin => self.smooth(function, |x| x.unary(Unary::Cos)),
            Unary::Cos => self.smooth(function, |x| x.unary(Unary::Sin).negate()),
            _ => Affine::bounded(self.all.unary(function)),
        }
    }
    fn unary_split(self, function: Unary, splits: &mut IntegerSplits) -> Affine {
        let base = self.all.unary(Unary::Floor);
        if base.hi - base.lo != 1.0 {
            if base.lo < base.hi {
                splits.skip();
            }
            return self.unary(function);
        }
        let ends = [self.rest.hi, self.rest.lo].map(|rest| (base.hi - rest) / self.slope);
        if !splits.is_end([ends[0].min(ends[1]), ends[0].max(ends[1])]) {
            return self.unary(function);
        }
        let base = (0.5 * (self.rest.lo + self.rest.hi)).floor().clamp(base.lo, base.hi);
        if function == Unary::Floor {
            return Affine::new(base);
        }
        // The form continues beyond the integer, where the adjacent part applies.
        let part = self.sub(Affine::new(base));
        let within = Interval { lo: max_of(part.all.lo, 0.0), hi: min_of(part.all.hi, 1.0) };
        Affine::of(within, part.slope, part.rest)
    }
    #[inline(always)]
    fn binary(self, function: Binary, b: Affine) -> Affine {
        match function {
            Binary::Add => self.add(b),
            Binary::Sub => self.sub(b),
            Binary::Mul => self.mul(b),
            Binary::Div => self.div(b),
            Binary::Min => self.min(b),
            Binary::Max => self.negate().min(b.negate()).negate(),
            Binary::Unit => {
                let quotient = self.div(b);
                Affine::of(self.all.unit(b.all), quotient.slope, quotient.rest)
            }
            Binary::Pow => self.pow(b),
            Binary::Atan2 | Binary::Rem => Affine::bounded(self.all.binary(function, b.all)),
        }
    }
    #[inline(always)]
    fn mix(self, b: Affine, t: Affine) -> Affine {
        // `a + (b - a) t` is exact algebra; the offset covers the rounding of f64.
        let form = self.add(b.sub(self).mul(t));
        let largest = |x: Interval| max_of(x.hi, -x.lo);
        let size = (largest(self.all) + largest(b.all)) * (1.0 + largest(t.all));
        let off = ROUNDING * size;
        let rest = Interval { lo: form.rest.lo - off, hi: form.rest.hi + off };
        Affine::of(self.all.mix(b.all, t.all), form.slope, rest)
    }
    #[inline(always)]
    fn compare(self, comparison: Comparison, b: Affine) -> Tri {
        let of_bounds = self.all.compare(comparison, b.all);
        if comparison == Comparison::Equal {
            return of_bounds;
        }
        // The sign of the difference may be known where the bounds overlap.
        let of_form = self.sub(b).all.compare(comparison, Interval { lo: 0.0, hi: 0.0 });
        let known = of_bounds.may_hold & of_form.may_hold | of_bounds.may_fail & of_form.may_fail;
        Tri {
            may_hold: of_bounds.may_hold & (of_form.may_hold | !known),
            may_fail: of_bounds.may_fail & (of_form.may_fail | !known),
        }
    }
    fn is_nan(self) -> Tri {
        self.all.is_nan()
    }
    fn is_infinite(self) -> Tri {
        self.all.is_infinite()
    }
    #[inline(always)]
    fn to_int(self, signed: bool) -> Range {
        self.all.to_int(signed)
    }
    #[inline(always)]
    fn from_int(int: Range, signed: bool) -> Affine {
        Affine::bounded(Interval::from_int(int, signed))
    }
    fn to_bits(self, signed: bool) -> Range {
        self.all.to_bits(signed)
    }
    fn from_bits(int: Range) -> Affine {
        Affine::bounded(Interval::from_bits(int))
    }
    fn ldexp(self, exponent: Range) -> Affine {
        Affine::bounded(self.all.ldexp(exponent))
    }
    #[inline(never)]
    fn sample(image: &Image<'_>, at: [Affine; 3], level: Affine, wanted: [bool; 4]) -> [Affine; 4] {
        let all = Interval::sample(image, at.map(|at| at.all), level.all, wanted);
        if let Some(noise) = image.noise {
            return Affine::noise(noise, at, level, all);
        }
        let cell = (level.all.hi <= 0.0).then(|| image.cell(at.map(|at| [at.all.lo, at.all.hi]))).flatten();
        let Some((base, corners)) = cell else { return all.map(Affine::bounded) };
        let mut parts = [Affine::new(0.0); 3];
        for axis in 0..image.axes {
            let places = at[axis].mul(Affine::new(f64::from(image.size[axis])));
            parts[axis] = places.sub(Affine::new(base[axis] + 0.5));
        }
        [0, 1, 2, 3].map(|channel| {
            if !wanted[channel] {
                return Affine::new(0.0);
            }
            let mut values = corners.map(|texel| Affine::new(f64::from(texel[channel])));
            for axis in (0..image.axes).rev() {
                let half = 1 << axis;
                for low in 0..half {
                    values[low] = values[low].mix(values[low + half], parts[axis]);
                }
            }
            let (Affine { slope, rest, .. }, off) = (values[0], 2.0 * image.slack); // twice, for the roundings of weights
            Affine::of(all[channel], slope, Interval { lo: rest.lo - off, hi: rest.hi + off })
        })
    }
    fn fetch(image: &Image<'_>, at: [Range; 3]) -> [Affine; 4] {
        Interval::fetch(image, at).map(Affine::bounded)
    }
}
