//! Packed streams.
//!
//! Role: what gzip, zlib, bzip2 or hexadecimal digits hold, as a stream of bytes. Invariant: the sum of every part is checked,
//! and what stands behind the last one is zeros or an error; behind zlib, which has no parts, anything.

use bzip2::bufread::BzDecoder;
use flate2::bufread::{GzDecoder, ZlibDecoder};
use std::cell::Cell;
use std::io::{self, BufRead, ErrorKind, Read};

/// First bytes of gzip and of bzip2, and half of the first one of zlib.
pub(super) const GZIP: [u8; 3] = [0x1f, 0x8b, 8];
pub(super) const ZLIB: u8 = 8;
const BZIP2: u8 = b'B';

/// One packed part.
enum Part<R> {
    Gzip(Box<GzDecoder<R>>),
    Zlib(ZlibDecoder<R>),
    Bzip2(BzDecoder<R>),
}

/// Packed parts, one behind the other.
pub(super) struct Unpacked<'a, R> {
    /// None once all has been read.
    part: Option<Part<R>>,
    /// Counts the zeros behind them.
    padding: &'a Cell<u64>,
}

impl<'a, R: BufRead> Unpacked<'a, R> {
    /// Parts of gzip.
    pub fn gzip(reader: R, padding: &'a Cell<u64>) -> Unpacked<'a, R> {
        Unpacked { part: Some(Part::Gzip(Box::new(GzDecoder::new(reader)))), padding }
    }

    /// One part of zlib.
    pub fn zlib(reader: R, padding: &'a Cell<u64>) -> Unpacked<'a, R> {
        Unpacked { part: Some(Part::Zlib(ZlibDecoder::new(reader))), padding }
    }

    /// Parts of bzip2.
    pub fn bzip2(reader: R, padding: &'a Cell<u64>) -> Unpacked<'a, R> {
        Unpacked { part: Some(Part::Bzip2(BzDecoder::new(reader))), padding }
    }

    /// The part behind one that has ended.
    fn next(&mut self, part: Part<R>) -> io::Result<Option<Part<R>>> {
        let (mut reader, mark) = match part {
            Part::Gzip(part) => (part.into_inner(), Some(GZIP[0])),
            Part::Bzip2(part) => (part.into_inner(), Some(BZIP2)),
            Part::Zlib(part) => (part.into_inner(), None),
        };
        loop {
            let rest = reader.fill_buf()?;
            let zeros = rest.iter().take_while(|byte| **byte == 0).count();
            match rest.get(zeros) {
                Some(byte) if Some(*byte) == mark && self.padding.get() == 0 && zeros == 0 => break,
                Some(_) if mark.is_none() => return Ok(None),
                Some(_) => return Err(io::Error::new(ErrorKind::InvalidData, "other data behind its end")),
                None if zeros == 0 => return Ok(None),
                None => {
                    reader.consume(zeros);
                    self.padding.set(self.padding.get() + zeros as u64);
                }
            }
        }
        Ok(Some(match mark {
            Some(BZIP2) => Part::Bzip2(BzDecoder::new(reader)),
            _ => Part::Gzip(Box::new(GzDecoder::new(reader))),
        }))
    }
}

impl<R: BufRead> Read for Unpacked<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = match &mut self.part {
                None => return Ok(0),
                Some(Part::Gzip(part)) => part.read(buffer)?,
                Some(Part::Zlib(part)) => part.read(buffer)?,
                Some(Part::Bzip2(part)) => part.read(buffer)?,
            };
            if read > 0 || buffer.is_empty() {
                return Ok(read);
            }
            if let Some(ended) = self.part.take() {
                self.part = self.next(ended)?;
            }
        }
    }
}

/// Bytes that are written as two hexadecimal digits each, between white space.
pub(super) struct Hex<R>(pub R);

impl<R: BufRead> Read for Hex<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut filled = 0;
        while filled < buffer.len() {
            let (Some(high), low) = (self.digit()?, self.digit()?) else { break };
            let low = low.ok_or_else(|| io::Error::new(ErrorKind::UnexpectedEof, "an odd number of digits"))?;
            buffer[filled] = high << 4 | low;
            filled += 1;
        }
        Ok(filled)
    }
}

impl<R: BufRead> Hex<R> {
    /// The next digit, if there is one.
    fn digit(&mut self) -> io::Result<Option<u8>> {
        loop {
            let Some(&byte) = self.0.fill_buf()?.first() else { return Ok(None) };
            self.0.consume(1);
            if byte.is_ascii_whitespace() {
                continue;
            }
            let digit = char::from(byte).to_digit(16);
            let wrong = || io::Error::new(ErrorKind::InvalidData, "a character that is no hexadecimal digit");
            return digit.map(|digit| Some(digit as u8)).ok_or_else(wrong);
        }
    }
}
