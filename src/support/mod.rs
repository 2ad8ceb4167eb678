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
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Links that are followed, at most.
const LINKS: usize = 40;

/// Writes a file so that it appears whole or not at all: beside its place under a temporary name, synced and renamed. What
/// a link names is written, and the link stays; a file that was there gives it its permissions.
///
/// # Errors
/// What the system says, or that something other than a file is there; it is then as it was.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (path, before) = destination(path)?;
    let temporary = temporary(&path);
    let write = || {
        let mut file = File::create(&temporary)?;
        if let Some(before) = before {
            file.set_permissions(before)?;
        }
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&temporary, &path)
    };
    write().inspect_err(|_| {
        // Best effort: the error to report is the first one.
        let _ = fs::remove_file(&temporary);
    })
}

/// A name beside a file that nobody else uses.
fn temporary(path: &Path) -> PathBuf {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{number}{TEMPORARY}", std::process::id()))
}

/// How names of files end that are being written.
const TEMPORARY: &str = ".tmp";

/// Where a file of this name is written, and the permissions of the one that is there.
///
/// # Errors
/// A directory, a device or a pipe is there, which no file may replace; or a link that leads to itself.
pub(crate) fn destination(path: &Path) -> io::Result<(PathBuf, Option<fs::Permissions>)> {
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        match fs::read_link(&path) {
            Ok(link) => path = path.parent().unwrap_or(Path::new("")).join(link),
            Err(_) => {
                return match fs::metadata(&path) {
                    Ok(about) if about.is_file() => Ok((path, Some(about.permissions()))),
                    Ok(about) if about.is_dir() => Err(io::Error::other("it is a directory; name a file in it")),
                    Ok(_) => {
                        Err(io::Error::other("it is a device, pipe or socket, which no file may replace; name a file"))
                    }
                    Err(_) => Ok((path, None)),
                };
            }
        }
    }
    Err(io::Error::other("it is a link that leads to itself"))
}

/// Writes into a folder, and takes it away again: whether that can be done is known before there is something to lose.
///
/// # Errors
/// What the system says.
pub(crate) fn probe(folder: &Path) -> io::Result<()> {
    let file = temporary(&folder.join("probe"));
    File::create(&file)?;
    fs::remove_file(file)
}

/// A word as `sh` reads it.
#[cfg(any(feature = "viewer", feature = "measure"))]
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}
