//! The traits of the number types that programs run in: floats, integers and booleans.
//!
//! Invariant: every function here is total. Integers have 32 bits and wrap, as on the GPU.

use crate::integer_splits::IntegerSplits;
use crate::texture::Image;
use std::fmt::Debug;

/// Lanes whose values lie side by side in memory: enough for one vector of a processor.
pub(crate) const GROUP: usize = 8;

/// A value of one lane, stored in groups of lanes as one array for each of its parts.
pub trait Packed: Copy + Debug + Send + Sync + 'static {
    /// The values of [`GROUP`] lanes.
    type Group: Copy;

    /// A group with this value in every lane.
    fn splat(self) -> Self::Group;
    /// The value of a lane.
    fn get(group: &Self::Group, place: usize) -> Self;
    /// Sets the value of a lane.
    fn put(self, group: &mut Self::Group, place: usize);
}

/// Implements [`Packed`] for a value by its parts.
macro_rules! packed {
    ($value:ident as $this:ident: $count:literal $scalar:ty { $($part:ident: $of:expr),* } => $whole:expr) => {
        impl $crate::number::Packed for $value {
            type Group = [[$scalar; $crate::number::GROUP]; $count];

            #[inline(always)]
            fn splat(self) -> Self::Group {
                let $this = self;
                [$([$of; $crate::number::GROUP]),*]
            }
            #[inline(always)]
            fn get(group: &Self::Group, place: usize) -> $value {
                let [$($part),*] = group;
                $(let $part = $part[place];)*
                $whole
            }
            #[inline(always)]
            fn put(self, group: &mut Self::Group, place: usize) {
                let $this = self;
                let [$($part),*] = group;
                $($part[place] = $of;)*
            }
        }
    };
}
pub(crate) use packed;

/// A set of values in the sense of abstract interpretation; a type of single values is one of sets with one element.
pub trait Domain: Packed {
    /// The set of all values, NaN included.
    fn any() -> Self;
    /// The union of two sets, or a set that holds it.
    fn join(self, other: Self) -> Self;
    /// Whether every value of `self` is one of `other`.
    fn is_within(self, other: Self) -> bool;
}

/// A type for the floats of a program.
pub trait Number: Domain {
    /// The type for its integers.
    type Int: Integer<Bool = Self::Bool>;
    /// The type for its booleans.
    type Bool: Bool;
    /// Whether every comparison has one answer, so that each lane takes one path through the program.
    const DECIDED: bool;

    /// The number `x`.
    fn new(x: f64) -> Self;
    /// The number as f64; NaN for types of several numbers.
    fn as_f64(self) -> f64 {
        f64::NAN
    }
    /// `a` where the condition holds, else `b`.
    fn select(condition: Self::Bool, a: Self, b: Self) -> Self;
    /// [`Number::select`] for a condition that is decided.
    fn select_decided(condition: Self::Bool, a: Self, b: Self) -> Self;
    /// The part of `self` that is at most `b`, or more.
    fn at_most(self, _b: Self) -> Self {
        self
    }
    /// A function of one number.
    fn unary(self, function: Unary) -> Self;
    /// [`Number::unary`] on a part of a segment whose crossings of integers are known or noted.
    fn unary_split(self, function: Unary, _splits: &mut IntegerSplits) -> Self {
        self.unary(function)
    }
    /// A function of two numbers.
    fn binary(self, function: Binary, b: Self) -> Self;
    /// GLSL's `mix`: `self * (1 - t) + b * t`.
    fn mix(self, b: Self, t: Self) -> Self;
    /// A comparison of two numbers.
    fn compare(self, comparison: Comparison, b: Self) -> Self::Bool;
    /// Whether the number is NaN.
    fn is_nan(self) -> Self::Bool;
    /// Whether the number is infinite.
    fn is_infinite(self) -> Self::Bool;
    /// Rounds towards zero and clamps to the range of integers.
    fn to_int(self, signed: bool) -> Self::Int;
    /// The number of an integer.
    fn from_int(int: Self::Int, signed: bool) -> Self;
    /// The bits of the nearest f32.
    fn to_bits(self, signed: bool) -> Self::Int;
    /// The f32 of these bits.
    fn from_bits(int: Self::Int) -> Self;
    /// `self * 2^exponent`.
    fn ldexp(self, exponent: Self::Int) -> Self;
    /// The wanted channels of a texture at coordinates and a level; others may be 0.
    fn sample(image: &Image<'_>, at: [Self; 3], level: Self, wanted: [bool; 4]) -> [Self; 4];
    /// A texel; the nearest one for indices out of range.
    fn fetch(image: &Image<'_>, at: [Self::Int; 3]) -> [Self; 4];
}

/// Functions of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unary {
    Negate,
    Abs,
    Sign,
    Floor,
    Ceil,
    Trunc,
    /// Rounds halves to even.
    Round,
    Fract,
    /// Clamps to [0, 1].
    Saturate,
    Square,
    Sqrt,
    InverseSqrt,
    /// `t * t * (3 - 2 t)` for t in [0, 1], the last step of `smoothstep`.
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

/// Functions of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    /// The lesser; if one is NaN, the other one.
    Min,
    /// The greater; if one is NaN, the other one.
    Max,
    /// A component divided by the length of its vector.
    Unit,
    /// NaN for a negative base.
    Pow,
    /// The angle of the point (`b`, `a`).
    Atan2,
    /// `a - b * trunc(a / b)`.
    Rem,
}

/// Comparisons of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Comparison {
    Less,
    LessEqual,
    Equal,
}

/// A type for the 32-bit integers of a program; operations that differ by signedness take `signed`.
pub trait Integer: Domain {
    /// The type for booleans.
    type Bool: Bool;

    /// The integer of these bits.
    fn new(bits: u32, signed: bool) -> Self;
    /// `a` where the condition holds, else `b`.
    fn select(condition: Self::Bool, a: Self, b: Self) -> Self;
    /// An operation on two integers.
    fn binary(self, function: IntBinary, b: Self, signed: bool) -> Self;
    /// An operation on one integer.
    fn unary(self, function: IntUnary, signed: bool) -> Self;
    /// Reinterprets the bits as signed or unsigned.
    fn bitcast(self, signed: bool) -> Self;
    /// `self < b`.
    fn less(self, b: Self, signed: bool) -> Self::Bool;
    /// `self == b`.
    fn equal(self, b: Self) -> Self::Bool;
    /// The first and last element of `0..count` that a signed index selects, clamped to that range.
    fn index(self, count: usize) -> (usize, usize);
}

/// Operations on two integers; division by 0 gives 0, shifts use the low five bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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

/// A type for booleans.
pub trait Bool: Domain {
    /// The boolean `value`.
    fn new(value: bool) -> Self;
    /// Whether it may be true.
    fn may_hold(self) -> bool;
    /// Whether it may be false.
    fn may_fail(self) -> bool;
    /// Conjunction.
    fn and(self, b: Self) -> Self;
    /// Disjunction.
    fn or(self, b: Self) -> Self;
    /// Negation.
    fn not(self) -> Self;
    /// Equivalence.
    fn equal(self, b: Self) -> Self;
    /// `a` where `self` holds, else `b`.
    fn select(self, a: Self, b: Self) -> Self {
        self.and(a).or(self.not().and(b))
    }
}
