//! References kept on disk: they take seconds, and the same one is asked for again and again.
//!
//! Invariant: a file is used only if it has the length that it should have and ends in the BLAKE3 hash of the rest.

use super::Reference;
use crate::glsl::Library;
use crate::render::{RenderError, Subject};
use crate::scene::Scene;
use crate::{field, output, shard};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Raise it when the same scene gives another reference.
const VERSION: u32 = 1;
const MAGIC: &[u8; 8] = b"HYPERREF";
const HASH_BYTES: usize = 32;
/// References kept on disk, all together. Less: those of a report push each other out. More: a person finds a full disk.
const FOLDER_BYTES: u64 = 256 << 20;

/// What a reference depends on, hashed.
pub(super) struct Key(blake3::Hash);

/// The key of the reference of a scene that is its own truth.
pub(super) fn key(truth: &Scene, library: &Library, subject: &Subject, tolerance: f64) -> Result<Key, RenderError> {
    let mut hash = blake3::Hasher::new();
    hash.update(&VERSION.to_le_bytes()).update(&tolerance.to_le_bytes());
    hash.update(shard::identity(truth, library, subject)?.as_bytes());
    Ok(Key(hash.finalize()))
}

impl Key {
    fn file(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.reference", self.0.to_hex()))
    }
}

/// The reference that was saved under a key; `None` if there is none, or its file is damaged.
pub(super) fn load(key: &Key, size: [u32; 2]) -> Option<Reference> {
    parse(&fs::read(key.file(&field::default_folder()?)).ok()?, size)
}

/// Saves a reference; a folder that cannot be written to costs the next one its time, and no more.
pub(super) fn save(key: &Key, reference: &Reference) {
    let Some(folder) = field::default_folder() else { return };
    if fs::create_dir_all(&folder).and_then(|()| output::write_whole(&key.file(&folder), &bytes(reference))).is_err() {
        return;
    }
    forget(&folder);
}

/// Removes the oldest references where there are too many.
fn forget(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let of_ours = entries.filter(|entry| entry.path().extension().is_some_and(|end| end == "reference"));
    let mut files: Vec<(SystemTime, u64, PathBuf)> = of_ours
        .filter_map(|entry| {
            let data = entry.metadata().ok()?;
            Some((data.modified().ok()?, data.len(), entry.path()))
        })
        .collect();
    files.sort();
    let mut total: u64 = files.iter().map(|file| file.1).sum();
    for (_, bytes, path) in files {
        if total <= FOLDER_BYTES || fs::remove_file(path).is_err() {
            break;
        }
        total -= bytes;
    }
}

fn bytes(reference: &Reference) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    for (pixel, estimate) in reference.pixels.iter().zip(&reference.estimate) {
        bytes.extend(pixel.iter().chain([estimate]).flat_map(|value| value.to_le_bytes()));
    }
    let hash = blake3::hash(&bytes);
    bytes.extend(hash.as_bytes());
    bytes
}

fn parse(bytes: &[u8], size: [u32; 2]) -> Option<Reference> {
    let count = size[0] as usize * size[1] as usize;
    let (content, hash) = bytes.split_at_checked(bytes.len().checked_sub(HASH_BYTES)?)?;
    let numbers = content.strip_prefix(MAGIC)?.as_chunks::<8>();
    if blake3::hash(content).as_bytes() != hash || numbers.0.len() != 5 * count || !numbers.1.is_empty() {
        return None;
    }
    let rows = numbers.0.as_chunks::<5>().0.iter().map(|row| row.map(f64::from_le_bytes));
    let (pixels, estimate) = rows.map(|[r, g, b, a, estimate]| ([r, g, b, a], estimate)).unzip();
    Some(Reference { size, pixels, estimate })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_comes_back_as_it_was_and_a_damaged_one_does_not() {
        let pixels = vec![[0.1, 0.2, 0.3, 0.4], [1.0, 0.0, 1e-9, 0.5]];
        let reference = Reference { size: [2, 1], pixels, estimate: vec![1e-7, 2e-6] };
        let written = bytes(&reference);
        assert_eq!(parse(&written, [2, 1]), Some(reference));
        assert_eq!(parse(&written, [1, 1]), None);
        assert_eq!(parse(&written[..written.len() - 1], [2, 1]), None);
        let mut damaged = written;
        damaged[20] ^= 1;
        assert_eq!(parse(&damaged, [2, 1]), None);
        assert_eq!(parse(&[], [2, 1]), None);
    }
}
