//! Intervals with outward rounding: bounds of everything that a program may compute from a box of inputs.
//!
//! Invariant: whatever a point of the box gives in exact arithmetic or in f64 lies in the interval of the box; an
//! operation that gives NaN for a point of its box gives the whole line, which alone stands for NaN as well.
//! Source: Moore 1966; the containment tests follow fidget (M. Keeter).

use super::number::{GROUP, Integer, Number, Packed, Unary};
use super::range::{Range, Tri};
use super::texture::{Image, Wrap};
use super::{BoundProgram, ExactError, Lanes, Measured};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// All numbers from `lo` to `hi`; from -infinity to infinity: anything, NaN included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The least.
    pub lo: f64,
    /// The greatest.
    pub hi: f64,
}

/// Relative error that is allowed for functions of the standard library: some ulp.
const LIBRARY: f64 = 1e-15;

/// Beyond it, where extremes of sine and cosine are is not decided.
const FAR: f64 = 1e6;

/// The lesser of two that are not NaN, in one instruction.
#[inline(always)]
pub(super) fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater, as [`lesser`].
#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Interval {
    /// The whole line.
    pub const WHOLE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    /// The numbers between two, in any order.
    pub fn of(a: f64, b: f64) -> Interval {
        if a.is_nan() || b.is_nan() { Interval::WHOLE } else { Interval { lo: a.min(b), hi: a.max(b) } }
    }

    /// Whether a number, or NaN, is in it.
    pub fn contains(self, x: f64) -> bool {
        if x.is_nan() { self == Interval::WHOLE } else { self.lo <= x && x <= self.hi }
    }

    /// Bounds that are the ends of correctly rounded operations: an ulp or two outward, without a jump.
    #[inline(always)]
    pub(super) fn rounded(lo: f64, hi: f64) -> Interval {
        // Sums and products that are 0 are so exactly, but for what is too small for a normal number.
        let tiny = |x: f64| if x == 0.0 { 0.0 } else { f64::MIN_POSITIVE };
        let down = |x: f64| x - (x.abs() * f64::EPSILON + tiny(x));
        Interval::known(down(lo), -down(-hi))
    }

    /// These bounds; the whole line, where one is NaN.
    #[inline(always)]
    pub(super) fn known(lo: f64, hi: f64) -> Interval {
        Interval::WHOLE.unless(lo <= hi, Interval { lo, hi })
    }

    /// The other one, if that is so.
    #[inline(always)]
    pub(super) fn unless(self, so: bool, other: Interval) -> Interval {
        Interval { lo: if so { other.lo } else { self.lo }, hi: if so { other.hi } else { self.hi } }
    }

    /// With an ulp or two more.
    #[inline(always)]
    pub(super) fn wider(self) -> Interval {
        Interval::rounded(self.lo, self.hi)
    }

    /// Its middle, and how far from there its ends are at most.
    #[inline(always)]
    pub(super) fn center(self) -> (f64, f64) {
        let middle = 0.5 * (self.lo + self.hi);
        (middle, greater(self.hi - middle, middle - self.lo) * (1.0 + f64::EPSILON) + f64::MIN_POSITIVE)
    }

    /// Bounds that come from the standard library.
    #[inline(always)]
    fn library(lo: f64, hi: f64) -> Interval {
        let down = |x: f64| x - (x.abs() * LIBRARY + f64::MIN_POSITIVE);
        Interval::known(down(lo), -down(-hi))
    }

    /// Of a function that rises.
    fn rising(self, f: impl Fn(f64) -> f64) -> Interval {
        Interval::library(f(self.lo), f(self.hi))
    }

    /// Of a function that rises on `[low, high]` and is not defined elsewhere.
    fn rising_within(self, low: f64, high: f64, f: impl Fn(f64) -> f64) -> Interval {
        if self.lo < low || self.hi > high { Interval::WHOLE } else { self.rising(f) }
    }

    #[inline(always)]
    fn meet(self, lo: f64, hi: f64) -> Interval {
        Interval { lo: self.lo.clamp(lo, hi), hi: self.hi.clamp(lo, hi) }
    }

    #[inline(always)]
    fn abs(self) -> Interval {
        let Interval { lo, hi } = self;
        Interval { lo: greater(greater(lo, -hi), 0.0), hi: greater(hi, -lo) }
    }

    #[inline(always)]
    pub(super) fn negate(self) -> Interval {
        Interval { lo: -self.hi, hi: -self.lo }
    }

    #[inline(always)]
    fn is_whole(self) -> bool {
        self == Interval::WHOLE
    }

    /// `f` at every combination of the ends, NaN where one is: of a function whose extremes are at corners.
    #[inline(always)]
    fn corners(self, b: Interval, f: impl Fn(f64, f64) -> f64) -> (f64, f64) {
        let [p, q, r, s] = [f(self.lo, b.lo), f(self.lo, b.hi), f(self.hi, b.lo), f(self.hi, b.hi)];
        let (lo, hi) = (lesser(lesser(p, q), lesser(r, s)), greater(greater(p, q), greater(r, s)));
        // Also NaN where both infinities are among them, and the bounds are the whole line anyway.
        let nan = (p + q + (r + s)).is_nan();
        (if nan { f64::NAN } else { lo }, if nan { f64::NAN } else { hi })
    }

    /// Cosine; `shift` is added to the angle.
    fn cosine(self, shift: f64, f: impl Fn(f64) -> f64) -> Interval {
        if self.lo.abs().max(self.hi.abs()) > FAR || self.hi - self.lo >= TAU {
            return if self.is_whole() || !(self.hi - self.lo).is_finite() {
                Interval::WHOLE // the cosine of infinity is NaN
            } else {
                Interval { lo: -1.0, hi: 1.0 }
            };
        }
        // Whether (2 k + odd) pi is among the angles; where that is uncertain it is.
        let has = |odd: f64| {
            let turns = |x: f64| (x + shift - odd * PI) / TAU;
            (turns(self.hi) + 1e-9).floor() >= (turns(self.lo) - 1e-9).ceil()
        };
        let ends = Interval::of(f(self.lo), f(self.hi));
        let lo = if has(1.0) { -1.0 } else { ends.lo - LIBRARY };
        let hi = if has(0.0) { 1.0 } else { ends.hi + LIBRARY };
        Interval { lo: lo.max(-1.0), hi: hi.min(1.0) }
    }

    fn tangent(self) -> Interval {
        let cosine = self.cosine(0.0, f64::cos);
        if cosine.lo <= 1e-12 && cosine.hi >= -1e-12 || self.hi - self.lo >= PI {
            return Interval::WHOLE;
        }
        let scaled = self.rising(f64::tan);
        // The slope is large near a pole: a rounding of the angle counts as much.
        let off = LIBRARY * (1.0 + self.lo.abs().max(self.hi.abs()));
        let slope = 1.0 + scaled.lo.abs().max(scaled.hi.abs()).powi(2);
        Interval { lo: scaled.lo - off * slope, hi: scaled.hi + off * slope }
    }
}

impl Packed for Interval {
    type Group = [[f64; GROUP]; 2];

    #[inline(always)]
    fn splat(self) -> Self::Group {
        [self.lo, self.hi].map(|end| [end; GROUP])
    }
    #[inline(always)]
    fn get([lo, hi]: &Self::Group, place: usize) -> Interval {
        Interval { lo: lo[place], hi: hi[place] }
    }
    #[inline(always)]
    fn put(self, [lo, hi]: &mut Self::Group, place: usize) {
        (lo[place], hi[place]) = (self.lo, self.hi);
    }
}

impl Number for Interval {
    type Int = Range;
    type Truth = Tri;
    const DECIDED: bool = false;

    fn measure(program: &BoundProgram<'_>, lanes: &Lanes<Self>) -> Result<Measured<Self>, ExactError> {
        program.evaluate(lanes, &mut [], None)
    }

    #[inline(always)]
    fn new(x: f64) -> Interval {
        Interval::of(x, x)
    }
    fn whole() -> Interval {
        Interval::WHOLE
    }
    #[inline(always)]
    fn join(self, other: Interval) -> Interval {
        Interval { lo: lesser(self.lo, other.lo), hi: greater(self.hi, other.hi) }
    }
    fn within(self, other: Interval) -> bool {
        other.lo <= self.lo && self.hi <= other.hi
    }
    #[inline(always)]
    fn select(truth: Tri, a: Interval, b: Interval) -> Interval {
        a.join(b).unless(!truth.may_hold, b).unless(!truth.may_fail, a)
    }
    #[inline(always)]
    fn one_of(truth: Tri, a: Interval, b: Interval) -> Interval {
        b.unless(truth.may_hold, a)
    }
    #[inline(always)] // of those functions that are known before the loop over lanes
    fn unary(self, function: Unary) -> Interval {
        let Interval { lo, hi } = self;
        match function {
            Unary::Negate => self.negate(),
            Unary::Abs => self.abs().unless(self.is_whole(), self),
            Unary::Sign | Unary::Floor | Unary::Ceil | Unary::Trunc | Unary::Round => {
                Interval { lo: lo.unary(function), hi: hi.unary(function) }
            }
            Unary::Fract => {
                let [low, high] = [lo, hi].map(|x| x.unary(Unary::Floor));
                let within = Interval::rounded(lo - low, hi - high).meet(0.0, 1.0);
                let finite = lo > f64::NEG_INFINITY && hi < f64::INFINITY;
                let any = Interval::WHOLE.unless(finite, Interval { lo: 0.0, hi: 1.0 });
                any.unless(finite & (low == high), within)
            }
            Unary::Saturate => Interval { lo: lesser(greater(lo, 0.0), 1.0), hi: lesser(greater(hi, 0.0), 1.0) },
            Unary::Square => {
                let Interval { lo, hi } = self.abs();
                let squared = Interval::rounded(lo * lo, hi * hi);
                Interval { lo: greater(squared.lo, 0.0), hi: squared.hi }.unless(self.is_whole(), self)
            }
            Unary::Sqrt => {
                let Interval { lo, hi } = Interval::rounded(lo.sqrt(), hi.sqrt()); // NaN below 0
                Interval { lo: greater(lo, 0.0), hi }.unless(self.lo < 0.0, Interval::WHOLE)
            }
            _ if self.is_whole() => Interval::WHOLE,
            Unary::InverseSqrt if lo < 0.0 => Interval::WHOLE,
            // Of a rounded root: two roundings.
            Unary::InverseSqrt => Interval::library(1.0 / hi.sqrt(), 1.0 / lo.abs().sqrt()).meet(0.0, f64::INFINITY),
            Unary::Hermite => {
                let [lo, hi] = [lo, hi].map(|t| t.clamp(0.0, 1.0));
                Interval::library(lo.unary(function), hi.unary(function))
            }
            Unary::Exp => self.rising(f64::exp).meet(0.0, f64::INFINITY),
            Unary::Exp2 => self.rising(f64::exp2).meet(0.0, f64::INFINITY),
            Unary::Log => self.rising_within(0.0, f64::INFINITY, f64::ln),
            Unary::Log2 => self.rising_within(0.0, f64::INFINITY, f64::log2),
            Unary::Sin => self.cosine(-FRAC_PI_2, f64::sin),
            Unary::Cos => self.cosine(0.0, f64::cos),
            Unary::Tan => self.tangent(),
            Unary::Asin => self.rising_within(-1.0, 1.0, f64::asin),
            Unary::Acos => self.rising_within(-1.0, 1.0, |x| -x.acos()).negate(),
            Unary::Atan => self.rising(f64::atan),
            Unary::Sinh => self.rising(f64::sinh),
            Unary::Cosh => self.abs().rising(f64::cosh),
            Unary::Tanh => self.rising(f64::tanh).meet(-1.0, 1.0),
            Unary::Asinh => self.rising(f64::asinh),
            Unary::Acosh => self.rising_within(1.0, f64::INFINITY, f64::acosh),
            Unary::Atanh => self.rising_within(-1.0, 1.0, f64::atanh),
        }
    }
    #[inline(always)]
    fn add(self, b: Interval) -> Interval {
        Interval::rounded(self.lo + b.lo, self.hi + b.hi)
    }
    #[inline(always)]
    fn sub(self, b: Interval) -> Interval {
        Interval::rounded(self.lo - b.hi, self.hi - b.lo)
    }
    #[inline(always)]
    fn mul(self, b: Interval) -> Interval {
        let (lo, hi) = self.corners(b, |x, y| x * y);
        Interval::rounded(lo, hi)
    }
    #[inline(always)]
    fn div(self, b: Interval) -> Interval {
        let (lo, hi) = self.corners(b, |x, y| x / y);
        Interval::rounded(lo, hi).unless((b.lo <= 0.0) & (b.hi >= 0.0), Interval::WHOLE)
    }
    #[inline(always)]
    fn min(self, b: Interval) -> Interval {
        // Also where one of them may be NaN: then the other, which is not above its own end.
        Interval { lo: lesser(self.lo, b.lo), hi: lesser(self.hi, b.hi) }
    }
    #[inline(always)]
    fn max(self, b: Interval) -> Interval {
        self.negate().min(b.negate()).negate()
    }
    #[inline(never)]
    fn pow(self, b: Interval) -> Interval {
        if self.lo < 0.0 {
            return Interval::WHOLE;
        }
        let (lo, hi) = self.corners(b, f64::powf);
        Interval::library(lo, hi).meet(0.0, f64::INFINITY)
    }
    #[inline(never)]
    fn atan2(self, x: Interval) -> Interval {
        if self.is_whole() || x.is_whole() {
            return Interval::WHOLE;
        }
        if self.contains(0.0) && x.lo <= 0.0 {
            return Interval { lo: -PI.next_up(), hi: PI.next_up() };
        }
        // A box without the origin and the cut: the angles of its corners are the extremes.
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
        Interval { lo: found.lo.max(bound.lo), hi: found.hi.min(bound.hi) }.ordered(bound)
    }
    #[inline(always)]
    fn unit(self, length: Interval) -> Interval {
        let margin = 1.0 + 4.0 * f64::EPSILON;
        // 0 / 0 is NaN.
        let unknown = self.is_whole() | (length.lo <= 0.0) & (length.hi >= 0.0) | (length.hi == f64::INFINITY);
        self.div(length).meet(-margin, margin).unless(unknown, Interval::WHOLE)
    }
    #[inline(always)]
    fn mix(self, b: Interval, t: Interval) -> Interval {
        // Linear in each: the extremes are at corners.
        let [(a, c), (d, e)] = [t.lo, t.hi].map(|t| self.corners(b, |x, y| x * (1.0 - t) + y * t));
        let largest = |x: Interval| greater(x.hi, -x.lo);
        let size = (largest(self) + largest(b)) * (1.0 + largest(t));
        let margin = 4.0 * f64::EPSILON * size + f64::MIN_POSITIVE;
        // Of NaN and of infinite ends nothing is known.
        let known = (margin < f64::INFINITY) & !(a + d).is_nan();
        let found = Interval { lo: lesser(a, d) - margin, hi: greater(c, e) + margin };
        Interval::WHOLE.unless(known, found)
    }
    #[inline(always)]
    fn less(self, b: Interval) -> Tri {
        Tri { may_hold: self.lo < b.hi, may_fail: self.hi >= b.lo }
    }
    #[inline(always)]
    fn less_equal(self, b: Interval) -> Tri {
        // The whole line may be NaN, which is not less even than infinity.
        Tri { may_hold: self.lo <= b.hi, may_fail: self.hi > b.lo || self.is_whole() || b.is_whole() }
    }
    #[inline(always)]
    fn equal(self, b: Interval) -> Tri {
        let same = self.lo == self.hi && self == b;
        Tri { may_hold: self.lo <= b.hi && b.lo <= self.hi, may_fail: !same }
    }
    fn is_nan(self) -> Tri {
        Tri { may_hold: self.is_whole(), may_fail: true }
    }
    fn is_infinite(self) -> Tri {
        Tri { may_hold: self.lo.is_infinite() || self.hi.is_infinite(), may_fail: true }
    }
    #[inline(always)]
    fn to_int(self, signed: bool) -> Range {
        // What may be NaN may be any integer: the ends of the whole line are those of all.
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
        if self.is_whole() || values.iter().any(|value| value.is_nan()) {
            return Interval::WHOLE;
        }
        let fold = |f: fn(f64, f64) -> f64, start| values.iter().copied().fold(start, f);
        Interval::rounded(fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY))
    }
    #[inline(never)]
    fn sample(image: &Image<'_>, at: [Interval; 3], level: Interval, wanted: [bool; 4]) -> [Interval; 4] {
        let endless = |at: &Interval| at.lo.is_infinite() || at.hi.is_infinite();
        let nowhere = |at: &Interval| at.is_whole() || image.wrap != Wrap::Clamp && endless(at);
        if image.noise.is_none() && at[..image.axes].iter().any(nowhere) {
            return [Interval::WHOLE; 4]; // there is no such texel: NaN; noise is held within its farthest cells
        }
        let levels = if level.is_whole() { [0.0, f64::INFINITY] } else { [level.lo, level.hi] };
        image.range_levels(at.map(|at| [at.lo, at.hi]), levels, wanted).map(|[lo, hi]| Interval { lo, hi })
    }
    fn fetch(image: &Image<'_>, at: [Range; 3]) -> [Interval; 4] {
        let sides = image.size.map(|side| side as usize);
        let of = [0, 1, 2].map(|axis| at[axis].index(sides[axis])).map(|(first, last)| [first, last]);
        image.texels(of).map(|[lo, hi]| Interval { lo, hi })
    }
}

impl Interval {
    /// `self`, or `otherwise` where rounding has turned it around.
    fn ordered(self, otherwise: Interval) -> Interval {
        if self.lo <= self.hi { self } else { otherwise }
    }
}
