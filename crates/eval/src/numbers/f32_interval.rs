//! Intervals that also hold the rounding of devices: of operations in f32 and of texture filters.
//!
//! Invariant: as for [`Interval`]; in addition, the interval holds every result within Vulkan's precision requirements,
//! however a compiler associates sums and products.
//! Source: Vulkan 1.3, Precision of Individual Operations; the margin for compilers is ours.

use super::integer_range::{Range, Tri};
use super::interval::{Interval, max_of, min_of};
use crate::number::{Binary, Comparison, Domain, Number, Unary, packed};
use crate::texture::Image;

/// Bounds of a number as a device computes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct F32Interval(pub Interval);

/// Relative error of a sum, product or quotient. Vulkan allows half an ulp and 2.5 ulp; reassociation adds to that.
const RELATIVE_ERROR: f64 = 16.0 * f32::EPSILON as f64;
/// Error of sine, cosine and the functions that Vulkan derives from them.
const ANGLE: f64 = 1.0 / 2048.0;
/// Relative error of exponentials and powers: 3 + 2 |x| ulp for exponents up to 128.
const POWER: f64 = 512.0 * f32::EPSILON as f64;
/// Absolute error of logarithms near 1.
const LOGARITHM: f64 = 1.0 / 1_048_576.0;
/// Resolution of filter weights, in texels. Vulkan requires 4 bits; devices have 8.
const WEIGHT: f64 = 1.0 / 256.0;
/// Error of a filtered value, relative to the largest value of the format.
const FILTERED: f64 = 1.0 / 32768.0;
/// Smallest normal number, for results that underflow.
const TINY: f64 = f32::MIN_POSITIVE as f64;

/// 2^24: f32 represents every integer up to this size.
const EXACT: i64 = 1 << 24;

/// The largest absolute value.
#[inline(always)]
fn largest(x: Interval) -> f64 {
    max_of(x.hi, -x.lo)
}

impl F32Interval {
    /// Widens by a part of the largest absolute value and by an amount; an end of 0 by the amount alone.
    #[inline(always)]
    fn widened(all: Interval, relative: f64, absolute: f64) -> F32Interval {
        let off = largest(all) * relative + absolute;
        let [down, up] = [all.lo, all.hi].map(|end| if end == 0.0 { absolute } else { off });
        F32Interval(Interval::known(all.lo - down, all.hi + up))
    }

    /// Widens a result by a few roundings.
    #[inline(always)]
    fn rounded(all: Interval) -> F32Interval {
        let off = |x: f64| if x == 0.0 { 0.0 } else { x.abs() * RELATIVE_ERROR + TINY };
        F32Interval(Interval::known(all.lo - off(all.lo), all.hi + off(all.hi)))
    }

    /// Replaces the bounds of a sum or product by its exact value, if the operands are single numbers and f32 holds it.
    #[inline(always)]
    fn or_exact(self, a: F32Interval, b: F32Interval, exact: f64) -> F32Interval {
        let holds = f64::from(exact as f32) == exact;
        let known = (a.0.lo == a.0.hi) & (b.0.lo == b.0.hi) & holds;
        F32Interval(self.0.unless(known, Interval { lo: exact, hi: exact }))
    }

    #[inline(always)]
    fn add(self, b: F32Interval) -> F32Interval {
        // Reassociated sums round their terms, which may be larger than the sum.
        let size = largest(self.0) + largest(b.0);
        let (sum, off) = (self.0.add(b.0), size * RELATIVE_ERROR);
        F32Interval(Interval::known(sum.lo - off, sum.hi + off)).or_exact(self, b, self.0.lo + b.0.lo)
    }

    fn rem(self, b: F32Interval) -> F32Interval {
        // A quotient rounded to the next integer changes the remainder by the whole divisor.
        let off = largest(b.0);
        let quotient = self.0.div(b.0);
        let near = quotient.unary(Unary::Fract);
        let safe = near.lo > 1e-4 && near.hi < 1.0 - 1e-4 && largest(quotient) < 256.0;
        let all = self.0.binary(Binary::Rem, b.0);
        F32Interval::widened(all, RELATIVE_ERROR, if safe { off * 256.0 * RELATIVE_ERROR } else { 2.0 * off })
    }
}

packed!(F32Interval as x: 2 f64 { lo: x.0.lo, hi: x.0.hi } => F32Interval(Interval { lo, hi }));

impl Domain for F32Interval {
    fn any() -> F32Interval {
        F32Interval(Interval::WHOLE)
    }
    #[inline(always)]
    fn join(self, other: F32Interval) -> F32Interval {
        F32Interval(self.0.join(other.0))
    }
    fn is_within(self, other: F32Interval) -> bool {
        self.0.is_within(other.0)
    }
}

impl Number for F32Interval {
    type Int = Range;
    type Bool = Tri;
    const DECIDED: bool = false;

    #[inline(always)]
    fn new(x: f64) -> F32Interval {
        F32Interval(Interval::new(x))
    }
    #[inline(always)]
    fn select(condition: Tri, a: F32Interval, b: F32Interval) -> F32Interval {
        F32Interval(Interval::select(condition, a.0, b.0))
    }
    #[inline(always)]
    fn select_decided(condition: Tri, a: F32Interval, b: F32Interval) -> F32Interval {
        F32Interval(Interval::select_decided(condition, a.0, b.0))
    }
    #[inline(always)]
    fn unary(self, function: Unary) -> F32Interval {
        let all = self.0.unary(function);
        // The whole line keeps NaN.
        let clamped = |wide: F32Interval, lo, hi| {
            let clamped = Interval { lo: max_of(wide.0.lo, lo), hi: min_of(wide.0.hi, hi) };
            F32Interval(clamped.unless(all == Interval::WHOLE, all))
        };
        match function {
            Unary::Negate
            | Unary::Abs
            | Unary::Sign
            | Unary::Floor
            | Unary::Ceil
            | Unary::Trunc
            | Unary::Round
            | Unary::Saturate => F32Interval(all),
            // Exact at 0 and 1: 0 * 0 * 3 and 1 * 1 * (3 - 2).
            Unary::Hermite => {
                let is_end = (self.0.lo == self.0.hi) & ((self.0.lo == 0.0) | (self.0.lo == 1.0));
                F32Interval(clamped(F32Interval::rounded(all), 0.0, 1.0).0.unless(is_end, self.0))
            }
            Unary::Fract => clamped(F32Interval::rounded(all), 0.0, 1.0),
            Unary::Square | Unary::Sqrt | Unary::InverseSqrt => F32Interval::rounded(all),
            Unary::Exp | Unary::Exp2 => F32Interval::widened(all, POWER, TINY),
            Unary::Log | Unary::Log2 => F32Interval::widened(all, RELATIVE_ERROR, LOGARITHM),
            Unary::Sin | Unary::Cos => clamped(F32Interval::widened(all, 0.0, ANGLE), -1.0, 1.0),
            _ => F32Interval::widened(all, ANGLE, ANGLE),
        }
    }
    #[inline(always)]
    fn binary(self, function: Binary, b: F32Interval) -> F32Interval {
        let all = || self.0.binary(function, b.0);
        match function {
            Binary::Add => self.add(b),
            Binary::Sub => self.add(F32Interval(b.0.negate())),
            Binary::Mul => F32Interval::rounded(all()).or_exact(self, b, self.0.lo * b.0.lo),
            Binary::Div | Binary::Unit => F32Interval::rounded(all()),
            Binary::Min | Binary::Max => F32Interval(all()),
            Binary::Pow => F32Interval::widened(all(), POWER, TINY),
            Binary::Atan2 => F32Interval::widened(all(), ANGLE, 0.0),
            Binary::Rem => self.rem(b),
        }
    }
    #[inline(always)]
    fn mix(self, b: F32Interval, t: F32Interval) -> F32Interval {
        let size = (largest(self.0) + largest(b.0)) * (1.0 + largest(t.0));
        F32Interval::widened(self.0.mix(b.0, t.0), 0.0, RELATIVE_ERROR * size)
    }
    #[inline(always)]
    fn compare(self, comparison: Comparison, b: F32Interval) -> Tri {
        self.0.compare(comparison, b.0)
    }
    fn is_nan(self) -> Tri {
        self.0.is_nan()
    }
    fn is_infinite(self) -> Tri {
        self.0.is_infinite()
    }
    #[inline(always)]
    fn to_int(self, signed: bool) -> Range {
        self.0.to_int(signed)
    }
    #[inline(always)]
    fn from_int(int: Range, signed: bool) -> F32Interval {
        let (all, holds) = (Interval::from_int(int, signed), (int.lo >= -EXACT) & (int.hi <= EXACT));
        F32Interval(F32Interval::rounded(all).0.unless(holds, all))
    }
    fn to_bits(self, signed: bool) -> Range {
        self.0.to_bits(signed)
    }
    fn from_bits(int: Range) -> F32Interval {
        F32Interval(Interval::from_bits(int))
    }
    fn ldexp(self, exponent: Range) -> F32Interval {
        F32Interval::rounded(self.0.ldexp(exponent))
    }
    fn sample(image: &Image<'_>, at: [F32Interval; 3], level: F32Interval, wanted: [bool; 4]) -> [F32Interval; 4] {
        let mut within = at.map(|at| at.0);
        for (axis, within) in within.iter_mut().enumerate().take(image.axes) {
            let weight = if image.noise.is_some() { 0.0 } else { WEIGHT / f64::from(image.size[axis]) };
            *within = F32Interval::widened(*within, RELATIVE_ERROR, weight).0;
        }
        let found = Interval::sample(image, within, level.0, wanted);
        // Filtering texels of 0 is exact.
        let zero = Interval { lo: 0.0, hi: 0.0 };
        found.map(|all| F32Interval::widened(all, FILTERED, if all == zero { 0.0 } else { FILTERED }))
    }
    fn fetch(image: &Image<'_>, at: [Range; 3]) -> [F32Interval; 4] {
        Interval::fetch(image, at).map(F32Interval::rounded)
    }
}
