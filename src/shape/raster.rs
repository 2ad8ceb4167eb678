//! The samples of a volume, behind a header or in a file of their own.
//!
//! Role: bytes of any type, order and packing into a [`Volume`] on axes that run forwards. Invariant: memory grows with the
//! data that is there, not with what the header declares.

use super::error::{Found, Location, ShapeError};
use super::source::{Source, read_block};
use super::{Content, Shape, Volume};
use flate2::bufread::{MultiGzDecoder, ZlibDecoder};
use glam::DVec3;
use std::io::{self, Read};

/// Most bytes that one byte of deflate can become (P. Deutsch, RFC 1951: 258 bytes for 2 bits).
const MAX_DEFLATE_RATIO: u64 = 1032;
/// Bytes decoded at a time, a multiple of every value size; smaller costs calls, larger leaves the cache.
const BLOCK_BYTES: usize = 64 * 1024;
/// Values that memory grows by at least: 16 MiB. Larger, and a small damaged file takes more than it should.
const GROWTH: usize = 4 << 20;
/// Farther away, f32 rounding moves a sample by more than the 1/100 voxel that `Volume::sample` allows for; nearer, and
/// micro-CT scans in scanner coordinates would be refused.
const MAX_VOXELS_FROM_ORIGIN: f64 = 131_072.0;

/// Where and what the samples are.
pub(super) struct Raster {
    /// Type of a value in the file.
    pub kind: Type,
    /// Whether the first byte of a value is its highest.
    pub big_endian: bool,
    /// How the data is compressed.
    pub packing: Packing,
    /// Samples per axis, at least 1, and their product at most [`MAX_VOXELS`](super::MAX_VOXELS).
    pub size: [u32; 3],
    /// World position of the first sample.
    pub origin: DVec3,
    /// From a sample to the next on each axis: normal numbers of f32, negative where an axis runs backwards.
    pub step: DVec3,
    /// What the values mean.
    pub content: Content,
}

/// How data is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    /// Not at all.
    None,
    /// As gzip does.
    Gzip,
    /// As zlib does.
    Zlib,
}

/// Type of a value in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
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
    /// IEEE single.
    F32,
    /// IEEE double.
    F64,
}

impl Type {
    /// Bytes of a value.
    pub fn bytes(self) -> u64 {
        match self {
            Type::U8 | Type::I8 => 1,
            Type::U16 | Type::I16 => 2,
            Type::U32 | Type::I32 | Type::F32 => 4,
            Type::F64 => 8,
        }
    }
}

/// Bytes before the data of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skip {
    /// So many.
    Bytes(u64),
    /// All but the data, which is at the end.
    ToData,
}

impl Raster {
    /// Reads the data, which is the rest of the source.
    pub fn read(self, source: &mut Source) -> Result<Shape, ShapeError> {
        let Raster { origin, step, size, content, .. } = self;
        let last = origin + step * DVec3::from(size.map(|n| f64::from(n) - 1.0));
        let spacing = step.abs().as_vec3();
        source.check_positions("volume corners", &[origin.as_vec3(), last.as_vec3(), spacing])?;
        let voxels_away = (origin.abs().max(last.abs()) / step.abs()).max_element();
        if voxels_away > MAX_VOXELS_FROM_ORIGIN {
            let (place, found) = (Location::Header, format!("{voxels_away:.0} voxels from the origin"));
            let remedy =
                "move it nearer, 32-bit coordinates cannot tell its samples apart (the limit is 131072 voxels)";
            let file = source.file.clone();
            return Err(ShapeError::Unsupported { file, place, what: "a volume", found, remedy });
        }
        let mut values = self.values(source)?;
        if let Some(first) = values.iter().position(|value| !value.is_finite()) {
            let count = values.iter().filter(|value| !value.is_finite()).count();
            let (file, total) = (source.file.clone(), values.len());
            return Err(ShapeError::NotFinite { file, what: "voxels", count, total, first });
        }
        let mirrored = step.cmplt(DVec3::ZERO);
        let mut block = 1;
        for (axis, &n) in size.iter().enumerate() {
            if mirrored.test(axis) {
                reverse(&mut values, block, n as usize);
            }
            block *= n as usize;
        }
        let origin = DVec3::select(mirrored, last, origin).as_vec3();
        Ok(Shape::Volume(Volume { size, origin, spacing, values, content }))
    }

    /// Goes over what is before the data.
    pub fn skip(&self, source: &mut Source, skip: Skip) -> Result<(), ShapeError> {
        let left = source.remaining();
        let (declared, what) = self.declared();
        let bytes = match skip {
            Skip::Bytes(bytes) => bytes,
            Skip::ToData => left.saturating_sub(declared),
        };
        if bytes > left {
            return Err(source.data_size(declared, format!("{what} behind {bytes} bytes"), Found::Bytes(left)));
        }
        let skipped = io::copy(&mut (&mut *source.reader).take(bytes), &mut io::sink());
        source.offset += skipped.map_err(|reason| source.unreadable(reason))?;
        Ok(())
    }

    /// Bytes of the data, and how that comes about.
    fn declared(&self) -> (u64, String) {
        let sides = self.size.map(|n| n.to_string()).join(" x ");
        let voxels: u64 = self.size.iter().map(|&n| u64::from(n)).product();
        (voxels * self.kind.bytes(), format!("{sides} voxels of {} bytes", self.kind.bytes()))
    }

    fn values(&self, source: &mut Source) -> Result<Vec<f32>, ShapeError> {
        let (declared, what) = self.declared();
        let here = source.remaining();
        let mut values = Vec::new();
        let (file, offset) = (source.file.clone(), source.offset);
        if self.packing == Packing::None {
            if declared != here {
                return Err(source.data_size(declared, what, Found::Bytes(here)));
            }
            let unreadable = |_, reason| ShapeError::Unreadable { file: file.clone(), reason };
            let decoded = read_values(&mut source.reader, self, &file, &mut values, &unreadable)?;
            if decoded < declared {
                return Err(source.data_size(declared, what, Found::Bytes(decoded)));
            }
            return Ok(values);
        }
        let most = here.saturating_mul(MAX_DEFLATE_RATIO);
        if declared > most {
            return Err(source.data_size(declared, what, Found::AtMost(most)));
        }
        let damaged = |decoded, reason| ShapeError::Packed { file: file.clone(), offset, decoded, reason };
        let mut decoder: Box<dyn Read> = match self.packing {
            Packing::Zlib => Box::new(ZlibDecoder::new(&mut *source.reader)),
            _ => Box::new(MultiGzDecoder::new(&mut *source.reader)),
        };
        let decoded = read_values(&mut decoder, self, &file, &mut values, &damaged)?;
        // Reading on to the end checks the length and the sum that close the stream.
        let more = read_block(&mut decoder, &mut [0]).map_err(|reason| damaged(decoded, reason))?;
        drop(decoder);
        if decoded < declared || more > 0 {
            let found = if more > 0 { Found::More } else { Found::Bytes(decoded) };
            return Err(source.data_size(declared, what, found));
        }
        Ok(values)
    }
}

/// Appends all values, or as many as there are; how many bytes were read.
fn read_values(
    reader: &mut dyn Read,
    raster: &Raster,
    file: &str,
    values: &mut Vec<f32>,
    failed: &dyn Fn(u64, io::Error) -> ShapeError,
) -> Result<u64, ShapeError> {
    let value_bytes = raster.kind.bytes();
    let voxels: u64 = raster.size.iter().map(|&n| u64::from(n)).product();
    let mut block = vec![0; BLOCK_BYTES];
    let mut read = 0;
    while read < voxels * value_bytes {
        let wanted = (voxels * value_bytes - read).min(BLOCK_BYTES as u64) as usize;
        let got = read_block(reader, &mut block[..wanted]).map_err(|reason| failed(read, reason))?;
        if values.capacity() - values.len() < BLOCK_BYTES {
            let left = voxels as usize - values.len();
            let more = left.min(values.len().max(GROWTH));
            let bytes = 4 * (values.len() + more) as u64;
            let refused = |_| ShapeError::OutOfMemory { file: file.to_owned(), bytes };
            values.try_reserve_exact(more).map_err(refused)?;
        }
        convert(&block[..got], raster.kind, raster.big_endian, values);
        read += got as u64;
        if got < wanted {
            break;
        }
    }
    Ok(read)
}

/// Appends the whole values of `bytes`.
fn convert(bytes: &[u8], kind: Type, big_endian: bool, values: &mut Vec<f32>) {
    macro_rules! append {
        ($number:ty) => {
            values.extend(bytes.as_chunks().0.iter().map(|&chunk| {
                (if big_endian { <$number>::from_be_bytes(chunk) } else { <$number>::from_le_bytes(chunk) }) as f32
            }))
        };
    }
    match kind {
        Type::U8 => append!(u8),
        Type::I8 => append!(i8),
        Type::U16 => append!(u16),
        Type::I16 => append!(i16),
        Type::U32 => append!(u32),
        Type::I32 => append!(i32),
        Type::F32 => append!(f32),
        Type::F64 => append!(f64),
    }
}

/// Turns one axis of `count` blocks around.
fn reverse(values: &mut [f32], block: usize, count: usize) {
    for axis in values.chunks_exact_mut(block * count) {
        for i in 0..count / 2 {
            let (front, back) = axis.split_at_mut((count - 1 - i) * block);
            front[i * block..][..block].swap_with_slice(&mut back[..block]);
        }
    }
}
