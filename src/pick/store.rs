//! What was picked, kept on disk: by scene, bound, device and driver.

use super::{Bound, Pick, PickError, Verified};
use crate::glsl::Library;
use crate::gpu::Gpu;
use crate::render::Subject;
use crate::scene::{self, Scene};
use crate::{field, output, shard};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::PathBuf;

/// Raise it when the same scene may give another pick.
const VERSION: u32 = 2;

/// What a pick depends on, hashed.
pub(super) struct Key(blake3::Hash);

pub(super) fn key(
    gpu: &Gpu,
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    bound: Bound,
) -> Result<Key, PickError> {
    let facts = gpu.facts();
    let mut hash = blake3::Hasher::new();
    hash.update(&VERSION.to_le_bytes()).update(&bound.error.to_le_bytes());
    hash.update(format!("{}\n{}\n{}\n", bound.metric, facts.name, facts.driver).as_bytes());
    hash.update(shard::identity(scene, library, subject)?.as_bytes());
    Ok(Key(hash.finalize()))
}

impl Key {
    fn file(&self) -> Option<PathBuf> {
        Some(field::default_folder()?.join(format!("{}.pick", self.0.to_hex())))
    }
}

/// A pick as its file has it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    way: String,
    error: f64,
    small_ms: f64,
    verified: Option<Verified>,
    unverified: Option<String>,
    counts: [usize; 3],
    other: Option<(String, f64)>,
    scene: String,
}

/// The pick that was saved under a key; `None` if there is none, or its file is not as it was written.
pub(super) fn load(key: &Key) -> Option<Pick> {
    let stored: Stored = toml::from_str(&fs::read_to_string(key.file()?).ok()?).ok()?;
    Some(Pick {
        scene: scene::parse(&stored.scene, "remembered").ok()?,
        way: stored.way,
        error: stored.error,
        small_ms: stored.small_ms,
        verified: stored.verified,
        unverified: stored.unverified,
        counts: stored.counts,
        other: stored.other,
        remembered: true,
    })
}

/// Saves a pick; a folder that cannot be written to costs the next one its time, and no more.
pub(super) fn save(key: &Key, pick: &Pick) {
    let stored = Stored {
        way: pick.way.clone(),
        error: pick.error,
        small_ms: pick.small_ms,
        verified: pick.verified,
        unverified: pick.unverified.clone(),
        counts: pick.counts,
        other: pick.other.clone(),
        scene: scene::to_text(&pick.scene),
    };
    let (Some(file), Ok(text)) = (key.file(), toml::to_string(&stored)) else { return };
    if file.parent().is_some_and(|folder| fs::create_dir_all(folder).is_ok()) {
        let _ = output::write_whole(&file, text.as_bytes());
    }
}
