//! Affine forms of one symbol: bounds of everything that a program may compute on a segment.
//!
//! Role: the symbol s is the place on the segment, from -1 at its one end to 1 at the other; a number is
//! `slope * s + rest`, with an interval for what is not linear. What depends on the place alone keeps its dependency, so
//! that bounds narrow with the segment itself, where those of plain intervals are wider by every repeated variable.
//! Invariant: as for [`Interval`], which holds as well and cuts off what the form gains nothing in.
//! Source: Comba and Stolfi 1993; rests as in Berz and Makino's Taylor models, of order 1.

use super::case::Case;
use super::interval::{Interval, greater, lesser};
use super::number::{GROUP, Number, Packed, Unary};
use super::range::{Range, Tri};
use super::segment::SegmentBounds;
use super::texture::Image;
use super::{BoundProgram, ExactError, Lanes, Measured};
use noise::{Knots, Lattice, ROUNDED};

/// A number along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Bounds over the whole segment.
    pub all: Interval,
    /// How much it changes from the middle of the segment to its end, as far as that is linear.
    slope: f64,
    /// What is left of it.
    rest: Interval,
}

/// Noise in longer boxes is not taken as linear, in lattice cells: its form says less there than its range.
const LINEAR: f64 = 0.25;

/// What a few operations on numbers of this size are rounded by.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Affine {
    /// From one number to another as the place goes along the segment.
    pub fn between(from: f64, to: f64) -> Affine {
        let (middle, slope) = (0.5 * (from + to), 0.5 * (to - from));
        let off = ROUNDING * (from.abs() + to.abs()) + f64::MIN_POSITIVE;
        Affine { all: Interval::of(from, to), slope, rest: Interval { lo: middle - off, hi: middle + off } }
    }

    /// What it says of the number.
    pub(super) fn bounds(self) -> SegmentBounds {
        let mean = Interval { lo: greater(self.rest.lo, self.all.lo), hi: lesser(self.rest.hi, self.all.hi) };
        SegmentBounds { all: self.all, mean: self.all.unless(mean.lo <= mean.hi, mean) }
    }

    /// The same on a part of the segment.
    pub(super) fn part(self, [from, to]: [f64; 2]) -> Affine {
        if self.slope == 0.0 {
            return self;
        }
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let moved = self.slope * middle;
        let off = ROUNDING * self.slope.abs();
        let rest = Interval::rounded(self.rest.lo + moved - off, self.rest.hi + moved + off);
        Affine::of(self.all, self.slope * half, rest.wider())
    }

    /// Of which bounds alone are known.
    #[inline(always)]
    pub fn bounded(all: Interval) -> Affine {
        Affine { all, slope: 0.0, rest: all }
    }

    /// A form and bounds of the same number.
    #[inline(always)]
    fn of(all: Interval, slope: f64, rest: Interval) -> Affine {
        let reach = slope.abs();
        let line = Interval::rounded(rest.lo - reach, rest.hi + reach);
        let met = Interval { lo: greater(all.lo, line.lo), hi: lesser(all.hi, line.hi) };
        let all = all.unless(met.lo <= met.hi, met);
        let gains = rest.hi - rest.lo < all.hi - all.lo; // not where one is NaN or infinite
        Affine { all, slope: if gains { slope } else { 0.0 }, rest: all.unless(gains, rest) }
    }

    /// A function by its value in the middle of this number's bounds, and by bounds of its slope over all of them.
    #[inline(always)]
    fn along(self, middle: f64, value: Interval, slopes: Interval, all: Interval) -> Affine {
        let (center, off) = slopes.center();
        let slope = center * self.slope;
        let bent = off * self.slope.abs() + ROUNDING * slope.abs();
        let rest = value.add(slopes.mul(self.rest.sub(Interval { lo: middle, hi: middle })));
        Affine::of(all, slope, Interval::rounded(rest.lo - bent, rest.hi + bent))
    }

    /// A smooth function of one number.
    #[inline(always)]
    fn smooth(self, function: Unary, slopes: impl Fn(Interval) -> Interval) -> Affine {
        let all = self.all.unary(function);
        let middle = 0.5 * (self.all.lo + self.all.hi);
        let value = Interval { lo: middle, hi: middle }.unary(function);
        self.along(middle, value, slopes(self.all), all)
    }

    /// Noise by its value in the middle of the box of its places, and by how steep it is in the box.
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
        // GLSL has its constants in 32 bits.
        found[3] = Affine::of(all[3], form.slope, Interval { lo: form.rest.lo - ROUNDED, hi: form.rest.hi + ROUNDED });
        found
    }

    #[inline(always)]
    fn negate(self) -> Affine {
        Affine { all: self.all.negate(), slope: -self.slope, rest: self.rest.negate() }
    }

    /// The one or the other, whichever it is at each place.
    #[inline(always)]
    fn either(self, other: Affine, all: Interval) -> Affine {
        let slope = 0.5 * (self.slope + other.slope);
        let off = (0.5 + ROUNDING) * (self.slope - other.slope).abs() + ROUNDING * slope.abs();
        let rest = self.rest.join(other.rest);
        Affine::of(all, slope, Interval::rounded(rest.lo - off, rest.hi + off))
    }

    #[inline(always)]
    fn unless(self, so: bool, other: Affine) -> Affine {
        Affine {
            all: self.all.unless(so, other.all),
            slope: if so { other.slope } else { self.slope },
            rest: self.rest.unless(so, other.rest),
        }
    }

    /// Signs that the difference may have, in addition to what bounds of both say.
    #[inline(always)]
    fn compared(self, b: Affine, by: impl Fn(Interval, Interval) -> Tri) -> Tri {
        let (of_bounds, of_form) = (by(self.all, b.all), by(self.sub(b).all, Interval { lo: 0.0, hi: 0.0 }));
        let known = of_bounds.may_hold & of_form.may_hold | of_bounds.may_fail & of_form.may_fail;
        Tri {
            may_hold: of_bounds.may_hold & (of_form.may_hold | !known),
            may_fail: of_bounds.may_fail & (of_form.may_fail | !known),
        }
    }
}

impl Packed for Affine {
    type Group = [[f64; GROUP]; 5];

    #[inline(always)]
    fn splat(self) -> Self::Group {
        [self.all.lo, self.all.hi, self.slope, self.rest.lo, self.rest.hi].map(|part| [part; GROUP])
    }
    #[inline(always)]
    fn get([lo, hi, slope, low, high]: &Self::Group, place: usize) -> Affine {
        let all = Interval { lo: lo[place], hi: hi[place] };
        Affine { all, slope: slope[place], rest: Interval { lo: low[place], hi: high[place] } }
    }
    #[inline(always)]
    fn put(self, [lo, hi, slope, low, high]: &mut Self::Group, place: usize) {
        (lo[place], hi[place], slope[place]) = (self.all.lo, self.all.hi, self.slope);
        (low[place], high[place]) = (self.rest.lo, self.rest.hi);
    }
}

impl Number for Affine {
    type Int = Range;
    type Truth = Tri;
    const DECIDED: bool = false;

    fn measure(program: &BoundProgram<'_>, lanes: &Lanes<Self>) -> Result<Measured<Self>, ExactError> {
        program.evaluate(lanes, &mut [], None)
    }

    #[inline(always)]
    fn new(x: f64) -> Affine {
        Affine::bounded(Interval::new(x))
    }
    fn whole() -> Affine {
        Affine::bounded(Interval::WHOLE)
    }
    #[inline(always)]
    fn join(self, other: Affine) -> Affine {
        self.either(other, self.all.join(other.all))
    }
    fn within(self, other: Affine) -> bool {
        let off = (self.slope - other.slope).abs();
        let rest = Interval { lo: self.rest.lo - off, hi: self.rest.hi + off };
        self.all.within(other.all) && (off == 0.0 && self.rest.within(other.rest) || rest.within(other.rest))
    }
    #[inline(always)]
    fn select(truth: Tri, a: Affine, b: Affine) -> Affine {
        a.join(b).unless(!truth.may_hold, b).unless(!truth.may_fail, a)
    }
    #[inline(always)]
    fn one_of(truth: Tri, a: Affine, b: Affine) -> Affine {
        b.unless(truth.may_hold, a)
    }
    fn at_most(self, b: Affine) -> Affine {
        // NaN is not compared.
        let hi = lesser(self.all.hi, b.all.hi);
        let known = self.all != Interval::WHOLE && b.all != Interval::WHOLE && self.all.lo <= hi;
        if known { Affine { all: Interval { lo: self.all.lo, hi }, ..self } } else { self }
    }
    fn at_least(self, b: Affine) -> Affine {
        self.negate().at_most(b.negate()).negate()
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
    fn in_case(self, function: Unary, case: &mut Case) -> Affine {
        let base = self.all.unary(Unary::Floor);
        if base.hi - base.lo != 1.0 {
            if base.lo < base.hi {
                case.skip();
            }
            return self.unary(function);
        }
        let ends = [self.rest.hi, self.rest.lo].map(|rest| (base.hi - rest) / self.slope);
        if !case.is_end([ends[0].min(ends[1]), ends[0].max(ends[1])]) {
            return self.unary(function);
        }
        let base = (0.5 * (self.rest.lo + self.rest.hi)).floor().clamp(base.lo, base.hi);
        if function == Unary::Floor {
            return Affine::new(base);
        }
        // Beyond the integer the form goes on: there is the other part.
        let part = self.sub(Affine::new(base));
        let within = Interval { lo: greater(part.all.lo, 0.0), hi: lesser(part.all.hi, 1.0) };
        Affine::of(within, part.slope, part.rest)
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
        let bent = self.slope * b.slope; // times the square of the place, from 0 to 1
        // Each is a line, up to v and w from it: so is the product of the lines, up to what these add.
        let (line, other) = (self.slope.abs() + m.abs(), b.slope.abs() + n.abs() + w);
        let off = line * w + other * v + (ROUNDING * ((line + v) * other) + f64::MIN_POSITIVE);
        let middle = m * n;
        let rest = Interval::known(middle + lesser(bent, 0.0) - off, middle + greater(bent, 0.0) + off);
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
    #[inline(always)]
    fn max(self, b: Affine) -> Affine {
        self.negate().min(b.negate()).negate()
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
    fn atan2(self, x: Affine) -> Affine {
        Affine::bounded(self.all.atan2(x.all))
    }
    fn rem(self, b: Affine) -> Affine {
        Affine::bounded(self.all.rem(b.all))
    }
    #[inline(always)]
    fn unit(self, length: Affine) -> Affine {
        let quotient = self.div(length);
        Affine::of(self.all.unit(length.all), quotient.slope, quotient.rest)
    }
    #[inline(always)]
    fn mix(self, b: Affine, t: Affine) -> Affine {
        // In exact arithmetic; f64 rounds each of two products and a sum.
        let form = self.add(b.sub(self).mul(t));
        let largest = |x: Interval| greater(x.hi, -x.lo);
        let size = (largest(self.all) + largest(b.all)) * (1.0 + largest(t.all));
        let off = ROUNDING * size;
        let rest = Interval { lo: form.rest.lo - off, hi: form.rest.hi + off };
        Affine::of(self.all.mix(b.all, t.all), form.slope, rest)
    }
    #[inline(always)]
    fn less(self, b: Affine) -> Tri {
        self.compared(b, Interval::less)
    }
    #[inline(always)]
    fn less_equal(self, b: Affine) -> Tri {
        self.compared(b, Interval::less_equal)
    }
    #[inline(always)]
    fn equal(self, b: Affine) -> Tri {
        self.all.equal(b.all)
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
            Affine::of(all[channel], values[0].slope, values[0].rest)
        })
    }
    fn fetch(image: &Image<'_>, at: [Range; 3]) -> [Affine; 4] {
        Interval::fetch(image, at).map(Affine::bounded)
    }
}
