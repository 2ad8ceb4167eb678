//! What is kept on disk between runs, because it takes longer to make than to read.
//!
//! Role: bytes under a hash of all that they depend on, in [`field::default_folder`]. Fields, which have a header and
//! warn, are in `field`.
//! Invariant: a file is used only if it ends in the BLAKE3 hash of the rest; files appear whole. A folder that cannot be
//! read or written costs the next run its time, and no more.

use crate::{field, output};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

const HASH_BYTES: usize = 32;

/// Things of one kind, which are kept or forgotten together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kind {
    /// What the names of the files end in.
    pub(crate) end: &'static str,
    /// Bytes of all of them; those used longest ago are forgotten.
    pub(crate) limit: u64,
}

/// What was saved under a key.
pub(crate) fn load(kind: Kind, key: blake3::Hash) -> Option<Vec<u8>> {
    load_from(&field::default_folder()?, kind, key)
}

/// Saves under a key.
pub(crate) fn save(kind: Kind, key: blake3::Hash, bytes: &[u8]) {
    if let Some(folder) = field::default_folder() {
        save_to(&folder, kind, key, bytes);
    }
}

fn file(folder: &Path, kind: Kind, key: blake3::Hash) -> PathBuf {
    folder.join(format!("{}.{}", key.to_hex(), kind.end))
}

fn load_from(folder: &Path, kind: Kind, key: blake3::Hash) -> Option<Vec<u8>> {
    let path = file(folder, kind, key);
    let mut bytes = fs::read(&path).ok()?;
    let length = bytes.len().checked_sub(HASH_BYTES)?;
    if blake3::hash(&bytes[..length]).as_bytes() != &bytes[length..] {
        return None;
    }
    bytes.truncate(length);
    // The time of use decides what goes first.
    let _ = File::options().append(true).open(&path).and_then(|file| file.set_modified(SystemTime::now()));
    Some(bytes)
}

fn save_to(folder: &Path, kind: Kind, key: blake3::Hash, bytes: &[u8]) {
    let whole = [bytes, blake3::hash(bytes).as_bytes()].concat();
    if fs::create_dir_all(folder).and_then(|()| output::write_whole(&file(folder, kind, key), &whole)).is_ok() {
        evict(folder, kind);
    }
}

/// Removes what was used longest ago where there is too much.
fn evict(folder: &Path, kind: Kind) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let of_kind = entries.filter(|entry| entry.path().extension().is_some_and(|end| end == kind.end));
    let mut files: Vec<(SystemTime, u64, PathBuf)> = of_kind
        .filter_map(|entry| {
            let about = entry.metadata().ok()?;
            Some((about.modified().ok()?, about.len(), entry.path()))
        })
        .collect();
    files.sort();
    let mut total: u64 = files.iter().map(|file| file.1).sum();
    for (_, bytes, path) in files {
        if total <= kind.limit || fs::remove_file(path).is_err() {
            break;
        }
        total -= bytes;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: Kind = Kind { end: "test", limit: 200 };

    #[test]
    fn what_was_saved_comes_back_and_what_is_damaged_does_not() {
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
    fn the_one_used_longest_ago_goes_first() {
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

    #[test]
    fn a_folder_that_is_none_keeps_nothing() {
        let file = tempfile::NamedTempFile::new().unwrap();
        save_to(file.path(), KIND, blake3::hash(b"key"), b"bytes");
        assert_eq!(load_from(file.path(), KIND, blake3::hash(b"key")), None);
    }
}
