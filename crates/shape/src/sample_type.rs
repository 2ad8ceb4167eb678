//! Numeric types of values in files.
//!
//! Role: names, sizes, and conversion of bytes or text to floats. Invariant: a value is rounded once, to the nearest f32.
#![expect(clippy::unnecessary_cast, reason = "the macro has casts for every type")]

use std::fmt;
use std::str::FromStr;

/// Numeric type of a value in a file; displayed with NumPy's names, as `uint16` and `float32`.
#[allow(missing_docs)] // named like the types of Rust
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

/// Unknown name of a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no type is called `{0}`; choose one of uint8, int8, uint16, int16, uint32, int32, uint64, int64, float32, float64"
)]
pub struct UnknownSampleType(pub String);

/// Evaluates an expression with `$number` as the Rust type of a [`SampleType`].
macro_rules! with_type {
    ($kind:expr, $number:ident => $result:expr) => {
        with_type!(@ $kind, $number => $result, U8 u8, I8 i8, U16 u16, I16 i16, U32 u32, I32 i32, U64 u64, I64 i64,
            F32 f32, F64 f64)
    };
    (@ $kind:expr, $number:ident => $result:expr, $($variant:ident $type:ty),*) => {
        match $kind {
            $(SampleType::$variant => {
                type $number = $type;
                $result
            })*
        }
    };
}

/// One number from its bytes.
macro_rules! decode {
    ($number:ty, $bytes:expr, $big_endian:expr) => {
        if $big_endian { <$number>::from_be_bytes($bytes) } else { <$number>::from_le_bytes($bytes) }
    };
}

impl SampleType {
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

    /// Size of a value in bytes.
    pub fn bytes(self) -> u64 {
        with_type!(self, Number => size_of::<Number>() as u64)
    }

    /// Appends all whole values in `bytes`; `scale` is a slope and an intercept.
    pub(super) fn append(self, bytes: &[u8], big_endian: bool, scale: Option<[f64; 2]>, values: &mut Vec<f32>) {
        with_type!(self, Number => {
            let numbers = bytes.as_chunks().0.iter().map(|&chunk| decode!(Number, chunk, big_endian));
            match scale {
                None => values.extend(numbers.map(|number| number as f32)),
                Some([slope, intercept]) => {
                    values.extend(numbers.map(|number| (slope * number as f64 + intercept) as f32));
                }
            }
        });
    }

    /// The value at the start of `bytes`, or 0 if they are too short; 64-bit integers are rounded.
    pub(super) fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        with_type!(self, Number => {
            let chunk = bytes.first_chunk().copied().unwrap_or_default();
            decode!(Number, chunk, big_endian) as f64
        })
    }

    /// Parses a value of this type.
    pub(super) fn parse(self, word: &str) -> Option<f32> {
        with_type!(self, Number => word.parse::<Number>().ok().map(|number| number as f32))
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
