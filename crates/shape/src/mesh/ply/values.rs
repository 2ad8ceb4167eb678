//! Numbers after the header of a PLY file.
//!
//! Invariant: numbers of a text may stand in any lines, as long as no line has more of them than the header declares. Files of other
//! programs do have more, in columns that the header does not name; such a file has one element in each line. Both look alike where
//! a line goes on after an element, so the number of lines tells them apart.

use super::header::{Element, Encoding, PlyHeader, Property};
use crate::error::{Found, Location, ShapeError, quoted};
use crate::sample_type::SampleType;
use crate::source::{Source, number, tokens};
use hypertexture_support::memory;
use std::io::Read;

/// How the elements of a text lie in its lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// No line so far went on after an element.
    Unknown,
    /// Numbers in any lines.
    Stream,
    /// An element in each line, and numbers that are left out.
    Lines,
}

/// Reader of the numbers.
pub(super) struct Values<'a, 'b> {
    pub source: &'a mut Source<'b>,
    encoding: Encoding,
    /// Number of elements not read yet, and the least count of numbers in each, by their kind.
    unread: Vec<(u64, usize)>,
    /// Current line of a text file, its number, and the number of bytes consumed of it.
    line: Vec<u8>,
    line_number: u64,
    at: usize,
    /// Lines read ahead, each with a line feed, and the number of bytes consumed of them.
    ahead: Vec<u8>,
    ahead_at: usize,
    layout: Layout,
    /// Whether the current element began at the start of the current line, and whether a number of it has been read.
    is_first: bool,
    is_begun: bool,
    /// Number of lines with more numbers than their element has.
    surplus: u64,
}

/// Whether nothing but blanks is in a text.
fn is_blank(text: &[u8]) -> bool {
    text.iter().all(u8::is_ascii_whitespace)
}

impl<'a, 'b> Values<'a, 'b> {
    pub fn new(source: &'a mut Source<'b>, header: &PlyHeader) -> Values<'a, 'b> {
        let there = header.elements.iter().filter(|element| !element.properties.is_empty());
        Values {
            encoding: header.encoding,
            unread: there.map(|element| (element.count, element.properties.len())).collect(),
            line: Vec::new(),
            line_number: source.line,
            at: 0,
            ahead: Vec::new(),
            ahead_at: 0,
            layout: Layout::Unknown,
            is_first: false,
            is_begun: false,
            surplus: 0,
            source,
        }
    }

    /// Checks that the file is long enough for the declared count.
    pub fn check(&self, element: &Element) -> Result<(), ShapeError> {
        let least = |property: &Property| match (self.encoding, property.list) {
            (Encoding::Text, _) => 2, // a digit and a separator
            (_, Some(length)) => length.bytes(),
            (_, None) => property.kind.bytes(),
        };
        let bytes = element.properties.iter().map(least).sum::<u64>();
        let (declared, left) = (element.count.saturating_mul(bytes), self.left());
        // The last line of a text file may lack its line end.
        if declared > left + u64::from(self.encoding == Encoding::Text) {
            let what = format!("{} of {}, at least {bytes} bytes each", element.count, element.name);
            return Err(self.source.data_size(declared, what, Found::Bytes(left)));
        }
        Ok(())
    }

    /// Reads an element: calls `take` with each number and the index of its property.
    pub fn element(&mut self, element: &Element, mut take: impl FnMut(usize, f64)) -> Result<(), ShapeError> {
        (self.is_first, self.is_begun) = (is_blank(&self.line[self.at..]), false);
        for (place, property) in element.properties.iter().enumerate() {
            let count = match property.list {
                None => 1,
                Some(length) => {
                    let count = self.number(length)?;
                    let bytes = if self.encoding == Encoding::Text { 1 } else { property.kind.bytes() };
                    if count < 0.0 || count.fract() != 0.0 || count * bytes as f64 > self.left() as f64 + 1.0 {
                        let found = format!("{count} numbers of `{}`", property.name);
                        return Err(self.malformed("a list that is in the file", found));
                    }
                    count as u64
                }
            };
            for _ in 0..count {
                take(place, self.number(property.kind)?);
            }
        }
        if let Some((count, _)) = self.unread.iter_mut().find(|(count, _)| *count > 0) {
            *count -= 1;
        }
        self.end_element()
    }

    /// Leaves out the rest of the line after an element, in a text with an element in each line.
    fn end_element(&mut self) -> Result<(), ShapeError> {
        if self.encoding != Encoding::Text || self.layout == Layout::Stream || is_blank(&self.line[self.at..]) {
            return Ok(());
        }
        if self.layout == Layout::Unknown && self.unread.iter().any(|(count, _)| *count > 0) {
            let has_lines = self.is_first && self.has_lines_for_all()?;
            self.layout = if has_lines { Layout::Lines } else { Layout::Stream };
        }
        if self.layout == Layout::Lines {
            self.surplus += 1;
            self.at = self.line.len();
        }
        Ok(())
    }

    /// Whether a line of as many numbers follows for each element that is not read yet. Reads ahead.
    fn has_lines_for_all(&mut self) -> Result<bool, ShapeError> {
        let (left, free) = (self.source.remaining(), memory::available());
        if free.is_some_and(|free| left > free / 2) {
            let (what, found) =
                ("a text with lines of more numbers than an element has, and", format!("{left} bytes left"));
            let remedy = "it does not fit into memory: write it as binary PLY";
            return Err(self.source.unsupported(Location::Line(self.line_number), what, found, remedy));
        }
        let mut line = Vec::new();
        for (count, numbers) in &self.unread {
            let mut lines = 0;
            while lines < *count {
                if !self.source.next_line(&mut line)? {
                    return Ok(false);
                }
                self.ahead.extend_from_slice(&line);
                self.ahead.push(b'\n');
                match tokens(&line).take(*numbers).count() {
                    0 => {}
                    found if found < *numbers => return Ok(false),
                    _ => lines += 1,
                }
            }
        }
        Ok(true)
    }

    /// Notes bytes after the last element.
    pub(crate) fn note_rest(&mut self) {
        if self.surplus > 0 {
            self.source.note(format!(
                "lines have more numbers than the header declares, which are left out: {}",
                self.surplus
            ));
        }
        let bytes = self.left();
        if self.encoding == Encoding::Text && is_blank(&self.line[self.at..]) && is_blank(&self.ahead[self.ahead_at..])
        {
            let mut rest = (&mut *self.source.reader).bytes().map_while(Result::ok);
            if rest.all(|byte| byte.is_ascii_whitespace()) {
                return;
            }
        }
        if bytes > 0 {
            self.source.note(format!("bytes after the last element are left out: {bytes}"));
        }
    }

    /// Bytes not read yet.
    fn left(&self) -> u64 {
        self.source.remaining() + (self.line.len() - self.at + self.ahead.len() - self.ahead_at) as u64
    }

    /// Error at the current position.
    pub fn malformed(&self, expected: &'static str, found: String) -> ShapeError {
        let place = match self.encoding {
            Encoding::Text => Location::Line(self.line_number),
            _ => Location::Byte(self.source.offset),
        };
        self.source.malformed_at(place, expected, found)
    }

    fn number(&mut self, kind: SampleType) -> Result<f64, ShapeError> {
        if self.encoding == Encoding::Text {
            return self.word();
        }
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..kind.bytes() as usize];
        if self.source.remaining() < kind.bytes() {
            return Err(self.malformed("more numbers", "the end of the file".into()));
        }
        self.source.fill(bytes)?;
        Ok(kind.value(bytes, self.encoding == Encoding::Big))
    }

    /// Next number of a text file.
    fn word(&mut self) -> Result<f64, ShapeError> {
        loop {
            let rest = &self.line[self.at..];
            let start = rest.iter().position(|byte| !byte.is_ascii_whitespace());
            if let Some(start) = start {
                let word = &rest[start..];
                let word = &word[..word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len())];
                let value = number(word).ok_or_else(|| self.malformed("a number", quoted(word)))?;
                self.at += start + word.len();
                self.is_begun = true;
                return Ok(value);
            }
            if self.is_begun && self.layout == Layout::Lines {
                let expected = "a whole element in this line, as in those above with more numbers than declared";
                return Err(self.malformed(expected, "its end".into()));
            }
            self.is_first &= !self.is_begun;
            if !self.next_line()? {
                return Err(self.malformed("more numbers", "the end of the file".into()));
            }
        }
    }

    /// Replaces the line by the next one; `false` at the end of the file.
    fn next_line(&mut self) -> Result<bool, ShapeError> {
        self.at = 0;
        let rest = &self.ahead[self.ahead_at..];
        let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
            let is_there = self.source.next_line(&mut self.line)?;
            self.line_number += u64::from(is_there);
            return Ok(is_there);
        };
        self.line.clear();
        self.line.extend_from_slice(&rest[..end]);
        self.ahead_at += end + 1;
        self.line_number += 1;
        Ok(true)
    }
}
