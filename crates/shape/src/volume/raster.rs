//! Sample data of a volume, after a header or in data files.
//!
//! Role: values of any type, byte order and compression as a [`Volume`](crate::Volume). Invariant: memory grows with the data
//! present, not with the declared size, and decompression stops at the declared size.

use super::data_files::DataFiles;
use super::decompress::{Decompressor, GZIP, Hex, ZLIB};
use super::placement::Placement;
use crate::error::{Found, ShapeError, quoted};
use crate::sample_type::SampleType;
use crate::shape::Shape;
use crate::source::{Source, read_block};
use std::cell::Cell;
use std::io::{self, Read};

/// Highest expansion of deflate (P. Deutsch, RFC 1951: 258 bytes for 2 bits).
pub(super) const MAX_DEFLATE_RATIO: u64 = 1032;
/// Highest expansion of bzip2: a block of 900000 bytes, each 5 of them a run of 259, in 32 bytes at least.
const MAX_BZIP2_RATIO: u64 = 1 << 21;
/// Most decompressed bytes that are skipped. Higher: a small file takes seconds to read.
pub(super) const MAX_UNPACKED_SKIP: u64 = 1 << 28;
/// Bytes decoded at a time, a multiple of every value size. Lower costs calls, higher leaves the cache.
const BLOCK_BYTES: usize = 64 * 1024;
/// Least growth of the values, 16 MiB. Higher: a small damaged file allocates too much.
const GROWTH: usize = 4 << 20;
/// Longest number in a text file, in bytes.
const MAX_WORD: usize = 400;

/// Encoding and placement of samples.
pub(super) struct Raster {
    pub kind: SampleType,
    pub big_endian: bool,
    pub compression: Compression,
    /// Slope and intercept.
    pub scale: Option<[f64; 2]>,
    pub placement: Placement,
}

/// Encoding of the bytes of sample data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Compression {
    None,
    /// Decompressed by the source, whose length is only an upper bound.
    Unpacked,
    Gzip,
    Zlib,
    Bzip2,
    /// Hexadecimal digits.
    Hex,
    /// Numbers as text, separated by white space or commas.
    Text,
}

/// Location of the data.
pub(crate) struct Data {
    /// Data files; `None` if the data follows the header.
    pub files: Option<DataFiles>,
    /// Lines to skip in each file.
    pub lines: u64,
    /// Bytes to skip after these lines; `None` if the data is at the end of the file.
    pub before: Option<u64>,
    /// Decompressed bytes to skip; `None` if the values are the last ones.
    pub inside: Option<u64>,
}

impl Data {
    /// The rest of the current file.
    pub(crate) const HERE: Data = Data { files: None, lines: 0, before: Some(0), inside: Some(0) };
}

impl Raster {
    pub fn read(self, source: &mut Source, data: &Data) -> Result<Shape, ShapeError> {
        self.placement.check(&source.file)?;
        let (mut values, voxels) = (Vec::new(), self.placement.voxels());
        match &data.files {
            None => self.append(source, data, voxels, &mut values)?,
            Some(files) => {
                for file in 0..files.count() {
                    source.beside(&files.name(file), |part| {
                        self.append(part, data, voxels / files.count(), &mut values)
                    })?;
                }
            }
        }
        self.placement.volume(source, values).map(Shape::Volume)
    }

    /// Appends the `count` values of one file.
    fn append(&self, source: &mut Source, data: &Data, count: u64, values: &mut Vec<f32>) -> Result<(), ShapeError> {
        let declared = count * self.kind.bytes();
        let mut what = format!("{} voxels of {} bytes", sides(self.placement.size), self.kind.bytes());
        if data.files.as_ref().is_some_and(|files| files.count() > 1) {
            what = format!("{count} of {what}");
        }
        let mut line = Vec::new();
        for _ in 0..data.lines {
            if !source.next_line(&mut line)? {
                return Err(source.data_size(declared, format!("{what} after {} lines", data.lines), Found::Bytes(0)));
            }
        }
        let left = source.remaining();
        let before = data.before.unwrap_or(left.saturating_sub(declared));
        if before > left {
            return Err(source.data_size(declared, format!("{what} after {before} bytes"), Found::Bytes(left)));
        }
        let (file, offset) = (source.file.clone(), source.offset);
        let failed = |decoded, reason| match self.compression {
            Compression::None | Compression::Text => ShapeError::Unreadable { file: file.clone(), reason },
            _ => ShapeError::Decompression { file: file.clone(), offset, decoded, reason },
        };
        source.offset += skipped(&mut source.reader, before).map_err(|reason| failed(0, reason))?;
        if self.compression == Compression::Text {
            return self.append_text(source, count, values);
        }
        let (here, size) = (source.remaining(), |found| source.data_size(declared, what.clone(), found));
        let most = match self.compression {
            Compression::None | Compression::Unpacked | Compression::Text => here,
            Compression::Gzip | Compression::Zlib => here.saturating_mul(MAX_DEFLATE_RATIO),
            Compression::Bzip2 => here.saturating_mul(MAX_BZIP2_RATIO),
            Compression::Hex => here / 2,
        };
        if self.compression == Compression::None && declared > here {
            return Err(size(Found::Bytes(here)));
        }
        if declared > most {
            return Err(size(Found::AtMost(most)));
        }
        let compression = self.found(source)?;
        let reader = &mut *source.reader;
        let padding = Cell::new(0);
        let mut stream: Box<dyn Read> = match compression {
            Compression::Gzip => Box::new(Decompressor::gzip(reader, &padding)),
            Compression::Zlib => Box::new(Decompressor::zlib(reader, &padding)),
            Compression::Bzip2 => Box::new(Decompressor::bzip2(reader, &padding)),
            Compression::Hex => Box::new(Hex(reader)),
            _ => Box::new(reader),
        };
        let Some(inside) = data.inside else {
            let most = declared + MAX_UNPACKED_SKIP;
            let mut all = Vec::new();
            stream.take(most + 1).read_to_end(&mut all).map_err(|reason| failed(0, reason))?;
            source.note_padding(padding.get());
            return match all.len() as u64 {
                found if found < declared => Err(source.data_size(declared, what, Found::Bytes(found))),
                found if found > most => Err(source.data_size(declared, what, Found::More)),
                found => {
                    let mut last = &all[(found - declared) as usize..];
                    self.append_bytes(&mut last, declared, values, &file, &failed).map(drop)
                }
            };
        };
        let decoded = match skipped(&mut stream, inside).map_err(|reason| failed(0, reason))? {
            all if all == inside => self.append_bytes(&mut stream, declared, values, &file, &failed)?,
            _ => 0,
        };
        // Reading to the end checks the length and the checksum at the end of the stream.
        let more = read_block(&mut stream, &mut [0]).map_err(|reason| failed(decoded, reason))?;
        drop(stream);
        source.note_padding(padding.get());
        if decoded < declared {
            return Err(source.data_size(declared, what, Found::Bytes(decoded)));
        }
        if more > 0 {
            let count = if compression == Compression::None { (here - declared).to_string() } else { "some".into() };
            source.note(format!("bytes after the data that the header declares are left out: {count}"));
        }
        Ok(())
    }

    /// Actual compression: some headers confuse gzip and zlib; the first byte tells.
    fn found(&self, source: &mut Source) -> Result<Compression, ShapeError> {
        let first = source.peek()?.first().copied().unwrap_or_default();
        let (found, name) = match self.compression {
            Compression::Zlib if first == GZIP[0] => (Compression::Gzip, "gzip"),
            Compression::Gzip if first & 0xf == ZLIB => (Compression::Zlib, "zlib"),
            compression => return Ok(compression),
        };
        source.note(format!("its data is compressed by {name}, contrary to the header"));
        Ok(found)
    }

    /// Appends the values in up to `bytes` bytes; returns the number of bytes read.
    fn append_bytes(
        &self,
        stream: &mut dyn Read,
        bytes: u64,
        values: &mut Vec<f32>,
        file: &str,
        failed: &dyn Fn(u64, io::Error) -> ShapeError,
    ) -> Result<u64, ShapeError> {
        let mut block = vec![0; BLOCK_BYTES];
        let mut read = 0;
        while read < bytes {
            let wanted = (bytes - read).min(BLOCK_BYTES as u64) as usize;
            let got = read_block(stream, &mut block[..wanted]).map_err(|reason| failed(read, reason))?;
            self.reserve(BLOCK_BYTES, values, file)?;
            self.kind.append(&block[..got], self.big_endian, self.scale, values);
            read += got as u64;
            if got < wanted {
                break;
            }
        }
        Ok(read)
    }

    /// Appends `count` numbers from text.
    fn append_text(&self, source: &mut Source, count: u64, values: &mut Vec<f32>) -> Result<(), ShapeError> {
        let mut word = Vec::new();
        for read in 0..count {
            if !next_word(source, &mut word)? {
                let found = format!("{read} of {count}, and the end of the file");
                let expected = "as many numbers as the header says";
                return Err(source.malformed_here(expected, found));
            }
            let text = std::str::from_utf8(&word).ok().filter(|word| word.len() < MAX_WORD);
            let Some(number) = text.and_then(|word| self.kind.parse(word)) else {
                let expected = "a number of the type that the header says";
                return Err(source.malformed_here(expected, quoted(&word)));
            };
            self.reserve(1, values, &source.file)?;
            values.push(number);
        }
        if next_word(source, &mut word)? {
            source.note(format!("numbers after the {count} that the header declares are left out"));
        }
        Ok(())
    }

    /// Reserves memory for `more` values, within the declared number.
    fn reserve(&self, more: usize, values: &mut Vec<f32>, file: &str) -> Result<(), ShapeError> {
        if values.capacity() - values.len() >= more {
            return Ok(());
        }
        let left = self.placement.voxels() as usize - values.len();
        let more = left.min(values.len().max(GROWTH));
        let bytes = 4 * (values.len() + more) as u64;
        values.try_reserve_exact(more).map_err(|_| ShapeError::OutOfMemory { file: file.to_owned(), bytes })
    }
}

/// Replaces `word` by the next one, cut after [`MAX_WORD`] bytes; `false` at the end of the file.
fn next_word(source: &mut Source, word: &mut Vec<u8>) -> Result<bool, ShapeError> {
    let is_space = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
    word.clear();
    loop {
        let bytes = match source.reader.fill_buf() {
            Ok(bytes) => bytes,
            Err(reason) => return Err(ShapeError::Unreadable { file: source.file.clone(), reason }),
        };
        let spaces = if word.is_empty() { bytes.iter().take_while(|byte| is_space(byte)).count() } else { 0 };
        let own = bytes[spaces..].iter().take_while(|byte| !is_space(byte)).take(MAX_WORD - word.len()).count();
        word.extend_from_slice(&bytes[spaces..][..own]);
        let is_end = spaces + own < bytes.len() || bytes.is_empty() || word.len() == MAX_WORD;
        source.reader.consume(spaces + own);
        source.offset += (spaces + own) as u64;
        if is_end {
            return Ok(!word.is_empty());
        }
    }
}

/// Sizes for a message, as `4 x 5 x 3`.
pub(crate) fn sides(size: [u32; 3]) -> String {
    size.map(|n| n.to_string()).join(" x ")
}

/// Skips up to `bytes` bytes; returns their number.
fn skipped(reader: &mut dyn Read, bytes: u64) -> io::Result<u64> {
    io::copy(&mut reader.take(bytes), &mut io::sink())
}
