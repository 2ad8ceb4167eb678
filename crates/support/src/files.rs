//! Files that appear whole or not at all.
//!
//! Role: a file is written beside its destination under a temporary name, synced and renamed. Invariant: a temporary file is
//! locked while it is written, so that [`sweep`] removes only those of processes that have ended.

use super::faults::file as may_fail;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Most links in a row that are followed.
const MAX_LINKS: usize = 40;
/// Characters of the file's own name in a temporary name, at most 4 bytes each.
const NAME_CHARS: usize = 24;
/// Suffix of temporary names.
const TEMPORARY: &str = ".tmp";
/// Age from which an unlocked temporary file counts as abandoned on file systems without locks.
const ABANDONED: Duration = Duration::from_secs(3600);

/// Writes a file atomically. Links are followed and stay; permissions of a replaced file are kept.
///
/// # Errors
/// I/O errors, or that the destination is not a plain file. The destination is unchanged then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_whole_by(path, |file| file.write_all(bytes))
}

/// Writes a file atomically, as [`write_whole`] does, by a function.
///
/// # Errors
/// As [`write_whole`], and those of `fill`.
pub fn write_whole_by(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let (path, before) = destination(path)?;
    replace(&path, before, fill)
}

/// Bytes free on the file system of a file's folder, if known.
pub fn free_space(file: &Path) -> Option<u64> {
    #[cfg(unix)]
    {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        rustix::fs::statvfs(folder).ok().map(|about| about.f_bavail.saturating_mul(about.f_frsize))
    }
    #[cfg(not(unix))]
    None
}

/// Replaces anything but a directory by a file, with `permissions` if given. A link itself is replaced.
pub(super) fn replace(
    path: &Path,
    permissions: Option<fs::Permissions>,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let temporary = temporary(path);
    let write = || {
        let mut file = create_locked(&temporary)?;
        if let Some(permissions) = permissions {
            may_fail("set_permissions")?;
            file.set_permissions(permissions)?;
        }
        may_fail("write")?;
        let mut buffer = BufWriter::new(&mut file);
        fill(&mut buffer)?;
        buffer.flush()?;
        drop(buffer);
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

/// A new temporary file, locked while it is open.
fn create_locked(temporary: &Path) -> io::Result<File> {
    loop {
        may_fail("create")?;
        let file = File::create(temporary)?;
        let is_locked = file.lock().is_ok();
        if !is_locked || temporary.exists() {
            return Ok(file);
        } // swept between its creation and its lock
    }
}

/// A unique name beside a file, within the length limit of file systems.
fn temporary(path: &Path) -> PathBuf {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let name: String = path.file_name().unwrap_or_default().to_string_lossy().chars().take(NAME_CHARS).collect();
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{number}{TEMPORARY}", std::process::id()))
}

/// The path that a file is written to once links are followed, and the permissions of an existing file.
///
/// # Errors
/// The path is a directory, a device or a pipe, leads back to itself through links, or is too long.
pub fn destination(path: &Path) -> io::Result<(PathBuf, Option<fs::Permissions>)> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
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

/// Checks that a folder can be written to, and sweeps it.
///
/// # Errors
/// I/O errors.
pub fn probe(folder: &Path) -> io::Result<()> {
    let file = temporary(&folder.join("probe"));
    let _file = create_locked(&file)?;
    fs::remove_file(&file)?;
    sweep(folder);
    Ok(())
}

/// Removes temporary files of processes that have ended, as far as possible.
pub fn sweep(folder: &Path) {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let swept = files.filter(|path| is_temporary(path) && remove_abandoned(path).is_ok_and(|removed| removed)).count();
    if swept > 0 {
        log::info!("{}: removed {swept} unfinished files of processes that have ended", folder.display());
    }
}

/// Whether a file name has the form of [`temporary`]: `.name.PROCESS-NUMBER.tmp`.
fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let numbers = name.strip_prefix('.').and_then(|name| name.strip_suffix(TEMPORARY)?.rsplit_once('.'));
    let numbers = numbers.and_then(|(_, numbers)| numbers.split_once('-'));
    numbers.is_some_and(|(process, number)| process.parse::<u32>().is_ok() && number.parse::<u32>().is_ok())
}

/// Removes a file unless it is locked, and returns whether it did.
fn remove_abandoned(path: &Path) -> io::Result<bool> {
    if !fs::symlink_metadata(path)?.is_file() {
        return Ok(false);
    }
    let file = File::open(path)?;
    let is_old = || file.metadata()?.modified().map(|time| time.elapsed().is_ok_and(|age| age > ABANDONED));
    let is_abandoned = match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => is_old()?,
    };
    if is_abandoned {
        fs::remove_file(path)?;
    }
    Ok(is_abandoned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_dead_processes_are_swept() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mut kept = vec![".a.tmp", "a.1-1.tmp", ".a.png.x-1.tmp", ".a.png.1.tmp", "picture.png"];
        for name in kept.iter().chain(&[".a.png.1-0.tmp", ".b.c.4000000-17.tmp"]) {
            fs::write(at(name), "half").unwrap();
        }
        let _file = create_locked(&at(".a.png.7-3.tmp")).unwrap();
        kept.push(".a.png.7-3.tmp");
        probe(folder.path()).unwrap();
        let left = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut left: Vec<String> = left.collect();
        left.sort();
        kept.sort();
        assert_eq!(left, kept);
    }
}
