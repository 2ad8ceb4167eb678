//! Names and files of modules.

use hypertexture_support::open;
use std::fs;
use std::path::Path;
use std::time::SystemTime;

/// Size limit of a module file, bytes.
pub(crate) const MAX_FILE: u64 = 1 << 20;

/// Whether this is a module name that GLSL, scene files and the command line accept.
pub(super) fn is_identifier(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.len() <= 64
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

/// Replaces one identifier by another.
pub(super) fn renamed(text: &str, from: &str, to: &str) -> String {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut new = String::new();
    let mut rest = text;
    while !rest.is_empty() {
        let starts_word = rest.starts_with(is_word);
        let end = rest.find(|c| is_word(c) != starts_word).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        new.push_str(if piece == from { to } else { piece });
        rest = after;
    }
    new
}

/// Modification time and length of a file.
pub(super) fn stamp(path: &Path) -> Option<(SystemTime, u64)> {
    let info = fs::metadata(path).ok()?;
    Some((info.modified().ok()?, info.len()))
}

pub(super) fn read(path: &Path) -> Result<String, String> {
    open::text(path, MAX_FILE).map_err(|error| error.to_string())
}
