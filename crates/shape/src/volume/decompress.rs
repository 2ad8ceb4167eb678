//! Decompression of gzip, zlib and bzip2 streams, and hexadecimal digits.
//!
//! Invariant: the checksum of every member is checked. After the last member of gzip or bzip2 only zeros may follow, after
//! zlib anything.

use bzip2::bufread::BzDecoder;
use flate2::bufread::{GzDecoder, ZlibDecoder};
use std::cell::Cell;
use std::io::{self, BufRead, ErrorKind, Read};

/// First bytes of gzip, low half of the first byte of zlib, and first byte of bzip2.
pub(super) const GZIP: [u8; 3] = [0x1f, 0x8b, 8];
pub(super) const ZLIB: u8 = 8;
const BZIP2: u8 = b'B';

/// Decoder of one member.
enum Decoder<R> {
    Gzip(Box<GzDecoder<R>>),
    Zlib(ZlibDecoder<R>),
    Bzip2(BzDecoder<R>),
}

/// Decoder of consecutive members.
pub(super) struct Decompressor<'a, R> {
    /// `None` at the end.
    decoder: Option<Decoder<R>>,
    /// Number of zeros after the last member.
    padding: &'a Cell<u64>,
}

impl<'a, R: BufRead> Decompressor<'a, R> {
    pub fn gzip(reader: R, padding: &'a Cell<u64>) -> Decompressor<'a, R> {
        Decompressor { decoder: Some(Decoder::Gzip(Box::new(GzDecoder::new(reader)))), padding }
    }

    pub fn zlib(reader: R, padding: &'a Cell<u64>) -> Decompressor<'a, R> {
        Decompressor { decoder: Some(Decoder::Zlib(ZlibDecoder::new(reader))), padding }
    }

    pub fn bzip2(reader: R, padding: &'a Cell<u64>) -> Decompressor<'a, R> {
        Decompressor { decoder: Some(Decoder::Bzip2(BzDecoder::new(reader))), padding }
    }

    /// Decoder of the member after one that has ended.
    fn next(&mut self, decoder: Decoder<R>) -> io::Result<Option<Decoder<R>>> {
        let (mut reader, mark) = match decoder {
            Decoder::Gzip(decoder) => (decoder.into_inner(), Some(GZIP[0])),
            Decoder::Bzip2(decoder) => (decoder.into_inner(), Some(BZIP2)),
            Decoder::Zlib(decoder) => (decoder.into_inner(), None),
        };
        loop {
            let rest = reader.fill_buf()?;
            let zeros = rest.iter().take_while(|byte| **byte == 0).count();
            match rest.get(zeros) {
                Some(byte) if Some(*byte) == mark && self.padding.get() == 0 && zeros == 0 => break,
                Some(_) if mark.is_none() => return Ok(None),
                Some(_) => return Err(io::Error::new(ErrorKind::InvalidData, "other data after its end")),
                None if zeros == 0 => return Ok(None),
                None => {
                    reader.consume(zeros);
                    self.padding.set(self.padding.get() + zeros as u64);
                }
            }
        }
        Ok(Some(match mark {
            Some(BZIP2) => Decoder::Bzip2(BzDecoder::new(reader)),
            _ => Decoder::Gzip(Box::new(GzDecoder::new(reader))),
        }))
    }
}

impl<R: BufRead> Read for Decompressor<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = match &mut self.decoder {
                None => return Ok(0),
                Some(Decoder::Gzip(decoder)) => decoder.read(buffer)?,
                Some(Decoder::Zlib(decoder)) => decoder.read(buffer)?,
                Some(Decoder::Bzip2(decoder)) => decoder.read(buffer)?,
            };
            if read > 0 || buffer.is_empty() {
                return Ok(read);
            }
            if let Some(ended) = self.decoder.take() {
                self.decoder = self.next(ended)?;
            }
        }
    }
}

/// Bytes as pairs of hexadecimal digits, with white space between digits.
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
    fn digit(&mut self) -> io::Result<Option<u8>> {
        loop {
            let Some(&byte) = self.0.fill_buf()?.first() else { return Ok(None) };
            self.0.consume(1);
            if byte.is_ascii_whitespace() {
                continue;
            }
            let digit = char::from(byte).to_digit(16);
            let wrong = || io::Error::new(ErrorKind::InvalidData, "a character that is not a hexadecimal digit");
            return digit.map(|digit| Some(digit as u8)).ok_or_else(wrong);
        }
    }
}
