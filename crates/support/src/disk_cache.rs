//! Results cached on disk between runs.
//!
//! Invariant: a file is used only if it ends in the BLAKE3 hash of its name and content. A folder that cannot be read or
//! written only costs time. Links, pipes, directories and anything else in the place of a file are not opened, and are
//! replaced.

use super::files::{replace, sweep};
use super::open::{self, OpenError};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::SystemTime;

const HASH_BYTES: usize = 32;

/// A kind of cached files, evicted together.
#[derive(Clone, Copy, Debug)]
pub struct CacheKind {
    /// File extensions; [`load`] and [`save`] use the first.
    pub ends: &'static [&'static str],
    /// Largest total size in bytes, enforced by evicting the least recently used. No longer file is read.
    pub limit: u64,
}

/// `$HYPERTEXTURE_CACHE`, else `$XDG_CACHE_HOME/hypertexture`, else `~/.cache/hypertexture`; `None` without a home.
pub fn default_folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("HYPERTEXTURE_CACHE")
        .or_else(|| set("XDG_CACHE_HOME").map(|folder| folder.join("hypertexture")))
        .or_else(|| set("HOME").map(|folder| folder.join(".cache").join("hypertexture")))
}

/// The bytes saved under a key.
pub fn load(kind: CacheKind, key: blake3::Hash) -> Option<Vec<u8>> {
    read(&file(&default_folder()?, kind, key), kind).ok()?
}

/// Saves bytes under a key, if possible.
pub fn save(kind: CacheKind, key: blake3::Hash, bytes: &[u8]) {
    if let Some(folder) = default_folder()
        && let Err(error) = write(&file(&folder, kind, key), bytes.to_vec(), kind)
    {
        warn(&folder, &error);
    }
}

/// Logs, once in a process, that results are computed again each time.
pub fn warn(folder: &Path, error: &io::Error) {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let folder = folder.display();
        log::warn!("{folder}: nothing can be cached: {error}; set HYPERTEXTURE_CACHE to a folder that can be written");
    });
}

fn file(folder: &Path, kind: CacheKind, key: blake3::Hash) -> PathBuf {
    folder.join(format!("{}.{}", key.to_hex(), kind.ends[0]))
}

/// Content of a cached file; `None` if it is damaged, too long or not a plain file.
///
/// # Errors
/// I/O errors.
pub fn read(path: &Path, kind: CacheKind) -> Result<Option<Vec<u8>>, OpenError> {
    if !fs::symlink_metadata(path)?.is_file() {
        return Ok(None);
    }
    let mut bytes = match open::bytes(path, kind.limit) {
        Err(OpenError::Long { .. } | OpenError::NotAFile(_)) => return Ok(None),
        read => read?,
    };
    let Some((content, hash)) = bytes.split_last_chunk::<HASH_BYTES>() else { return Ok(None) };
    if hash_of(path, content).as_bytes() != hash {
        return Ok(None);
    }
    bytes.truncate(content.len());
    // The modification time is the time of last use.
    let _ = File::options().append(true).open(path).and_then(|file| file.set_modified(SystemTime::now()));
    Ok(Some(bytes))
}

/// Hash of a file's content and name, so that renamed files are not mistaken for others.
fn hash_of(path: &Path, content: &[u8]) -> blake3::Hash {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    blake3::Hasher::new().update(name.as_bytes()).update(&[0]).update(content).finalize()
}

/// Writes a file with its hash, and evicts the least recently used of its kind beyond the limit.
///
/// # Errors
/// I/O errors.
pub fn write(path: &Path, mut bytes: Vec<u8>, kind: CacheKind) -> io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let hash = hash_of(path, &bytes);
    bytes.extend_from_slice(hash.as_bytes());
    if fs::symlink_metadata(path).is_ok_and(|about| about.is_dir()) {
        fs::remove_dir_all(path)?; // a rename replaces all else
    }
    replace(path, None, |file| file.write_all(&bytes))?;
    evict(folder, kind)
}

/// Sweeps a folder and removes the least recently used files of a kind beyond its limit.
fn evict(folder: &Path, kind: CacheKind) -> io::Result<()> {
    sweep(folder);
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let Ok(about) = fs::symlink_metadata(&path) else { continue };
        if about.is_file() && path.extension().is_some_and(|end| kind.ends.iter().any(|of_kind| end == *of_kind)) {
            files.push((about.modified()?, about.len(), path));
        }
    }
    files.sort();
    let mut total: u64 = files.iter().map(|(_, bytes, _)| bytes).sum();
    for (_, bytes, path) in files {
        if total <= kind.limit {
            break;
        }
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error), // else another process removed it
            _ => total -= bytes,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn save_to(folder: &Path, kind: CacheKind, key: blake3::Hash, bytes: &[u8]) {
        let _ = write(&file(folder, kind, key), bytes.to_vec(), kind);
    }

    fn load_from(folder: &Path, kind: CacheKind, key: blake3::Hash) -> Option<Vec<u8>> {
        read(&file(folder, kind, key), kind).ok()?
    }

    const KIND: CacheKind = CacheKind { ends: &["test"], limit: 200 };

    #[test]
    fn saved_files_are_loaded_and_damaged_ones_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let key = blake3::hash(b"key");
        assert_eq!(load_from(folder.path(), KIND, key), None);
        for bytes in [&b"some bytes"[..], b""] {
            save_to(folder.path(), KIND, key, bytes);
            assert_eq!(load_from(folder.path(), KIND, key).as_deref(), Some(bytes));
        }
        save_to(folder.path(), KIND, key, b"some bytes");
        let path = file(folder.path(), KIND, key);
        let whole = fs::read(&path).unwrap();
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            fs::write(&path, damaged).unwrap();
            assert_eq!(load_from(folder.path(), KIND, key), None, "byte {at}");
            fs::write(&path, &whole[..at]).unwrap();
            assert_eq!(load_from(folder.path(), KIND, key), None, "cut at {at}");
        }
    }

    #[test]
    fn a_renamed_file_is_not_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = [b"a", b"b"].map(|name| blake3::hash(name));
        save_to(folder.path(), KIND, a, b"of a");
        fs::rename(file(folder.path(), KIND, a), file(folder.path(), KIND, b)).unwrap();
        assert_eq!(load_from(folder.path(), KIND, b), None);
    }

    #[test]
    fn the_least_recently_used_file_is_evicted() {
        let folder = tempfile::tempdir().unwrap();
        let keys = [b"a", b"b", b"c"].map(|name| blake3::hash(name));
        let at = |key: usize, seconds| {
            let file = File::options().append(true).open(file(folder.path(), KIND, keys[key])).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds)).unwrap();
        };
        save_to(folder.path(), KIND, keys[0], &[0; 50]);
        save_to(folder.path(), KIND, keys[1], &[1; 50]);
        at(0, 2);
        at(1, 1);
        save_to(folder.path(), KIND, keys[2], &[2; 50]);
        let left = keys.map(|key| load_from(folder.path(), KIND, key).is_some());
        assert_eq!(left, [true, false, true]);
    }

    #[cfg(unix)]
    #[test]
    fn anything_but_a_file_is_replaced_unopened() {
        let folder = tempfile::tempdir().unwrap();
        let key = blake3::hash(b"key");
        let path = file(folder.path(), KIND, key);
        let (good, other) = (folder.path().join("good"), folder.path().join("other"));
        save_to(folder.path(), KIND, key, b"bytes");
        fs::rename(&path, &good).unwrap();
        fs::write(&other, "of a person").unwrap();
        let link = |to: &Path| std::os::unix::fs::symlink(to, &path).unwrap();
        let place: [&dyn Fn(); 7] = [
            &|| assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success()),
            &|| link(Path::new("/dev/zero")),
            &|| link(&path),
            &|| link(&other),
            &|| link(&good),
            &|| fs::create_dir_all(path.join("below")).unwrap(),
            &|| File::create(&path).unwrap().set_len(5 << 30).unwrap(), // of holes: it takes no room
        ];
        for put in place {
            put();
            assert_eq!(load_from(folder.path(), KIND, key), None);
            save_to(folder.path(), KIND, key, b"bytes");
            assert_eq!(load_from(folder.path(), KIND, key).as_deref(), Some(&b"bytes"[..]));
            fs::remove_file(&path).unwrap();
        }
        assert_eq!(fs::read_to_string(&other).unwrap(), "of a person");
    }

    #[test]
    fn a_file_in_place_of_the_folder_disables_the_cache() {
        let file = tempfile::NamedTempFile::new().unwrap();
        save_to(file.path(), KIND, blake3::hash(b"key"), b"bytes");
        assert_eq!(load_from(file.path(), KIND, blake3::hash(b"key")), None);
    }
}
