//! Types of the values that files hold.
//!
//! Role: names, sizes, and bytes or words into f32. Invariant: a value is rounded once, to the nearest f32.

use std::fmt;
use std::str::FromStr;

/// Type of a value in a file; its name is that of NumPy: `uint16`, `float32`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// Unsigned 8 bits.
    U8,
    /// Signed 8 bits.
    I8,
    /// Unsigned 16 bits.
    U16,
    /// Signed 16 bits.
    I16,
    /// Unsigned 32 bits.
    U32,
    /// Signed 32 bits.
    I32,
    /// Unsigned 64 bits.
    U64,
    /// Signed 64 bits.
    I64,
    /// IEEE single.
    F32,
    /// IEEE double.
    F64,
}

/// A name that is none of a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no type is called `{0}`; choose one of uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64"
)]
pub struct UnknownSampleType(pub String);

impl SampleType {
    /// All of them, with their names.
    const NAMES: [(SampleType, &'static str); 10] = [
        (SampleType::U8, "uint8"),
        (SampleType::I8, "int8"),
        (SampleType::U16, "uint16"),
        (SampleType::I16, "int16"),
        (SampleType::U32, "uint32"),
        (SampleType::I32, "int32"),
        (SampleType::U64, "uint64"),
        (SampleType::I64, "int64"),
        (SampleType::F32, "float32"),
        (SampleType::F64, "float64"),
    ];

    /// Bytes of a value.
    pub fn bytes(self) -> u64 {
        match self {
            SampleType::U8 | SampleType::I8 => 1,
            SampleType::U16 | SampleType::I16 => 2,
            SampleType::U32 | SampleType::I32 | SampleType::F32 => 4,
            SampleType::U64 | SampleType::I64 | SampleType::F64 => 8,
        }
    }

    /// Appends the whole values of `bytes`, each times the first of `scale` plus the second.
    pub(super) fn append(self, bytes: &[u8], big_endian: bool, scale: Option<[f64; 2]>, values: &mut Vec<f32>) {
        macro_rules! append {
            ($number:ty) => {{
                let number =
                    |&chunk| if big_endian { <$number>::from_be_bytes(chunk) } else { <$number>::from_le_bytes(chunk) };
                let numbers = bytes.as_chunks().0.iter().map(number);
                match scale {
                    None => values.extend(numbers.map(|number| number as f32)),
                    Some([slope, rest]) => {
                        values.extend(numbers.map(|number| (slope * number as f64 + rest) as f32));
                    }
                }
            }};
        }
        match self {
            SampleType::U8 => append!(u8),
            SampleType::I8 => append!(i8),
            SampleType::U16 => append!(u16),
            SampleType::I16 => append!(i16),
            SampleType::U32 => append!(u32),
            SampleType::I32 => append!(i32),
            SampleType::U64 => append!(u64),
            SampleType::I64 => append!(i64),
            SampleType::F32 => append!(f32),
            SampleType::F64 => append!(f64),
        }
    }

    /// A value that is written as text, if it is one of this type.
    pub(super) fn parse(self, word: &str) -> Option<f32> {
        macro_rules! number {
            ($number:ty) => {
                word.parse::<$number>().ok().map(|number| number as f32)
            };
        }
        match self {
            SampleType::U8 => number!(u8),
            SampleType::I8 => number!(i8),
            SampleType::U16 => number!(u16),
            SampleType::I16 => number!(i16),
            SampleType::U32 => number!(u32),
            SampleType::I32 => number!(i32),
            SampleType::U64 => number!(u64),
            SampleType::I64 => number!(i64),
            SampleType::F32 => number!(f32),
            SampleType::F64 => number!(f64),
        }
    }
}

impl fmt::Display for SampleType {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let known = SampleType::NAMES.iter().find(|(kind, _)| kind == self);
        f.pad(known.map_or("", |(_, name)| name))
    }
}

impl FromStr for SampleType {
    type Err = UnknownSampleType;

    fn from_str(name: &str) -> Result<SampleType, UnknownSampleType> {
        let known = SampleType::NAMES.iter().find(|(_, known)| *known == name);
        known.map(|(kind, _)| *kind).ok_or_else(|| UnknownSampleType(name.chars().take(40).collect()))
    }
}
