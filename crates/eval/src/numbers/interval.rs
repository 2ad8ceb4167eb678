//! Intervals with outward rounding.
//!
//! Invariant: the interval of a box holds the result for every point of the box, in exact arithmetic and in f64. An
//! operation that gives NaN for any point gives the whole line, and only the whole line includes NaN.
//! Source: Moore 1966; the containment tests follow fidget (M. Keeter).

use super::integer_range::{Range, Tri};
use crate::number::{Binary, Comparison, Domain, Integer, Number, Unary, packed};
use crate::texture::{Image, Wrap};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// All numbers from `lo` to `hi`; the whole line also includes NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

/// Relative error allowed for functions of the standard library: a few ulp.
const LIBRARY: f64 = 1e-15;

/// Larger angles get the full range of sine and cosine, without a search for extremes.
const FAR: f64 = 1e6;

/// Minimum of two numbers other than NaN, in one instruction.
#[inline(always)]
pub(crate) fn min_of(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Maximum of two numbers other than NaN, in one instruction.
#[inline(always)]
pub(crate) fn max_of(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Interval {
    /// The whole line.
    pub const WHOLE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    /// The interval between two numbers in any order; the whole line if one is NaN.
    pub fn of(a: f64, b: f64) -> Interval {
        if a.is_nan() || b.is_nan() { Interval::WHOLE } else { Interval { lo: a.min(b), hi: a.max(b) } }
    }

    /// Whether a number or NaN is a member.
    pub fn contains(self, x: f64) -> bool {
        if x.is_nan() { self == Interval::WHOLE } else { self.lo <= x && x <= self.hi }
    }

    /// Widens the ends of correctly rounded operations outward by an ulp or two, without a branch.
    #[inline(always)]
    pub(crate) fn rounded(lo: f64, hi: f64) -> Interval {
        // A sum or product of 0 is exact unless it underflowed.
        let tiny = |x: f64| if x == 0.0 { 0.0 } else { f64::MIN_POSITIVE };
        let down = |x: f64| x - (x.abs() * f64::EPSILON + tiny(x));
        Interval::known(down(lo), -down(-hi))
    }

    /// An interval from its ends; the whole line if one is NaN.
    #[inline(always)]
    pub(crate) fn known(lo: f64, hi: f64) -> Interval {
        Interval::WHOLE.unless(lo <= hi, Interval { lo, hi })
    }

    /// `other` if `condition`, else `self`, without a branch.
    #[inline(always)]
    pub(crate) fn unless(self, condition: bool, other: Interval) -> Interval {
        Interval { lo: if condition { other.lo } else { self.lo }, hi: if condition { other.hi } else { self.hi } }
    }

    /// Widens by an ulp or two.
    #[inline(always)]
    pub(crate) fn wider(self) -> Interval {
        Interval::rounded(self.lo, self.hi)
    }

    /// Midpoint and radius.
    #[inline(always)]
    pub(crate) fn center(self) -> (f64, f64) {
        let middle = 0.5 * (self.lo + self.hi);
        (middle, max_of(self.hi - middle, middle - self.lo) * (1.0 + f64::EPSILON) + f64::MIN_POSITIVE)
    }

    /// Widens ends that functions of the standard library computed.
    #[inline(always)]
    fn library(lo: f64, hi: f64) -> Interval {
        let down = |x: f64| x - (x.abs() * LIBRARY + f64::MIN_POSITIVE);
        Interval::known(down(lo), -down(-hi))
    }

    /// Image under an increasing function.
    fn increasing(self, f: impl Fn(f64) -> f64) -> Interval {
        Interval::library(f(self.lo), f(self.hi))
    }

    /// Image under a function that increases on `[low, high]` and is undefined elsewhere.
    fn increasing_on(self, low: f64, high: f64, f: impl Fn(f64) -> f64) -> Interval {
        if self.lo < low || self.hi > high { Interval::WHOLE } else { self.increasing(f) }
    }

    /// Clamps both ends.
    #[inline(always)]
    fn clamp(self, lo: f64, hi: f64) -> Interval {
        Interval { lo: self.lo.clamp(lo, hi), hi: self.hi.clamp(lo, hi) }
    }

    #[inline(always)]
    fn abs(self) -> Interval {
        let Interval { lo, hi } = self;
        Interval { lo: max_of(max_of(lo, -hi), 0.0), hi: max_of(hi, -lo) }
    }

    #[inline(always)]
    pub(crate) fn negate(self) -> Interval {
        Interval { lo: -self.hi, hi: -self.lo }
    }

    /// Range of a function whose extremes are at corners of the box; NaN if a corner is.
    #[inline(always)]
    fn corners(self, b: Interval, f: impl Fn(f64, f64) -> f64) -> (f64, f64) {
        let [p, q, r, s] = [f(self.lo, b.lo), f(self.lo, b.hi), f(self.hi, b.lo), f(self.hi, b.hi)];
        let (lo, hi) = (min_of(min_of(p, q), min_of(r, s)), max_of(max_of(p, q), max_of(r, s)));
        // Both infinities among the corners also give NaN; the result is the whole line either way.
        let nan = (p + q + (r + s)).is_nan();
        (if nan { f64::NAN } else { lo }, if nan { f64::NAN } else { hi })
    }

    /// Range of `f`, the cosine of the angle plus `shift`.
    fn cosine(self, shift: f64, f: impl Fn(f64) -> f64) -> Interval {
        if self.lo.abs().max(self.hi.abs()) > FAR || self.hi - self.lo >= TAU {
            return if self == Interval::WHOLE || !(self.hi - self.lo).is_finite() {
                Interval::WHOLE // cos(infinity) is NaN
            } else {
                Interval { lo: -1.0, hi: 1.0 }
            };
        }
        // Whether an angle may be (2 k + odd) pi for an integer k.
        let has = |odd: f64| {
            let turns = |x: f64| (x + shift - odd * PI) / TAU;
            (turns(self.hi) + 1e-9).floor() >= (turns(self.lo) - 1e-9).ceil()
        };
        let ends = Interval::of(f(self.lo), f(self.hi));
        let lo = if has(1.0) { -1.0 } else { ends.lo - LIBRARY };
        let hi = if has(0.0) { 1.0 } else { ends.hi + LIBRARY };
        Interval { lo: lo.max(-1.0), hi: hi.min(1.0) }
    }

    #[inline(always)]
    pub(crate) fn add(self, b: Interval) -> Interval {
        Interval::rounded(self.lo + b.lo, self.hi + b.hi)
    }
    #[inline(always)]
    pub(crate) fn sub(self, b: Interval) -> Interval {
        Interval::rounded(self.lo - b.hi, self.hi - b.lo)
    }
    #[inline(always)]
    pub(crate) fn mul(self, b: Interval) -> Interval {
        let (lo, hi) = self.corners(b, |x, y| x * y);
        Interval::rounded(lo, hi)
    }
    #[inline(always)]
    pub(crate) fn div(self, b: Interval) -> Interval {
        let (lo, hi) = self.corners(b, |x, y| x / y);
        Interval::rounded(lo, hi).unless((b.lo <= 0.0) & (b.hi >= 0.0), Interval::WHOLE)
    }
    #[inline(always)]
    pub(crate) fn min(self, b: Interval) -> Interval {
        // Holds for NaN as well: the minimum is then the other number, which is at most its upper end.
        Interval { lo: min_of(self.lo, b.lo), hi: min_of(self.hi, b.hi) }
    }
    #[inline(never)]
    pub(crate) fn pow(self, b: Interval) -> Interval {
        if self.lo < 0.0 {
            return Interval::WHOLE;
        }
        let (lo, hi) = self.corners(b, f64::powf);
        Interval::library(lo, hi).clamp(0.0, f64::INFINITY)
    }
    #[inline(never)]
    fn atan2(self, x: Interval) -> Interval {
        if self == Interval::WHOLE || x == Interval::WHOLE {
            return Interval::WHOLE;
        }
        if self.contains(0.0) && x.lo <= 0.0 {
            return Interval { lo: -PI.next_up(), hi: PI.next_up() };
        }
        // Off the origin and the branch cut, the corners have the extreme angles.
        let (lo, hi) = self.corners(x, f64::atan2);
        Interval::library(lo, hi)
    }
    #[inline(never)]
    fn rem(self, b: Interval) -> Interval {
        if b.contains(0.0) || self.lo.is_infinite() || self.hi.is_infinite() {
            return Interval::WHOLE;
        }
        let whole = self.div(b).unary(Unary::Trunc);
        let largest = b.abs().hi;
        let bound =
            Interval { lo: if self.lo < 0.0 { -largest } else { 0.0 }, hi: if self.hi > 0.0 { largest } else { 0.0 } };
        let found = self.sub(b.mul(whole));
        let met = Interval { lo: found.lo.max(bound.lo), hi: found.hi.min(bound.hi) };
        if met.lo <= met.hi { met } else { bound } // rounding may turn the ends around
    }
    #[inline(always)]
    pub(crate) fn unit(self, length: Interval) -> Interval {
        let margin = 1.0 + 4.0 * f64::EPSILON;
        // 0 / 0 and infinity / infinity are NaN.
        let unknown =
            (self == Interval::WHOLE) | (length.lo <= 0.0) & (length.hi >= 0.0) | (length.hi == f64::INFINITY);
        self.div(length).clamp(-margin, margin).unless(unknown, Interval::WHOLE)
    }

    fn tangent(self) -> Interval {
        let cosine = self.cosine(0.0, f64::cos);
        if cosine.lo <= 1e-12 && cosine.hi >= -1e-12 || self.hi - self.lo >= PI {
            return Interval::WHOLE;
        }
        let scaled = self.increasing(f64::tan);
        // Near a pole the slope amplifies the rounding of the angle.
        let off = LIBRARY * (1.0 + self.lo.abs().max(self.hi.abs()));
        let slope = 1.0 + scaled.lo.abs().max(scaled.hi.abs()).powi(2);
        Interval { lo: scaled.lo - off * slope, hi: scaled.hi + off * slope }
    }
}

packed!(Interval as x: 2 f64 { lo: x.lo, hi: x.hi } => Interval { lo, hi });

impl Domain for Interval {
    fn any() -> Interval {
        Interval::WHOLE
    }
    #[inline(always)]
    fn join(self, other: Interval) -> Interval {
        Interval { lo: min_of(self.lo, other.lo), hi: max_of(self.hi, other.hi) }
    }
    fn is_within(self, other: Interval) -> bool {
        other.lo <= self.lo && self.hi <= other.hi
    }
}

impl Number for Interval {
    type Int = Range;
    type Bool = Tri;
    const DECIDED: bool = false;

    #[inline(always)]
    fn new(x: f64) -> Interval {
        Interval::of(x, x)
    }
    #[inline(always)]
    fn select(condition: Tri, a: Interval, b: Interval) -> Interval {
        a.join(b).unless(!condition.may_hold, b).unless(!condition.may_fail, a)
    }
    #[inline(always)]
    fn select_decided(condition: Tri, a: Interval, b: Interval) -> Interval {
        b.unless(condition.may_hold, a)
    }
    #[inline(always)] // for functions that are chosen outside the loop over lanes
    fn unary(self, function: Unary) -> Interval {
        let Interval { lo, hi } = self;
        match function {
            Unary::Negate => self.negate(),
            Unary::Abs => self.abs().unless(self == Interval::WHOLE, self),
            Unary::Sign | Unary::Floor | Unary::Ceil | Unary::Trunc | Unary::Round => {
                Interval { lo: lo.unary(function), hi: hi.unary(function) }
            }
            Unary::Fract => {
                let [low, high] = [lo, hi].map(|x| x.unary(Unary::Floor));
                let within = Interval::rounded(lo - low, hi - high).clamp(0.0, 1.0);
                let finite = lo > f64::NEG_INFINITY && hi < f64::INFINITY;
                let any = Interval::WHOLE.unless(finite, Interval { lo: 0.0, hi: 1.0 });
                any.unless(finite & (low == high), within)
            }
            Unary::Saturate => Interval { lo: min_of(max_of(lo, 0.0), 1.0), hi: min_of(max_of(hi, 0.0), 1.0) },
            Unary::Square => {
                let Interval { lo, hi } = self.abs();
                let squared = Interval::rounded(lo * lo, hi * hi);
                Interval { lo: max_of(squared.lo, 0.0), hi: squared.hi }.unless(self == Interval::WHOLE, self)
            }
            Unary::Sqrt => {
                let Interval { lo, hi } = Interval::rounded(lo.sqrt(), hi.sqrt()); // NaN below 0
                Interval { lo: max_of(lo, 0.0), hi }.unless(self.lo < 0.0, Interval::WHOLE)
            }
            _ if self == Interval::WHOLE => Interval::WHOLE,
            Unary::InverseSqrt if lo < 0.0 => Interval::WHOLE,
            // Two roundings.
            Unary::InverseSqrt => Interval::library(1.0 / hi.sqrt(), 1.0 / lo.abs().sqrt()).clamp(0.0, f64::INFINITY),
            Unary::Hermite => {
                let [lo, hi] = [lo, hi].map(|t| t.clamp(0.0, 1.0));
                Interval::library(lo.unary(function), hi.unary(function))
            }
            Unary::Exp => self.increasing(f64::exp).clamp(0.0, f64::INFINITY),
            Unary::Exp2 => self.increasing(f64::exp2).clamp(0.0, f64::INFINITY),
            Unary::Log => self.increasing_on(0.0, f64::INFINITY, f64::ln),
            Unary::Log2 => self.increasing_on(0.0, f64::INFINITY, f64::log2),
            Unary::Sin => self.cosine(-FRAC_PI_2, f64::sin),
            Unary::Cos => self.cosine(0.0, f64::cos),
            Unary::Tan => self.tangent(),
            Unary::Asin => self.increasing_on(-1.0, 1.0, f64::asin),
            Unary::Acos => self.increasing_on(-1.0, 1.0, |x| -x.acos()).negate(),
            Unary::Atan => self.increasing(f64::atan),
            Unary::Sinh => self.increasing(f64::sinh),
            Unary::Cosh => self.abs().increasing(f64::cosh),
            Unary::Tanh => self.increasing(f64::tanh).clamp(-1.0, 1.0),
            Unary::Asinh => self.increasing(f64::asinh),
            Unary::Acosh => self.increasing_on(1.0, f64::INFINITY, f64::acosh),
            Unary::Atanh => self.increasing_on(-1.0, 1.0, f64::atanh),
        }
    }
    #[inline(always)]
    fn binary(self, function: Binary, b: Interval) -> Interval {
        match function {
            Binary::Add => self.add(b),
            Binary::Sub => self.sub(b),
            Binary::Mul => self.mul(b),
            Binary::Div => self.div(b),
            Binary::Min => self.min(b),
            Binary::Max => self.negate().min(b.negate()).negate(),
            Binary::Unit => self.unit(b),
            Binary::Pow => self.pow(b),
            Binary::Atan2 => self.atan2(b),
            Binary::Rem => self.rem(b),
        }
    }
    #[inline(always)]
    fn mix(self, b: Interval, t: Interval) -> Interval {
        // Linear in each argument, so the extremes are at corners.
        let [(a, c), (d, e)] = [t.lo, t.hi].map(|t| self.corners(b, |x, y| x * (1.0 - t) + y * t));
        let largest = |x: Interval| max_of(x.hi, -x.lo);
        let size = (largest(self) + largest(b)) * (1.0 + largest(t));
        let margin = 4.0 * f64::EPSILON * size + f64::MIN_POSITIVE;
        let known = (margin < f64::INFINITY) & !(a + d).is_nan();
        let found = Interval { lo: min_of(a, d) - margin, hi: max_of(c, e) + margin };
        Interval::WHOLE.unless(known, found)
    }
    #[inline(always)]
    fn compare(self, comparison: Comparison, b: Interval) -> Tri {
        let nan = self == Interval::WHOLE || b == Interval::WHOLE;
        let (may_hold, may_fail) = match comparison {
            Comparison::Less => (self.lo < b.hi, self.hi >= b.lo),
            // NaN fails, even against infinity.
            Comparison::LessEqual => (self.lo <= b.hi, self.hi > b.lo || nan),
            Comparison::Equal => (self.lo <= b.hi && b.lo <= self.hi, self.lo != self.hi || self != b),
        };
        Tri { may_hold, may_fail }
    }
    fn is_nan(self) -> Tri {
        Tri { may_hold: self == Interval::WHOLE, may_fail: true }
    }
    fn is_infinite(self) -> Tri {
        Tri { may_hold: self.lo.is_infinite() || self.hi.is_infinite(), may_fail: true }
    }
    #[inline(always)]
    fn to_int(self, signed: bool) -> Range {
        // NaN may become any integer; the ends of the whole line clamp to the full range.
        let full = Range::full(signed);
        Range { lo: (self.lo as i64).clamp(full.lo, full.hi), hi: (self.hi as i64).clamp(full.lo, full.hi) }
    }
    #[inline(always)]
    fn from_int(int: Range, _: bool) -> Interval {
        Interval { lo: int.lo as f64, hi: int.hi as f64 }
    }
    fn to_bits(self, signed: bool) -> Range {
        if self.lo == self.hi { Range::new((self.lo as f32).to_bits(), signed) } else { Range::full(signed) }
    }
    fn from_bits(int: Range) -> Interval {
        int.single().map_or(Interval::WHOLE, |bits| Interval::new(f64::from(f32::from_bits(bits))))
    }
    fn ldexp(self, exponent: Range) -> Interval {
        let [low, high] = [exponent.lo, exponent.hi].map(|e| e.clamp(-2200, 2200) as i32 as u32);
        let ends = [self.lo, self.hi].map(|x| [x.ldexp(low), x.ldexp(high)]);
        let values = ends.as_flattened();
        if self == Interval::WHOLE || values.iter().any(|value| value.is_nan()) {
            return Interval::WHOLE;
        }
        let fold = |f: fn(f64, f64) -> f64, start| values.iter().copied().fold(start, f);
        Interval::rounded(fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY))
    }
    #[inline(never)]
    fn sample(image: &Image<'_>, at: [Interval; 3], level: Interval, wanted: [bool; 4]) -> [Interval; 4] {
        let endless = |at: &Interval| at.lo.is_infinite() || at.hi.is_infinite();
        let nowhere = |at: &Interval| *at == Interval::WHOLE || image.wrap != Wrap::Clamp && endless(at);
        if image.noise.is_none() && at[..image.axes].iter().any(nowhere) {
            return [Interval::WHOLE; 4]; // NaN; noise clamps to its farthest cells instead
        }
        let levels = if level == Interval::WHOLE { [0.0, f64::INFINITY] } else { [level.lo, level.hi] };
        image.range_levels(at.map(|at| [at.lo, at.hi]), levels, wanted).map(|[lo, hi]| Interval { lo, hi })
    }
    fn fetch(image: &Image<'_>, at: [Range; 3]) -> [Interval; 4] {
        let sides = image.size.map(|side| side as usize);
        let of = [0, 1, 2].map(|axis| at[axis].index(sides[axis])).map(|(first, last)| [first, last]);
        image.texels(of).map(|[lo, hi]| Interval { lo, hi })
    }
}
