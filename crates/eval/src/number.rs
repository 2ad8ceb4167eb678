//! The number types that programs run in: what a float, an integer and a truth value have to offer.
//!
//! Invariant: every function here is total. Integers have 32 bits and wrap, as on the GPU.

use super::case::Case;
use super::{BoundProgram, ExactError, Lanes, Measured};
use std::fmt::Debug;

/// Values that lie together in memory, part by part: so many make the vectors of a processor.
pub const GROUP: usize = 8;

/// A value of which each lane has one.
pub trait Packed: Copy {
    /// [`GROUP`] of them.
    type Group: Copy;

    /// The same in every place.
    fn splat(self) -> Self::Group;
    /// The one in a place.
    fn get(group: &Self::Group, place: usize) -> Self;
    /// Puts it in its place.
    fn put(self, group: &mut Self::Group, place: usize);
}

/// Values of one part.
macro_rules! packed_as_they_are {
    ($($value:ty)*) => {$(
        impl $crate::number::Packed for $value {
            type Group = [$value; $crate::number::GROUP];

            #[inline(always)]
            fn splat(self) -> Self::Group {
                [self; $crate::number::GROUP]
            }
            #[inline(always)]
            fn get(group: &Self::Group, place: usize) -> Self {
                group[place]
            }
            #[inline(always)]
            fn put(self, group: &mut Self::Group, place: usize) {
                group[place] = self;
            }
        }
    )*};
}
pub(super) use packed_as_they_are;

/// A type that stands for the floats of a program.
pub trait Number: Packed + Debug + Send + Sync + 'static {
    /// What stands for its integers.
    type Int: Integer<Truth = Self::Truth>;
    /// What stands for its truth values.
    type Truth: Truth;
    /// Whether every comparison has one answer: then a lane takes one way through the program.
    const DECIDED: bool;

    /// Evaluates a program: [`BoundProgram::measure`].
    ///
    /// # Errors
    /// As there.
    fn measure(program: &BoundProgram<'_>, lanes: &Lanes<Self>) -> Result<Measured<Self>, ExactError>;
    /// The number that is `x`.
    fn new(x: f64) -> Self;
    /// It as f64; NaN of what is more than one number.
    fn as_f64(self) -> f64 {
        f64::NAN
    }
    /// Any number at all, NaN included.
    fn whole() -> Self;
    /// What is one or the other.
    fn join(self, other: Self) -> Self;
    /// Whether every value of `self` is one of `other`.
    fn within(self, other: Self) -> bool;
    /// `a` where the truth holds, else `b`.
    fn select(truth: Self::Truth, a: Self, b: Self) -> Self;
    /// The same, of a truth that is known.
    fn one_of(truth: Self::Truth, a: Self, b: Self) -> Self;
    /// What is left of it where it is at most another.
    fn at_most(self, _: Self) -> Self {
        self
    }
    /// What is left of it where it is at least another.
    fn at_least(self, _: Self) -> Self {
        self
    }
    /// A function of one number.
    fn unary(self, function: Unary) -> Self;
    /// The same in a case of which it is known on which side of an integer a number lies.
    fn in_case(self, function: Unary, _: &mut Case) -> Self {
        self.unary(function)
    }
    /// `self + b`.
    fn add(self, b: Self) -> Self;
    /// `self - b`.
    fn sub(self, b: Self) -> Self;
    /// `self * b`.
    fn mul(self, b: Self) -> Self;
    /// `self / b`.
    fn div(self, b: Self) -> Self;
    /// The lesser; the other one, if one is NaN.
    fn min(self, b: Self) -> Self;
    /// The greater; the other one, if one is NaN.
    fn max(self, b: Self) -> Self;
    /// `self` to the power of `b`; NaN of a negative number.
    fn pow(self, b: Self) -> Self;
    /// The angle of the point (`b`, `self`).
    fn atan2(self, b: Self) -> Self;
    /// `self - b * trunc(self / b)`.
    fn rem(self, b: Self) -> Self;
    /// `self / length` of a component and the length of its vector.
    fn unit(self, length: Self) -> Self;
    /// GLSL's `mix`: `self * (1 - t) + b * t`.
    fn mix(self, b: Self, t: Self) -> Self;
    /// `self < b`.
    fn less(self, b: Self) -> Self::Truth;
    /// `self <= b`.
    fn less_equal(self, b: Self) -> Self::Truth;
    /// `self == b`.
    fn equal(self, b: Self) -> Self::Truth;
    /// Whether it is NaN.
    fn is_nan(self) -> Self::Truth;
    /// Whether it is infinite.
    fn is_infinite(self) -> Self::Truth;
    /// Towards zero, held in the range of the integers.
    fn to_int(self, signed: bool) -> Self::Int;
    /// The number that an integer is.
    fn from_int(int: Self::Int, signed: bool) -> Self;
    /// The bits of the f32 next to it.
    fn to_bits(self, signed: bool) -> Self::Int;
    /// The f32 of these bits.
    fn from_bits(int: Self::Int) -> Self;
    /// `self * 2^exponent`.
    fn ldexp(self, exponent: Self::Int) -> Self;
    /// A texture's channels (as far as `wanted` says) at texture coordinates of a level.
    fn sample(image: &super::texture::Image<'_>, at: [Self; 3], level: Self, wanted: [bool; 4]) -> [Self; 4];
    /// A texel; outside of the image the nearest.
    fn fetch(image: &super::texture::Image<'_>, at: [Self::Int; 3]) -> [Self; 4];
}

/// Functions of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "named as in GLSL")]
pub enum Unary {
    Negate,
    Abs,
    Sign,
    Floor,
    Ceil,
    Trunc,
    /// Halves go to the even neighbor.
    Round,
    Fract,
    /// Held in [0, 1].
    Saturate,
    Square,
    Sqrt,
    InverseSqrt,
    /// `t * t * (3 - 2 t)` of t in [0, 1]: what `smoothstep` ends with.
    Hermite,
    Exp,
    Exp2,
    Log,
    Log2,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
}

/// A type that stands for the 32-bit integers of a program; operations that differ say whether they are `signed`.
pub trait Integer: Packed + Debug + Send + Sync + 'static {
    /// What stands for truth values.
    type Truth: Truth;

    /// The integer of these bits.
    fn new(bits: u32, signed: bool) -> Self;
    /// Any integer.
    fn whole() -> Self;
    /// What is one or the other.
    fn join(self, other: Self) -> Self;
    /// Whether every value of `self` is one of `other`.
    fn within(self, other: Self) -> bool;
    /// `a` where the truth holds, else `b`.
    fn select(truth: Self::Truth, a: Self, b: Self) -> Self;
    /// An operation on two integers.
    fn binary(self, function: IntBinary, b: Self, signed: bool) -> Self;
    /// An operation on one integer.
    fn unary(self, function: IntUnary, signed: bool) -> Self;
    /// The same bits, read as signed or unsigned.
    fn reread(self, signed: bool) -> Self;
    /// `self < b`.
    fn less(self, b: Self, signed: bool) -> Self::Truth;
    /// `self == b`.
    fn equal(self, b: Self) -> Self::Truth;
    /// The first and the last of `0..count` that a signed index may mean, held in that range.
    fn index(self, count: usize) -> (usize, usize);
}

/// Operations on two integers; division by 0 gives 0, shifts go by the low five bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "named as in GLSL")]
pub enum IntBinary {
    Add,
    Sub,
    Mul,
    Div,
    Rem,
    Min,
    Max,
    And,
    Or,
    Xor,
    ShiftLeft,
    ShiftRight,
}

/// Operations on one integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "named as in GLSL")]
pub enum IntUnary {
    Negate,
    Not,
    Abs,
    Sign,
    CountBits,
    ReverseBits,
    LowestBit,
    HighestBit,
}

impl IntUnary {
    /// On bits.
    pub(super) fn of(self, a: u32, signed: bool) -> u32 {
        let index = |zeros: u32, bit: u32| if zeros == 32 { u32::MAX } else { bit };
        match self {
            IntUnary::Negate => a.wrapping_neg(),
            IntUnary::Not => !a,
            IntUnary::Abs => (a as i32).unsigned_abs(),
            IntUnary::Sign => (a as i32).signum() as u32,
            IntUnary::CountBits => a.count_ones(),
            IntUnary::ReverseBits => a.reverse_bits(),
            IntUnary::LowestBit => index(a.trailing_zeros(), a.trailing_zeros()),
            IntUnary::HighestBit => {
                let a = if signed && (a as i32) < 0 { !a } else { a };
                index(a.leading_zeros(), 31u32.wrapping_sub(a.leading_zeros()))
            }
        }
    }
}

/// A type that stands for truth values.
pub trait Truth: Packed + Debug + Send + Sync + 'static {
    /// The truth value that is `truth`.
    fn new(truth: bool) -> Self;
    /// True or false.
    fn whole() -> Self;
    /// What is one or the other.
    fn join(self, other: Self) -> Self;
    /// Whether every value of `self` is one of `other`.
    fn within(self, other: Self) -> bool;
    /// Whether it may be true.
    fn may_hold(self) -> bool;
    /// Whether it may be false.
    fn may_fail(self) -> bool;
    /// Both.
    fn and(self, b: Self) -> Self;
    /// One or both.
    fn or(self, b: Self) -> Self;
    /// The contrary.
    fn not(self) -> Self;
    /// Whether both are the same.
    fn equal(self, b: Self) -> Self;
    /// `a` where it holds, else `b`.
    fn select(self, a: Self, b: Self) -> Self {
        self.and(a).or(self.not().and(b))
    }
}
