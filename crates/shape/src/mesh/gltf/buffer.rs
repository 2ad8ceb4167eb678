//! Buffers and views of a glTF file.
//!
//! Role: lazy loading from the binary chunk, `data:` URIs and data files. Invariant: a view lies in its buffer, and a buffer has
//! its declared length.

use super::document::{Document, View, entry, malformed, unsupported};
use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::cell::{Cell, OnceCell};

/// Most bytes of all data files together: the size of the largest binary STL file.
const MAX_SIDE_BYTES: u64 = 2_500_000_000;

/// Base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Document with its buffers.
pub struct Data<'a, 's> {
    pub source: &'a Source<'s>,
    pub document: &'a Document<'a>,
    binary: Option<Vec<u8>>,
    loaded: Vec<OnceCell<Vec<u8>>>,
    side_bytes: Cell<u64>,
    /// Elements without a view read so far: they take time without taking bytes.
    pub zeros: Cell<u64>,
}

impl<'a, 's> Data<'a, 's> {
    pub fn new(source: &'a Source<'s>, document: &'a Document<'a>, binary: Option<Vec<u8>>) -> Data<'a, 's> {
        let loaded = document.buffers.iter().map(|_| OnceCell::new()).collect();
        Data { source, document, binary, loaded, side_bytes: Cell::new(0), zeros: Cell::new(0) }
    }

    /// View `index` and its bytes; `place` names the reference to it.
    pub fn view(&self, index: u32, place: impl FnOnce() -> String) -> Result<(&View, &[u8]), ShapeError> {
        let view = entry(self.source, &self.document.buffer_views, index, place)?;
        let is_plain = match self.document.buffers.get(view.buffer as usize) {
            Some(buffer) => buffer.uri.is_some() || view.buffer == 0 && self.binary.is_some(),
            None => false,
        };
        view.extensions.check((self.source, self.document), is_plain, || format!("bufferViews[{index}]"))?;
        let bytes = self.buffer(view.buffer, || format!("bufferViews[{index}].buffer"))?;
        let own = usize::try_from(view.byte_offset).ok().and_then(|start| bytes.get(start..));
        let own = own.and_then(|bytes| bytes.get(..usize::try_from(view.byte_length).ok()?));
        let own = own.ok_or_else(|| {
            let found = format!("{} bytes from byte {} of {}", view.byte_length, view.byte_offset, bytes.len());
            malformed(self.source, format!("bufferViews[{index}]"), "a part of its buffer", found)
        })?;
        Ok((view, own))
    }

    /// Bytes of a buffer, of the declared length.
    fn buffer(&self, index: u32, place: impl FnOnce() -> String) -> Result<&[u8], ShapeError> {
        let buffer = entry(self.source, &self.document.buffers, index, place)?;
        let loaded = match (&buffer.uri, &self.binary) {
            (None, Some(binary)) if index == 0 => binary,
            (None, _) => {
                let place = format!("buffers[{index}].uri");
                return Err(malformed(self.source, place, "the location of its data", "none, and no binary chunk"));
            }
            (Some(uri), _) => {
                let cell = &self.loaded[index as usize];
                match cell.get() {
                    Some(bytes) => bytes,
                    None => {
                        let bytes = self.load(&uri.0, Some(buffer.byte_length), || format!("buffers[{index}].uri"))?;
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

    /// Loads a URI, at least the declared bytes, or the whole file.
    pub fn load(&self, uri: &str, declared: Option<u64>, place: impl Fn() -> String) -> Result<Vec<u8>, ShapeError> {
        let found = || quoted(uri.as_bytes());
        if let Some(uri) = uri.strip_prefix("data:") {
            let Some((_, text)) = uri.split_once(',').filter(|(about, _)| about.ends_with(";base64")) else {
                let remedy = "write the data in base64";
                return Err(unsupported(self.source, place(), "the data address", found(), remedy));
            };
            let text: String = text.split_ascii_whitespace().collect();
            return BASE64.decode(text).map_err(|_| malformed(self.source, place(), "data in base64", found()));
        }
        if uri.contains("://") && !uri.starts_with("file:") {
            let remedy = "put the file of the data beside this one";
            return Err(unsupported(self.source, place(), "the address", found(), remedy));
        }
        let name = decoded(uri).ok_or_else(|| malformed(self.source, place(), "the name of a file", found()))?;
        let read = self.source.beside(&self.source.found(&name.replace('\\', "/")), |side| {
            let bytes = declared.unwrap_or(side.len);
            let all = self.side_bytes.get().saturating_add(bytes);
            if all > MAX_SIDE_BYTES {
                return Err(self.source.too_large("bytes of data beside it", all, MAX_SIDE_BYTES));
            }
            self.side_bytes.set(all);
            side.block(bytes, "the length of the buffer")
        });
        read.map_err(|error| error.placed(Location::Json(place())))
    }
}

/// Percent-decoded file name; `None` if it is invalid.
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
