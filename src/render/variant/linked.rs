//! Linked programs kept on disk: glslang takes up to a second for one, and the same one is asked for again and again.

use super::{SHIPPED_PROGRAMS, Variant, VariantError};
use crate::shader::{Library, LinkError, Linker, Slots, Stage};
use crate::support::disk_cache::{self, Kind};

/// A few thousand programs.
const KIND: Kind = Kind { ends: &["program"], limit: 256 << 20 };

impl Variant {
    /// Both stages, from the disk or linked here.
    pub(super) fn linked(
        &self,
        library: &Library,
        is_optimized: bool,
        linker: impl FnOnce() -> Result<Linker, LinkError>,
    ) -> Result<[Vec<u32>; 2], VariantError> {
        let entries = self.entries;
        let key = self::key(library, entries, &self.slots, is_optimized);
        if let Some(stages) = load(key) {
            return Ok(stages);
        }
        let linker = linker()?;
        let link = |entry, stage| linker.link(library, entry, stage, &entries, &self.slots);
        let stages = [link(entries[0], Stage::Vertex)?, link(entries[1], Stage::Fragment)?];
        save(key, &stages);
        Ok(stages)
    }
}

/// The key of a program: the hash of all that decides its words. The largest program that this build's compiler made stands
/// for the compiler.
fn key(library: &Library, entries: [&str; 2], slots: &Slots, is_optimized: bool) -> blake3::Hash {
    let mut hash = blake3::Hasher::new();
    let compiler = SHIPPED_PROGRAMS.iter().max_by_key(|program| program.2.len());
    for part in compiler.into_iter().flat_map(|(_, vertex, fragment)| [vertex, fragment]) {
        hash.update(part);
    }
    for (path, text) in library.sources() {
        hash.update(format!("{path} {}\n", text.len()).as_bytes()).update(text.as_bytes());
    }
    hash.update(format!("{entries:?} {slots:?} {is_optimized}").as_bytes());
    hash.finalize()
}

/// The words of both stages that were saved under a key.
fn load(key: blake3::Hash) -> Option<[Vec<u32>; 2]> {
    let bytes = disk_cache::load(KIND, key)?;
    let (words, rest) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let (&first, stages) = words.split_first()?;
    let (vertex, fragment) = stages.split_at_checked(first as usize)?;
    rest.is_empty().then(|| [vertex.to_vec(), fragment.to_vec()])
}

/// Saves the words of both stages.
fn save(key: blake3::Hash, [vertex, fragment]: &[Vec<u32>; 2]) {
    let words = [vertex.len() as u32].into_iter().chain(vertex.iter().chain(fragment).copied());
    disk_cache::save(KIND, key, &words.flat_map(u32::to_le_bytes).collect::<Vec<u8>>());
}
