//! A file of a library: its text, and what it includes and declares.

use super::declare::{Declarations, parse};
use super::error::LibraryError;
use std::sync::OnceLock;

/// A text, and what it says, read once: every picture asks.
#[derive(Clone, Debug, Default)]
pub struct File {
    /// GLSL.
    pub text: String,
    includes: OnceLock<Vec<String>>,
    declared: OnceLock<Result<Declarations, LibraryError>>,
}

impl File {
    /// A text of which nothing is known yet.
    pub fn new(text: String) -> File {
        File { text, ..File::default() }
    }

    /// Its lines that include something.
    pub fn includes(&self) -> &[String] {
        let found = || self.text.lines().filter(|line| include(line).is_some()).map(String::from).collect();
        self.includes.get_or_init(found)
    }

    /// What it declares; it is the file of this path.
    pub fn declared(&self, path: &str) -> Result<Declarations, LibraryError> {
        self.declared.get_or_init(|| parse(path, &self.text)).clone()
    }
}

/// What an `#include` asks for.
pub enum Include<'a> {
    /// A file of the library.
    File(&'a str),
    /// What fills a slot.
    Slot(&'a str),
}

/// The `#include` of a line.
pub fn include(line: &str) -> Option<Include<'_>> {
    let what = line.trim_start().strip_prefix("#include")?.trim();
    if let Some(file) = what.strip_prefix('"') {
        return file.split_once('"').map(|(file, _)| Include::File(file));
    }
    what.strip_prefix('<')?.split_once('>').map(|(slot, _)| Include::Slot(slot))
}
