//! The selected object, and locks of objects.

use hypertexture::scene::Scene;
use std::collections::BTreeSet;

/// The selected object, and the locked ones.
#[derive(Default)]
pub(crate) struct Selection {
    /// The selected additional object; `None` for the main one.
    pub(crate) part: Option<String>,
    /// Objects that a click in the picture does not select and that are not placed.
    pub(crate) locked: BTreeSet<String>,
}

impl Selection {
    /// The selected additional object.
    pub(crate) fn part(&self) -> Option<&str> {
        self.part.as_deref()
    }

    /// Selects an additional object, or the main one.
    pub(crate) fn select(&mut self, part: Option<String>) {
        self.part = part;
    }

    /// Whether an object is locked: it is neither selected by a click in the picture nor placed.
    pub(crate) fn is_locked(&self, name: &str) -> bool {
        self.locked.contains(name)
    }

    /// Selects the main object if the selected one is not in the scene.
    pub(crate) fn follow(&mut self, scene: &Scene) {
        self.part.take_if(|name| !scene.parts.contains_key(name.as_str()));
    }

    /// Selects a renamed object, which keeps its lock.
    pub(crate) fn rename(&mut self, from: &str, to: String) {
        if self.locked.remove(from) {
            self.locked.insert(to.clone());
        }
        self.part = Some(to);
    }
}
