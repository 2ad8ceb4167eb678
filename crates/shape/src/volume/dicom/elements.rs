//! Data elements of DICOM.
//!
//! Role: tags, types and lengths, with the enclosing sequences. Invariant: the stack of open sequences is bounded, so nesting
//! cannot exhaust memory, and unused elements are skipped by their length. Source: NEMA PS3.5, 7 and annex A.

use crate::error::{ShapeError, quoted};
use crate::source::Source;

/// Pixel data: elements after it are not read.
pub(super) const PIXELS: u32 = 0x7fe0_0010;
/// Shared and per-frame functional groups.
pub(super) const SHARED: u32 = 0x5200_9229;
pub(super) const PER_FRAME: u32 = 0x5200_9230;
/// Sequences in these groups: plane position, plane orientation, pixel measures, pixel value transformation.
const OF_FRAMES: [u32; 4] = [0x0020_9113, 0x0020_9116, 0x0028_9110, 0x0028_9145];
/// Modality LUT sequence.
const TABLE: u32 = 0x0028_3000;
/// Item, end of an item, end of a sequence.
pub(super) const ITEM: u32 = 0xfffe_e000;
const ITEM_END: u32 = 0xfffe_e00d;
pub(super) const SEQUENCE_END: u32 = 0xfffe_e0dd;
/// Length of an element that ends with a delimiter.
pub(super) const UNDEFINED: u32 = u32::MAX;
/// Deepest nesting: 16 sequences with an item each; real files have 6.
const MAX_DEPTH: usize = 32;
/// Longest value read, in bytes; the numbers of a frame are far shorter.
const MAX_VALUE: u32 = 1024;
/// Noun for messages.
const WHAT: &str = "elements of DICOM";

/// Encoding of elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Syntax {
    /// Whether types (VR) are left out.
    pub is_implicit: bool,
    pub big_endian: bool,
}

/// Header of an element; its value is next in the source.
pub(super) struct Element {
    /// Group and element number.
    pub tag: u32,
    /// Type (VR), or zeros.
    pub kind: [u8; 2],
    pub length: u32,
}

/// An open sequence or item.
struct Open {
    tag: u32,
    /// Offset of the end, if the length is defined.
    end: Option<u64>,
    /// Encoding of the contents.
    syntax: Syntax,
    /// Items of a sequence read so far.
    items: usize,
}

/// Reader of elements.
pub(super) struct Elements<'s, 'a> {
    pub source: &'s mut Source<'a>,
    /// Whether a modality LUT was found.
    pub has_table: bool,
    syntax: Syntax,
    open: Vec<Open>,
}

impl<'s, 'a> Elements<'s, 'a> {
    pub fn new(source: &'s mut Source<'a>, syntax: Syntax) -> Self {
        Elements { source, has_table: false, syntax, open: Vec::new() }
    }

    /// Next element other than a sequence, at the top level or in the functional groups; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<Element>, ShapeError> {
        loop {
            while let Some(end) = self.open.last().and_then(|open| open.end)
                && self.source.offset >= end
            {
                if self.source.offset > end {
                    return Err(self.wrong("elements that end where their sequence ends", "a longer one".into()));
                }
                self.open.pop();
            }
            if self.open.is_empty() && self.source.peek()?.is_empty() {
                return Ok(None);
            }
            let head = self.head()?;
            self.has_table |= head.tag == TABLE;
            let in_sequence = self.open.last().is_some_and(|open| open.tag != ITEM);
            match head.tag {
                ITEM if in_sequence => self.item(head.length)?,
                ITEM_END if self.ends(|tag| tag == ITEM) => drop(self.open.pop()),
                SEQUENCE_END if self.ends(|tag| tag != ITEM) => drop(self.open.pop()),
                ITEM | ITEM_END | SEQUENCE_END => {
                    return Err(self.wrong("items in sequences, and their ends after them", "another order".into()));
                }
                tag if in_sequence => return Err(self.wrong("an item in a sequence", shown(tag))),
                PIXELS if self.open.is_empty() => return Ok(Some(head)),
                tag if head.length == UNDEFINED || &head.kind == b"SQ" || self.is_of_frames(tag) => {
                    self.sequence(&head)?;
                }
                _ if self.open.is_empty() || self.is_in_frames() => return Ok(Some(head)),
                _ => self.skip(&head)?,
            }
        }
    }

    /// Outermost open sequence, and the index of its item.
    pub fn group(&self) -> Option<(u32, usize)> {
        self.open.first().map(|open| (open.tag, open.items.saturating_sub(1)))
    }

    /// Skips the value of an element.
    pub fn skip(&mut self, head: &Element) -> Result<(), ShapeError> {
        self.source.skip(u64::from(head.length), WHAT)
    }

    /// Value as text without padding.
    pub fn text(&mut self, head: &Element) -> Result<String, ShapeError> {
        let value = self.value(head)?;
        Ok(String::from_utf8_lossy(&value).trim_matches(|c: char| c == '\0' || c.is_whitespace()).into())
    }

    /// Value as a 16-bit integer.
    pub fn short(&mut self, head: &Element) -> Result<u16, ShapeError> {
        match *self.value(head)? {
            [low, high] => Ok(self.u16([low, high])),
            _ => Err(self.wrong("a number of 16 bits", format!("{} of {} bytes", shown(head.tag), head.length))),
        }
    }

    fn value(&mut self, head: &Element) -> Result<Vec<u8>, ShapeError> {
        if head.length > MAX_VALUE {
            let found = format!("{} of {} bytes", shown(head.tag), head.length);
            return Err(self.wrong("a value of at most 1024 bytes", found));
        }
        self.source.block(u64::from(head.length), WHAT)
    }

    /// Encoding of the innermost open sequence or item.
    fn inner(&self) -> Syntax {
        self.open.last().map_or(self.syntax, |open| open.syntax)
    }

    fn u16(&self, bytes: [u8; 2]) -> u16 {
        if self.inner().big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) }
    }

    fn u32(&self, bytes: [u8; 4]) -> u32 {
        if self.inner().big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    }

    fn head(&mut self) -> Result<Element, ShapeError> {
        let [a, b, c, d] = self.source.array(WHAT)?;
        let tag = u32::from(self.u16([a, b])) << 16 | u32::from(self.u16([c, d]));
        if self.inner().is_implicit || matches!(tag, ITEM | ITEM_END | SEQUENCE_END) {
            let length = self.source.array(WHAT)?;
            return Ok(Element { tag, kind: [0; 2], length: self.u32(length) });
        }
        let [a, b, c, d] = self.source.array(WHAT)?;
        let kind = [a, b];
        if !kind.iter().all(u8::is_ascii_uppercase) {
            return Err(self.wrong("the two letters of a type", format!("{} in {}", quoted(&kind), shown(tag))));
        }
        let is_long = matches!(
            &kind,
            b"OB" | b"OD" | b"OF" | b"OL" | b"OV" | b"OW" | b"SQ" | b"SV" | b"UC" | b"UN" | b"UR" | b"UT" | b"UV"
        );
        if !is_long {
            return Ok(Element { tag, kind, length: u32::from(self.u16([c, d])) });
        }
        let length = self.source.array(WHAT)?;
        Ok(Element { tag, kind, length: self.u32(length) })
    }

    /// Whether the innermost open sequence or item ends with a delimiter and has a tag that `is` accepts.
    fn ends(&self, is: impl Fn(u32) -> bool) -> bool {
        self.open.last().is_some_and(|open| is(open.tag) && open.end.is_none())
    }

    /// Whether `tag` is a functional group sequence at its proper level.
    fn is_of_frames(&self, tag: u32) -> bool {
        match self.open.len() {
            0 => matches!(tag, SHARED | PER_FRAME),
            2 => matches!(self.open[0].tag, SHARED | PER_FRAME) && OF_FRAMES.contains(&tag),
            _ => false,
        }
    }

    /// Whether the next element is in an item of a functional group sequence.
    fn is_in_frames(&self) -> bool {
        let is_there = self.open.len() == 4 && matches!(self.open[0].tag, SHARED | PER_FRAME);
        is_there && OF_FRAMES.contains(&self.open[2].tag)
    }

    /// Enters a sequence, or skips one that is not needed and has a length.
    fn sequence(&mut self, head: &Element) -> Result<(), ShapeError> {
        if head.length != UNDEFINED && !self.is_of_frames(head.tag) {
            return self.skip(head);
        }
        // The contents of type UN are implicit, little endian.
        let unknown = Syntax { is_implicit: true, big_endian: false };
        let syntax = if &head.kind == b"UN" { unknown } else { self.inner() };
        self.enter(head.tag, head.length, syntax)
    }

    fn item(&mut self, length: u32) -> Result<(), ShapeError> {
        let is_asked_for =
            self.open.iter().all(|open| matches!(open.tag, ITEM | SHARED | PER_FRAME) || OF_FRAMES.contains(&open.tag));
        if let Some(open) = self.open.last_mut() {
            open.items += 1;
        }
        if length != UNDEFINED && !is_asked_for {
            return self.source.skip(u64::from(length), WHAT);
        }
        self.enter(ITEM, length, self.inner())
    }

    fn enter(&mut self, tag: u32, length: u32, syntax: Syntax) -> Result<(), ShapeError> {
        if self.open.len() == MAX_DEPTH {
            return Err(self.wrong("at most 16 sequences inside each other", "more".into()));
        }
        let end = (length != UNDEFINED).then(|| self.source.offset + u64::from(length));
        self.open.push(Open { tag, end, syntax, items: 0 });
        Ok(())
    }

    fn wrong(&self, expected: &'static str, found: String) -> ShapeError {
        self.source.malformed_here(expected, found)
    }
}

/// Tag as `(0028,0010)`.
pub(super) fn shown(tag: u32) -> String {
    format!("({:04X},{:04X})", tag >> 16, tag & 0xffff)
}
