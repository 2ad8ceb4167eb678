//! A file of a library: text, includes and declarations.

use super::declare::{Declarations, parse};
use super::error::LibraryError;
use std::sync::OnceLock;

/// A text with its includes and declarations, parsed once.
#[derive(Clone, Debug, Default)]
pub struct File {
    /// GLSL.
    pub text: String,
    includes: OnceLock<Vec<String>>,
    declared: OnceLock<Result<Declarations, LibraryError>>,
}

impl File {
    /// An unparsed text.
    pub fn new(text: String) -> File {
        File { text, ..File::default() }
    }

    /// The lines with an `#include`.
    pub fn includes(&self) -> &[String] {
        let found = || self.text.lines().filter(|line| include(line).is_some()).map(String::from).collect();
        self.includes.get_or_init(found)
    }

    /// The declarations; `path` is for errors.
    pub fn declared(&self, path: &str) -> Result<Declarations, LibraryError> {
        self.declared.get_or_init(|| parse(path, &self.text)).clone()
    }
}

/// An `#include`.
pub enum Include<'a> {
    /// A file of the library.
    File(&'a str),
    /// The content of a slot.
    Slot(&'a str),
}

/// Parses the `#include` of a line.
pub fn include(line: &str) -> Option<Include<'_>> {
    let target = line.trim_start().strip_prefix("#include")?.trim();
    if let Some(file) = target.strip_prefix('"') {
        return file.split_once('"').map(|(file, _)| Include::File(file));
    }
    target.strip_prefix('<')?.split_once('>').map(|(slot, _)| Include::Slot(slot))
}
