//! What every layer may use: random numbers, files that appear whole, a cache on disk, child processes under limits.

#[cfg(feature = "measure")]
pub(crate) mod child;
pub(crate) mod disk_cache;
pub(crate) mod open;
pub(crate) mod random;
#[cfg(feature = "measure")]
pub(crate) mod watch;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

/// Writes a file so that it appears whole or not at all: beside its place under a temporary name, synced and renamed.
///
/// # Errors
/// What the system says; the file is then as it was.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let temporary = path.with_file_name(format!(".{name}.{}-{number}.tmp", std::process::id()));
    let write = || {
        let mut file = File::create(&temporary)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&temporary, path)
    };
    write().inspect_err(|_| {
        // Best effort: the error to report is the first one.
        let _ = fs::remove_file(&temporary);
    })
}

/// A word as `sh` reads it.
#[cfg(any(feature = "viewer", feature = "measure"))]
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}
