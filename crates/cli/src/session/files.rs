//! Folders that a command writes into.

use hypertexture_support::probe;
use std::io;
use std::path::Path;

/// Checks that a folder can be created, or written to.
pub(crate) fn check_folder(folder: &Path) -> Result<(), String> {
    let existing = folder.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("."));
    let existing = if existing.as_os_str().is_empty() { Path::new(".") } else { existing };
    let possible = match folder.metadata() {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => probe(existing),
    };
    possible.map_err(|error| {
        if existing.is_dir() {
            format!("{}: {error}; nothing was written", folder.display())
        } else {
            format!("{}: it is a file; name a folder; nothing was written", existing.display())
        }
    })
}

/// The folder of the report, made and written into before the measurements, so that none is lost.
pub(crate) fn make_folder(folder: &Path) -> Result<(), String> {
    let fail = |error: io::Error| {
        if folder.is_dir() || !folder.exists() {
            format!("{}: {error}; nothing was written", folder.display())
        } else {
            format!("{}: it is a file; name a folder; nothing was written", folder.display())
        }
    };
    std::fs::create_dir_all(folder).map_err(fail)?;
    probe(folder).map_err(fail)
}
