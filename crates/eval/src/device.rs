//! Intervals of what a device may compute: bounds with the roundings of f32 and of filters in hardware.
//!
//! Invariant: as for [`Interval`], and whatever a device gives that keeps Vulkan's precision of operations lies in it as
//! well, whichever way its compiler puts products and sums together.
//! Source: Vulkan 1.3, Precision of Individual Operations; the factor for what compilers do is ours.

use super::interval::{Interval, greater, lesser};
use super::number::{Number, Packed, Unary};
use super::range::{Range, Tri};
use super::texture::Image;
use super::{BoundProgram, ExactError, Lanes, Measured};

/// What a device may make of a box of inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Device(pub Interval);

/// Half an ulp is what Vulkan allows a sum or a product, 2.5 a quotient; a chain of them may be put together otherwise.
const RELATIVE: f64 = 16.0 * f32::EPSILON as f64;
/// Sine and cosine, and what Vulkan builds on them.
const ANGLE: f64 = 1.0 / 2048.0;
/// Exponentials and powers: 3 + 2 |x| ulp for exponents up to 128.
const POWER: f64 = 512.0 * f32::EPSILON as f64;
/// Logarithms near 1.
const LOGARITHM: f64 = 1.0 / 1_048_576.0;
/// Bits of the weights of a filter, in parts of a texel: Vulkan asks for 4, and devices have 8.
const WEIGHT: f64 = 1.0 / 256.0;
/// A filtered value, in parts of the largest that its format holds.
const FILTERED: f64 = 1.0 / 32768.0;

/// Up to here f32 holds every integer, and nothing rounds.
const WHOLE: i64 = 1 << 24;

/// The largest size of a number.
#[inline(always)]
fn largest(x: Interval) -> f64 {
    greater(x.hi, -x.lo)
}

impl Device {
    /// With a part of itself more, and an amount.
    #[inline(always)]
    fn of(all: Interval, relative: f64, absolute: f64) -> Device {
        let off = largest(all) * relative + absolute;
        // What is 0 exactly stays so.
        let [down, up] = [all.lo, all.hi].map(|end| if end == 0.0 { absolute } else { off });
        Device(Interval::known(all.lo - down, all.hi + up))
    }

    /// A result of few roundings.
    #[inline(always)]
    fn rounded(all: Interval) -> Device {
        let off = |x: f64| if x == 0.0 { 0.0 } else { x.abs() * RELATIVE + f64::from(f32::MIN_POSITIVE) };
        Device(Interval::known(all.lo - off(all.lo), all.hi + off(all.hi)))
    }

    /// The sum or product of two numbers that are known, in place of its bounds where f32 holds it: there nothing rounds.
    #[inline(always)]
    fn known(self, a: Device, b: Device, exact: f64) -> Device {
        let holds = f64::from(exact as f32) == exact;
        let known = (a.0.lo == a.0.hi) & (b.0.lo == b.0.hi) & holds;
        Device(self.0.unless(known, Interval { lo: exact, hi: exact }))
    }
}

impl Packed for Device {
    type Group = <Interval as Packed>::Group;

    #[inline(always)]
    fn splat(self) -> Self::Group {
        self.0.splat()
    }
    #[inline(always)]
    fn get(group: &Self::Group, place: usize) -> Device {
        Device(Interval::get(group, place))
    }
    #[inline(always)]
    fn put(self, group: &mut Self::Group, place: usize) {
        self.0.put(group, place);
    }
}

impl Number for Device {
    type Int = Range;
    type Truth = Tri;
    const DECIDED: bool = false;

    fn measure(program: &BoundProgram<'_>, lanes: &Lanes<Self>) -> Result<Measured<Self>, ExactError> {
        program.evaluate(lanes, &mut [], None)
    }

    #[inline(always)]
    fn new(x: f64) -> Device {
        Device(Interval::new(x))
    }
    fn whole() -> Device {
        Device(Interval::WHOLE)
    }
    #[inline(always)]
    fn join(self, other: Device) -> Device {
        Device(self.0.join(other.0))
    }
    fn within(self, other: Device) -> bool {
        self.0.within(other.0)
    }
    #[inline(always)]
    fn select(truth: Tri, a: Device, b: Device) -> Device {
        Device(Interval::select(truth, a.0, b.0))
    }
    #[inline(always)]
    fn one_of(truth: Tri, a: Device, b: Device) -> Device {
        Device(Interval::one_of(truth, a.0, b.0))
    }
    #[inline(always)]
    fn unary(self, function: Unary) -> Device {
        let all = self.0.unary(function);
        // What may be NaN stays so.
        let held = |wide: Device, lo, hi| {
            let held = Interval { lo: greater(wide.0.lo, lo), hi: lesser(wide.0.hi, hi) };
            Device(held.unless(all == Interval::WHOLE, all))
        };
        match function {
            Unary::Negate
            | Unary::Abs
            | Unary::Sign
            | Unary::Floor
            | Unary::Ceil
            | Unary::Trunc
            | Unary::Round
            | Unary::Saturate => Device(all),
            // 0 * 0 * 3 and 1 * 1 * (3 - 2): nothing rounds.
            Unary::Hermite => {
                let is_end = (self.0.lo == self.0.hi) & ((self.0.lo == 0.0) | (self.0.lo == 1.0));
                Device(held(Device::rounded(all), 0.0, 1.0).0.unless(is_end, self.0))
            }
            Unary::Fract => held(Device::rounded(all), 0.0, 1.0),
            Unary::Square | Unary::Sqrt | Unary::InverseSqrt => Device::rounded(all),
            Unary::Exp | Unary::Exp2 => Device::of(all, POWER, f64::from(f32::MIN_POSITIVE)),
            Unary::Log | Unary::Log2 => Device::of(all, RELATIVE, LOGARITHM),
            Unary::Sin | Unary::Cos => held(Device::of(all, 0.0, ANGLE), -1.0, 1.0),
            _ => Device::of(all, ANGLE, ANGLE),
        }
    }
    #[inline(always)]
    fn add(self, b: Device) -> Device {
        // A compiler may put the terms of a sum together otherwise: then their roundings count, not that of the sum.
        let size = largest(self.0) + largest(b.0);
        let (sum, off) = (self.0.add(b.0), size * RELATIVE);
        Device(Interval::known(sum.lo - off, sum.hi + off)).known(self, b, self.0.lo + b.0.lo)
    }
    #[inline(always)]
    fn sub(self, b: Device) -> Device {
        self.add(Device(b.0.negate()))
    }
    #[inline(always)]
    fn mul(self, b: Device) -> Device {
        Device::rounded(self.0.mul(b.0)).known(self, b, self.0.lo * b.0.lo)
    }
    #[inline(always)]
    fn div(self, b: Device) -> Device {
        Device::rounded(self.0.div(b.0))
    }
    #[inline(always)]
    fn min(self, b: Device) -> Device {
        Device(self.0.min(b.0))
    }
    #[inline(always)]
    fn max(self, b: Device) -> Device {
        Device(self.0.max(b.0))
    }
    fn pow(self, b: Device) -> Device {
        Device::of(self.0.pow(b.0), POWER, f64::from(f32::MIN_POSITIVE))
    }
    fn atan2(self, b: Device) -> Device {
        Device::of(self.0.atan2(b.0), ANGLE, 0.0)
    }
    fn rem(self, b: Device) -> Device {
        // A quotient that is rounded may be the next integer: then the remainder is off by all of the divisor.
        let off = largest(b.0);
        let whole = self.0.div(b.0);
        let near = whole.unary(Unary::Fract);
        let safe = near.lo > 1e-4 && near.hi < 1.0 - 1e-4 && largest(whole) < 256.0;
        Device::of(self.0.rem(b.0), RELATIVE, if safe { off * 256.0 * RELATIVE } else { 2.0 * off })
    }
    #[inline(always)]
    fn unit(self, length: Device) -> Device {
        Device::rounded(self.0.unit(length.0))
    }
    #[inline(always)]
    fn mix(self, b: Device, t: Device) -> Device {
        let size = (largest(self.0) + largest(b.0)) * (1.0 + largest(t.0));
        Device::of(self.0.mix(b.0, t.0), 0.0, RELATIVE * size)
    }
    #[inline(always)]
    fn less(self, b: Device) -> Tri {
        self.0.less(b.0)
    }
    #[inline(always)]
    fn less_equal(self, b: Device) -> Tri {
        self.0.less_equal(b.0)
    }
    #[inline(always)]
    fn equal(self, b: Device) -> Tri {
        self.0.equal(b.0)
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
    fn from_int(int: Range, signed: bool) -> Device {
        let (all, holds) = (Interval::from_int(int, signed), (int.lo >= -WHOLE) & (int.hi <= WHOLE));
        Device(Device::rounded(all).0.unless(holds, all))
    }
    fn to_bits(self, signed: bool) -> Range {
        self.0.to_bits(signed)
    }
    fn from_bits(int: Range) -> Device {
        Device(Interval::from_bits(int))
    }
    fn ldexp(self, exponent: Range) -> Device {
        Device::rounded(self.0.ldexp(exponent))
    }
    fn sample(image: &Image<'_>, at: [Device; 3], level: Device, wanted: [bool; 4]) -> [Device; 4] {
        let mut within = at.map(|at| at.0);
        for (axis, within) in within.iter_mut().enumerate().take(image.axes) {
            let weight = if image.noise.is_some() { 0.0 } else { WEIGHT / f64::from(image.size[axis]) };
            *within = Device::of(*within, RELATIVE, weight).0;
        }
        let found = Interval::sample(image, within, level.0, wanted);
        // Of texels that are 0 the filter makes nothing else.
        found.map(|all| Device::of(all, FILTERED, if all == (Interval { lo: 0.0, hi: 0.0 }) { 0.0 } else { FILTERED }))
    }
    fn fetch(image: &Image<'_>, at: [Range; 3]) -> [Device; 4] {
        Interval::fetch(image, at).map(Device::rounded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_that_f32_holds_stay_what_they_are() {
        for (lo, hi) in [(0, WHOLE), (-WHOLE, 7), (5, 5)] {
            let Device(all) = Device::from_int(Range { lo, hi }, true);
            assert_eq!((all.lo, all.hi), (lo as f64, hi as f64));
        }
        for int in [WHOLE + 1, -WHOLE - 1] {
            let Device(all) = Device::from_int(Range { lo: int, hi: int }, true);
            assert!(all.contains(f64::from(int as f32)) && all.lo < all.hi, "{int}: {all:?}");
        }
    }

    #[test]
    fn noise_at_a_place_that_is_not_known_is_noise_all_the_same() {
        // `clamp` of whatever it is leaves a place, as shaders have it.
        use crate::Affine;
        use noise::{Lattice, NOISE_BOUND};
        let image = Image::of_noise(Lattice::default());
        let known = Interval { lo: 0.5, hi: 0.5 };
        for unknown in [Interval::WHOLE, Interval { lo: 0.0, hi: f64::INFINITY }] {
            let (at, level, wanted) = ([unknown, known, known], Interval { lo: 256.0, hi: 256.0 }, [true; 4]);
            let bounds = [
                Interval::sample(&image, at, level, wanted)[3],
                Device::sample(&image, at.map(Device), Device(level), wanted)[3].0,
                Affine::sample(&image, at.map(Affine::bounded), Affine::bounded(level), wanted)[3].all,
            ];
            for bounds in bounds {
                assert!(
                    bounds.lo > -1.001 * NOISE_BOUND && bounds.hi < 1.001 * NOISE_BOUND,
                    "{bounds:?} at {unknown:?}"
                );
            }
        }
    }
}
