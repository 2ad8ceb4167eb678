//! Programs in f64: the truth that errors are measured against. Integers are exact.

use super::number::{IntBinary, IntUnary, Integer, Number, Truth, Unary};
use super::texture::Image;
use super::{BoundProgram, ExactError, Lanes, Measured};

/// A truth value as a mask of bits, so that many are handled at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mask(u64);

super::number::packed_as_they_are!(f64 u32 Mask);

impl Truth for Mask {
    #[inline(always)]
    fn new(truth: bool) -> Mask {
        Mask(u64::from(truth).wrapping_neg())
    }
    fn whole() -> Mask {
        Mask(0)
    }
    #[inline(always)]
    fn join(self, _: Mask) -> Mask {
        self
    }
    fn within(self, other: Mask) -> bool {
        self == other
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
    type Truth = Mask;
    #[inline(always)]
    fn new(bits: u32, _: bool) -> u32 {
        bits
    }
    fn whole() -> u32 {
        0
    }
    #[inline(always)]
    fn join(self, _: u32) -> u32 {
        self
    }
    fn within(self, other: u32) -> bool {
        self == other
    }
    #[inline(always)]
    fn select(truth: Mask, a: u32, b: u32) -> u32 {
        let mask = truth.0 as u32;
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
        function.of(self, signed)
    }
    #[inline(always)]
    fn reread(self, _: bool) -> u32 {
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

/// Where all f64 of greater absolute value are integers.
const INTEGERS: f64 = 4_503_599_627_370_496.0;

/// `floor` that compilers turn into vector code on any processor.
#[inline(always)]
fn floor(x: f64) -> f64 {
    const SHIFT: f64 = 1.5 * INTEGERS;
    let near = (x + SHIFT) - SHIFT;
    let low = near - f64::from(u8::from(near > x));
    if x.abs() < INTEGERS / 2.0 { low } else { x }
}

impl Number for f64 {
    type Int = u32;
    type Truth = Mask;
    const DECIDED: bool = true;

    fn measure(program: &BoundProgram<'_>, lanes: &Lanes<Self>) -> Result<Measured<Self>, ExactError> {
        program.evaluate(lanes, &mut [], None)
    }

    #[inline(always)]
    fn new(x: f64) -> f64 {
        x
    }
    fn as_f64(self) -> f64 {
        self
    }
    fn whole() -> f64 {
        f64::NAN
    }
    #[inline(always)]
    fn join(self, _: f64) -> f64 {
        self
    }
    fn within(self, other: f64) -> bool {
        self == other
    }
    #[inline(always)]
    fn select(truth: Mask, a: f64, b: f64) -> f64 {
        f64::from_bits((a.to_bits() & truth.0) | (b.to_bits() & !truth.0))
    }
    #[inline(always)]
    fn one_of(truth: Mask, a: f64, b: f64) -> f64 {
        Number::select(truth, a, b)
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
            Unary::Saturate => Number::min(Number::max(self, 0.0), 1.0), // 0 of NaN
            Unary::Square => self * self,
            Unary::Sqrt => self.sqrt(),
            Unary::InverseSqrt => 1.0 / self.sqrt().abs(), // also of -0
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
    fn add(self, b: f64) -> f64 {
        self + b
    }
    #[inline(always)]
    fn sub(self, b: f64) -> f64 {
        self - b
    }
    #[inline(always)]
    fn mul(self, b: f64) -> f64 {
        self * b
    }
    #[inline(always)]
    fn div(self, b: f64) -> f64 {
        self / b
    }
    #[inline(always)]
    fn min(self, b: f64) -> f64 {
        f64::min(self, b)
    }
    #[inline(always)]
    fn max(self, b: f64) -> f64 {
        f64::max(self, b)
    }
    fn pow(self, b: f64) -> f64 {
        // GLSL leaves it open, and drivers take a logarithm.
        if self < 0.0 { f64::NAN } else { self.powf(b) }
    }
    fn atan2(self, b: f64) -> f64 {
        f64::atan2(self, b)
    }
    fn rem(self, b: f64) -> f64 {
        self % b
    }
    #[inline(always)]
    fn unit(self, length: f64) -> f64 {
        self / length
    }
    #[inline(always)]
    fn mix(self, b: f64, t: f64) -> f64 {
        self * (1.0 - t) + b * t
    }
    #[inline(always)]
    fn less(self, b: f64) -> Mask {
        Mask::new(self < b)
    }
    #[inline(always)]
    fn less_equal(self, b: f64) -> Mask {
        Mask::new(self <= b)
    }
    #[inline(always)]
    fn equal(self, b: f64) -> Mask {
        Mask::new(self == b)
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
        // In two steps: 2^exponent alone may be out of range.
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
