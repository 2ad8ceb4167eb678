//! What every layer may use: random numbers, files that appear whole, a cache on disk, child processes under limits.

#[doc(hidden)] // for tests
pub mod alone;
pub mod child;
pub mod disk_cache;
#[doc(hidden)] // for tests
pub mod faults;
pub mod memory;
pub mod open;
pub mod random;
pub mod threads;
pub mod watch;
pub mod words;

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Links that are followed, at most.
const LINKS: usize = 40;

/// A number of so many significant digits for a person: 0.0123, and where it is far from 1, 1.23e-9.
pub fn significant(number: f64, digits: usize) -> String {
    let rounded: f64 = format!("{number:.*e}", digits.saturating_sub(1)).parse().unwrap_or(number);
    let is_near = rounded == 0.0 || (1e-4..1e9).contains(&rounded.abs());
    if is_near { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Writes a file so that it appears whole or not at all: beside its place under a temporary name, synced and renamed. What
/// a link names is written, and the link stays; a file that was there gives it its permissions.
///
/// # Errors
/// What the system says, or that something other than a file is there; it is then as it was.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (path, before) = destination(path)?;
    replace(&path, before, bytes)
}

/// Puts a file, with these permissions if any are given, in the place of whatever is there but a directory. A link is replaced
/// itself.
fn replace(path: &Path, permissions: Option<fs::Permissions>, bytes: &[u8]) -> io::Result<()> {
    let temporary = temporary(path);
    let write = || {
        let mut file = in_work(&temporary)?;
        if let Some(permissions) = permissions {
            may_fail("set_permissions")?;
            file.set_permissions(permissions)?;
        }
        may_fail("write")?;
        file.write_all(bytes)?;
        may_fail("sync")?;
        file.sync_all()?;
        may_fail("rename")?;
        fs::rename(&temporary, path)
    };
    write().inspect_err(|_| {
        // Best effort: the error to report is the first one.
        let _ = fs::remove_file(&temporary);
    })
}

/// A new file, locked for as long as it is open: [`sweep`] leaves it alone. Where a file system knows no locks, an hour long.
fn in_work(temporary: &Path) -> io::Result<File> {
    loop {
        may_fail("create")?;
        let file = File::create(temporary)?;
        let is_locked = file.lock().is_ok();
        if !is_locked || temporary.exists() {
            return Ok(file);
        } // it was swept before it was locked
    }
}

pub use faults::file as may_fail;

/// A name beside a file that nobody else uses, no longer than file systems take.
fn temporary(path: &Path) -> PathBuf {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let name: String = path.file_name().unwrap_or_default().to_string_lossy().chars().take(SHOWN).collect();
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{number}{TEMPORARY}", std::process::id()))
}

/// Characters that such a name has of the file's own: at most 4 bytes each.
const SHOWN: usize = 24;

/// How names of files end that are being written.
const TEMPORARY: &str = ".tmp";

/// Where a file of this name is written, and the permissions of the one that is there.
///
/// # Errors
/// A directory, a device or a pipe is there, which no file may replace; a link that leads to itself; or a name that no file
/// can have.
pub fn destination(path: &Path) -> io::Result<(PathBuf, Option<fs::Permissions>)> {
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
                    Err(error) if error.kind() == io::ErrorKind::InvalidFilename => {
                        let bytes = path.file_name().map_or(0, |name| name.as_encoded_bytes().len());
                        Err(io::Error::other(format!(
                            "its name has {bytes} bytes, more than its file system takes (most take 255); give a shorter one"
                        )))
                    }
                    Err(error) if error.kind() == io::ErrorKind::NotFound => Ok((path, None)),
                    Err(error) => Err(error),
                };
            }
        }
    }
    Err(io::Error::other("it is a link that leads to itself"))
}

/// Writes into a folder, and takes it away again: whether that can be done is known before there is something to lose. What
/// processes left there that ended while they wrote is swept.
///
/// # Errors
/// What the system says.
pub fn probe(folder: &Path) -> io::Result<()> {
    let file = temporary(&folder.join("probe"));
    let _work = in_work(&file)?;
    fs::remove_file(&file)?;
    sweep(folder);
    Ok(())
}

/// Removes files in work of processes that are no more; what cannot be removed stays.
pub fn sweep(folder: &Path) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let swept = files.filter(|path| is_temporary(path) && remove_left(path).is_ok_and(|removed| removed)).count();
    if swept > 0 {
        log::info!("{}: {swept} unfinished files of processes that ended are removed", folder.display());
    }
}

/// Whether a file has a name as [`temporary`] gives: `.name.PROCESS-NUMBER.tmp`.
fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let numbers = name.strip_prefix('.').and_then(|name| name.strip_suffix(TEMPORARY)?.rsplit_once('.'));
    let numbers = numbers.and_then(|(_, numbers)| numbers.split_once('-'));
    numbers.is_some_and(|(process, number)| process.parse::<u32>().is_ok() && number.parse::<u32>().is_ok())
}

/// Removes a file that nobody has locked; whether it is removed.
fn remove_left(path: &Path) -> io::Result<bool> {
    if !fs::symlink_metadata(path)?.is_file() {
        return Ok(false);
    }
    let file = File::open(path)?;
    let is_old = || file.metadata()?.modified().map(|time| time.elapsed().is_ok_and(|age| age > LEFT));
    let is_left = match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => is_old()?,
    };
    if is_left {
        fs::remove_file(path)?;
    }
    Ok(is_left)
}

/// A file in work that is not locked, where there are no locks, is one that nobody works on after so long.
const LEFT: Duration = Duration::from_secs(3600);

/// A word as `sh` reads it.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_dead_processes_left_is_swept_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mut kept = vec![".a.tmp", "a.1-1.tmp", ".a.png.x-1.tmp", ".a.png.1.tmp", "picture.png"];
        for name in kept.iter().chain(&[".a.png.1-0.tmp", ".b.c.4000000-17.tmp"]) {
            fs::write(at(name), "half").unwrap();
        }
        let _work = in_work(&at(".a.png.7-3.tmp")).unwrap();
        kept.push(".a.png.7-3.tmp");
        probe(folder.path()).unwrap();
        let left = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut left: Vec<String> = left.collect();
        left.sort();
        kept.sort();
        assert_eq!(left, kept);
    }
}
