//! The bytes behind a glTF document.
//!
//! Role: buffers from the binary chunk, from `data:` addresses and from files beside the file, each when it is first asked
//! for, and the views into them. Invariant: a view lies in its buffer, and a buffer holds what it declares.

use super::document::{Document, View, entry, malformed, unsupported};
use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::cell::{Cell, OnceCell};

/// Most bytes of all files beside a file together: those of the largest binary STL.
const MAX_SIDE_BYTES: u64 = 2_500_000_000;

/// Base64 with or without its `=` at the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// A document and what it speaks of.
pub struct Data<'a, 's> {
    pub source: &'a Source<'s>,
    pub document: &'a Document<'a>,
    binary: Option<Vec<u8>>,
    loaded: Vec<OnceCell<Vec<u8>>>,
    side_bytes: Cell<u64>,
    /// Elements of accessors without a view that have been read: they cost time and no bytes.
    pub zeros: Cell<u64>,
}

impl<'a, 's> Data<'a, 's> {
    pub fn new(source: &'a Source<'s>, document: &'a Document<'a>, binary: Option<Vec<u8>>) -> Data<'a, 's> {
        let loaded = document.buffers.iter().map(|_| OnceCell::new()).collect();
        Data { source, document, binary, loaded, side_bytes: Cell::new(0), zeros: Cell::new(0) }
    }

    /// A view and its bytes; `place` names it.
    pub fn view(&self, index: u32, place: impl FnOnce() -> String) -> Result<(&View, &[u8]), ShapeError> {
        let view = entry(self.source, &self.document.buffer_views, index, place)?;
        view.extensions.check(self.source, || format!("bufferViews[{index}]"))?;
        let bytes = self.buffer(view.buffer, || format!("bufferViews[{index}].buffer"))?;
        let own = usize::try_from(view.byte_offset).ok().and_then(|start| bytes.get(start..));
        let own = own.and_then(|bytes| bytes.get(..usize::try_from(view.byte_length).ok()?));
        let own = own.ok_or_else(|| {
            let found = format!("{} bytes from byte {} of {}", view.byte_length, view.byte_offset, bytes.len());
            malformed(self.source, format!("bufferViews[{index}]"), "a part of its buffer", found)
        })?;
        Ok((view, own))
    }

    /// The bytes that a buffer declares.
    fn buffer(&self, index: u32, place: impl FnOnce() -> String) -> Result<&[u8], ShapeError> {
        let buffer = entry(self.source, &self.document.buffers, index, place)?;
        let loaded = match (&buffer.uri, &self.binary) {
            (None, Some(binary)) if index == 0 => binary,
            (None, _) => {
                let place = format!("buffers[{index}].uri");
                return Err(malformed(self.source, place, "where its data is", "none, and no binary chunk for it"));
            }
            (Some(uri), _) => {
                let cell = &self.loaded[index as usize];
                match cell.get() {
                    Some(bytes) => bytes,
                    None => {
                        let bytes = self.load(&uri.0, buffer.byte_length, || format!("buffers[{index}].uri"))?;
                        cell.get_or_init(|| bytes)
                    }
                }
            }
        };
        let declared = usize::try_from(buffer.byte_length).ok().and_then(|bytes| loaded.get(..bytes));
        declared.ok_or_else(|| {
            let found = format!("{} of {} bytes that there are", buffer.byte_length, loaded.len());
            malformed(self.source, format!("buffers[{index}].byteLength"), "a part of its data", found)
        })
    }

    /// The bytes at an address, at least those that are declared.
    fn load(&self, uri: &str, declared: u64, place: impl Fn() -> String) -> Result<Vec<u8>, ShapeError> {
        let found = || quoted(uri.as_bytes());
        if let Some(uri) = uri.strip_prefix("data:") {
            let Some((_, text)) = uri.split_once(',').filter(|(about, _)| about.ends_with(";base64")) else {
                let remedy = "write the data in base64";
                return Err(unsupported(self.source, place(), "the data address", found(), remedy));
            };
            return BASE64.decode(text).map_err(|_| malformed(self.source, place(), "data in base64", found()));
        }
        if uri.contains("://") {
            let remedy = "put the file of the data beside this one";
            return Err(unsupported(self.source, place(), "the address", found(), remedy));
        }
        let name = decoded(uri).ok_or_else(|| malformed(self.source, place(), "the name of a file", found()))?;
        let side = self.side_bytes.get().saturating_add(declared);
        if side > MAX_SIDE_BYTES {
            return Err(self.source.too_large("bytes of data beside it", side, MAX_SIDE_BYTES));
        }
        self.side_bytes.set(side);
        let read = self.source.beside(&name, |side| side.block(declared, "the length of the buffer"));
        read.map_err(|error| error.placed(Location::Json(place())))
    }
}

/// An address without its percent signs; none where they or the characters are not right.
fn decoded(uri: &str) -> Option<String> {
    let (mut bytes, mut rest) = (Vec::with_capacity(uri.len()), uri.bytes());
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let mut digit = || char::from(rest.next()?).to_digit(16);
                (digit()? * 16 + digit()?) as u8
            }
            byte => byte,
        });
    }
    String::from_utf8(bytes).ok().filter(|name| !name.is_empty() && !name.contains(char::is_control))
}
