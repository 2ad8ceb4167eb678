//! Disk cache of picks by scene, bound, device and driver.

use super::bound::{ErrorBound, Pick, PickError, Verified};
use crate::compare::Session;
use hypertexture::output::identity_of_texts;
use hypertexture::scene::{self, Scene};
use hypertexture_support::disk_cache::{self, CacheKind};
use serde::{Deserialize, Serialize};

/// Raise it when the same scene may give another pick.
const VERSION: u32 = 11;
/// A few thousand picks.
const KIND: CacheKind = CacheKind { ends: &["pick"], limit: 16 << 20 };

/// The key of a pick: the hash of what it depends on.
pub(super) fn key(session: Session<'_>, scene: &Scene, bound: ErrorBound) -> Result<blake3::Hash, PickError> {
    let info = session.gpu.info();
    let mut hash = blake3::Hasher::new();
    hash.update(&VERSION.to_le_bytes()).update(&bound.error.to_le_bytes());
    hash.update(format!("{}\n{}\n{}\n", bound.metric, info.name, info.driver).as_bytes());
    hash.update(identity_of_texts(scene, session.library, session.subject)?.as_bytes());
    Ok(hash.finalize())
}

/// A pick as its file has it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored {
    settings: String,
    verified: Verified,
    unverified: Option<String>,
    counts: [usize; 4],
    other: Option<(String, f64)>,
    scene: String,
}

/// The pick that was saved under a key; `None` if it is missing or damaged.
pub(super) fn load(key: blake3::Hash) -> Option<Pick> {
    let stored: Stored = toml::from_slice(&disk_cache::load(KIND, key)?).ok()?;
    Some(Pick {
        scene: scene::parse(&stored.scene, "remembered").ok()?,
        settings: stored.settings,
        verified: stored.verified,
        unverified: stored.unverified,
        counts: stored.counts,
        other: stored.other,
        failures: Vec::new(),
        remembered: true,
        picture: None,
    })
}

/// Saves a pick; a folder that cannot be written to costs the next one its time, and no more.
pub(super) fn save(key: blake3::Hash, pick: &Pick) {
    let stored = Stored {
        settings: pick.settings.clone(),
        verified: pick.verified,
        unverified: pick.unverified.clone(),
        counts: pick.counts,
        other: pick.other.clone(),
        scene: scene::to_text(&pick.scene),
    };
    if let Ok(text) = toml::to_string(&stored) {
        disk_cache::save(KIND, key, text.as_bytes());
    }
}
