//! f64, with exact integers and booleans: the reference for errors.

use crate::number::{Binary, Bool, Comparison, Domain, IntBinary, IntUnary, Integer, Number, Unary, packed};
use crate::texture::Image;

/// A boolean with all bits set or none, which vectorizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mask(u64);

/// Implements storage and the domain of single values.
macro_rules! single_value {
    ($value:ident, $any:expr) => {
        packed!($value as x: 1 $value { value: x } => value);

        impl Domain for $value {
            fn any() -> $value {
                $any
            }
            #[inline(always)]
            fn join(self, _: $value) -> $value {
                self
            }
            fn is_within(self, other: $value) -> bool {
                self == other
            }
        }
    };
}
single_value!(f64, f64::NAN);
single_value!(u32, 0);
single_value!(Mask, Mask(0));

impl Bool for Mask {
    #[inline(always)]
    fn new(value: bool) -> Mask {
        Mask(u64::from(value).wrapping_neg())
    }
    #[inline(always)]
    fn may_hold(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn may_fail(self) -> bool {
        self.0 == 0
    }
    #[inline(always)]
    fn and(self, b: Mask) -> Mask {
        Mask(self.0 & b.0)
    }
    #[inline(always)]
    fn or(self, b: Mask) -> Mask {
        Mask(self.0 | b.0)
    }
    #[inline(always)]
    fn not(self) -> Mask {
        Mask(!self.0)
    }
    #[inline(always)]
    fn equal(self, b: Mask) -> Mask {
        Mask(!(self.0 ^ b.0))
    }
}

impl Integer for u32 {
    type Bool = Mask;
    #[inline(always)]
    fn new(bits: u32, _: bool) -> u32 {
        bits
    }
    #[inline(always)]
    fn select(condition: Mask, a: u32, b: u32) -> u32 {
        let mask = condition.0 as u32;
        (a & mask) | (b & !mask)
    }
    #[inline(always)]
    fn binary(self, function: IntBinary, b: u32, signed: bool) -> u32 {
        let (s, t) = (self as i32, b as i32);
        match function {
            IntBinary::Add => self.wrapping_add(b),
            IntBinary::Sub => self.wrapping_sub(b),
            IntBinary::Mul => self.wrapping_mul(b),
            IntBinary::Div if signed => s.checked_div(t).unwrap_or(if t == 0 { 0 } else { s }) as u32,
            IntBinary::Div => self.checked_div(b).unwrap_or(0),
            IntBinary::Rem if signed => s.checked_rem(t).unwrap_or(0) as u32,
            IntBinary::Rem => self.checked_rem(b).unwrap_or(0),
            IntBinary::Min if signed => s.min(t) as u32,
            IntBinary::Min => self.min(b),
            IntBinary::Max if signed => s.max(t) as u32,
            IntBinary::Max => self.max(b),
            IntBinary::And => self & b,
            IntBinary::Or => self | b,
            IntBinary::Xor => self ^ b,
            IntBinary::ShiftLeft => self << (b & 31),
            IntBinary::ShiftRight if signed => (s >> (b & 31)) as u32,
            IntBinary::ShiftRight => self >> (b & 31),
        }
    }
    #[inline(always)]
    fn unary(self, function: IntUnary, signed: bool) -> u32 {
        let index = |zeros: u32, bit: u32| if zeros == 32 { u32::MAX } else { bit };
        match function {
            IntUnary::Negate => self.wrapping_neg(),
            IntUnary::Not => !self,
            IntUnary::Abs => (self as i32).unsigned_abs(),
            IntUnary::Sign => (self as i32).signum() as u32,
            IntUnary::CountBits => self.count_ones(),
            IntUnary::ReverseBits => self.reverse_bits(),
            IntUnary::LowestBit => index(self.trailing_zeros(), self.trailing_zeros()),
            IntUnary::HighestBit => {
                let a = if signed && (self as i32) < 0 { !self } else { self };
                index(a.leading_zeros(), 31u32.wrapping_sub(a.leading_zeros()))
            }
        }
    }
    #[inline(always)]
    fn bitcast(self, _: bool) -> u32 {
        self
    }
    #[inline(always)]
    fn less(self, b: u32, signed: bool) -> Mask {
        Mask::new(if signed { (self as i32) < b as i32 } else { self < b })
    }
    #[inline(always)]
    fn equal(self, b: u32) -> Mask {
        Mask::new(self == b)
    }
    #[inline(always)]
    fn index(self, count: usize) -> (usize, usize) {
        let at = (self as i32).clamp(0, count as i32 - 1) as usize;
        (at, at)
    }
}

/// 2^52: every f64 of this absolute value or more is an integer.
const INTEGERS: f64 = 4_503_599_627_370_496.0;

/// `floor` in arithmetic that vectorizes on any processor.
#[inline(always)]
fn floor(x: f64) -> f64 {
    const SHIFT: f64 = 1.5 * INTEGERS;
    let near = (x + SHIFT) - SHIFT;
    let low = near - f64::from(u8::from(near > x));
    if x.abs() < INTEGERS / 2.0 { low } else { x }
}

impl Number for f64 {
    type Int = u32;
    type Bool = Mask;
    const DECIDED: bool = true;

    #[inline(always)]
    fn new(x: f64) -> f64 {
        x
    }
    fn as_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn select(condition: Mask, a: f64, b: f64) -> f64 {
        f64::from_bits((a.to_bits() & condition.0) | (b.to_bits() & !condition.0))
    }
    #[inline(always)]
    fn select_decided(condition: Mask, a: f64, b: f64) -> f64 {
        Number::select(condition, a, b)
    }
    #[inline(always)]
    fn unary(self, function: Unary) -> f64 {
        match function {
            Unary::Negate => -self,
            Unary::Abs => self.abs(),
            Unary::Sign => f64::from(u8::from(self > 0.0)) - f64::from(u8::from(self < 0.0)),
            Unary::Floor => floor(self),
            Unary::Ceil => -floor(-self),
            Unary::Trunc => {
                let low = floor(self.abs());
                if self < 0.0 { -low } else { low }
            }
            Unary::Round => self.round_ties_even(),
            Unary::Fract => self - floor(self),
            #[expect(clippy::manual_clamp, reason = "NaN gives 0")]
            Unary::Saturate => self.max(0.0).min(1.0),
            Unary::Square => self * self,
            Unary::Sqrt => self.sqrt(),
            Unary::InverseSqrt => 1.0 / self.sqrt().abs(), // infinity for -0, too
            Unary::Hermite => self * self * (3.0 - 2.0 * self),
            Unary::Exp => self.exp(),
            Unary::Exp2 => self.exp2(),
            Unary::Log => self.ln(),
            Unary::Log2 => self.log2(),
            Unary::Sin => self.sin(),
            Unary::Cos => self.cos(),
            Unary::Tan => self.tan(),
            Unary::Asin => self.asin(),
            Unary::Acos => self.acos(),
            Unary::Atan => self.atan(),
            Unary::Sinh => self.sinh(),
            Unary::Cosh => self.cosh(),
            Unary::Tanh => self.tanh(),
            Unary::Asinh => self.asinh(),
            Unary::Acosh => self.acosh(),
            Unary::Atanh => self.atanh(),
        }
    }
    #[inline(always)]
    fn binary(self, function: Binary, b: f64) -> f64 {
        match function {
            Binary::Add => self + b,
            Binary::Sub => self - b,
            Binary::Mul => self * b,
            Binary::Div | Binary::Unit => self / b,
            Binary::Min => self.min(b),
            Binary::Max => self.max(b),
            // GLSL leaves a negative base undefined; drivers take a logarithm.
            Binary::Pow if self < 0.0 => f64::NAN,
            Binary::Pow => self.powf(b),
            Binary::Atan2 => self.atan2(b),
            Binary::Rem => self % b,
        }
    }
    #[inline(always)]
    fn mix(self, b: f64, t: f64) -> f64 {
        self * (1.0 - t) + b * t
    }
    #[inline(always)]
    fn compare(self, comparison: Comparison, b: f64) -> Mask {
        Mask::new(match comparison {
            Comparison::Less => self < b,
            Comparison::LessEqual => self <= b,
            Comparison::Equal => self == b,
        })
    }
    #[inline(always)]
    fn is_nan(self) -> Mask {
        Mask::new(f64::is_nan(self))
    }
    #[inline(always)]
    fn is_infinite(self) -> Mask {
        Mask::new(f64::is_infinite(self))
    }
    #[inline(always)]
    fn to_int(self, signed: bool) -> u32 {
        if signed { self as i32 as u32 } else { self as u32 }
    }
    #[inline(always)]
    fn from_int(int: u32, signed: bool) -> f64 {
        if signed { f64::from(int as i32) } else { f64::from(int) }
    }
    fn to_bits(self, _: bool) -> u32 {
        (self as f32).to_bits()
    }
    fn from_bits(int: u32) -> f64 {
        f64::from(f32::from_bits(int))
    }
    fn ldexp(self, exponent: u32) -> f64 {
        // Two steps, because 2^exponent alone may overflow.
        let exponent = (exponent as i32).clamp(-2200, 2200);
        let half = exponent / 2;
        self * 2f64.powi(half) * 2f64.powi(exponent - half)
    }
    fn sample(image: &Image<'_>, at: [f64; 3], level: f64, _: [bool; 4]) -> [f64; 4] {
        image.sample_level(at, level)
    }
    fn fetch(image: &Image<'_>, at: [u32; 3]) -> [f64; 4] {
        let sides = image.size.map(|side| side as usize);
        let at = [0, 1, 2].map(|axis| at[axis].index(sides[axis]).0);
        image.texel(at).map(f64::from)
    }
}
