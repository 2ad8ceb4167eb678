//! Bookmarks of views, which persist.

use hypertexture::scene::Camera;
use hypertexture_support::{open, write_whole};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Size limit of the list, bytes.
const MAX_LIST: u64 = 1 << 16;
/// Maximal number of bookmarks.
const MAX_BOOKMARKS: usize = 32;

/// Bookmarks of views.
#[derive(Default)]
pub(super) struct Bookmarks {
    pub(super) views: Vec<Camera>,
    /// Path of the list.
    list: Option<PathBuf>,
}

/// The file of bookmarks.
#[derive(Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct List {
    view: Vec<Camera>,
}

impl Bookmarks {
    /// Reads the bookmarks in `folder`; an unreadable list counts as empty.
    pub(super) fn of(folder: Option<&Path>) -> Bookmarks {
        let list = folder.map(|folder| folder.join("views.toml"));
        let text = list.as_deref().and_then(|list| open::text(list, MAX_LIST).ok()).unwrap_or_default();
        let views = toml::from_str(&text).unwrap_or_else(|error| {
            log::warn!("the list of views cannot be read: {error}");
            List::default()
        });
        Bookmarks { views: views.view, list }
    }

    /// Adds a bookmark of a camera.
    pub(super) fn add(&mut self, camera: &Camera) {
        let view = looking(&Camera::default(), camera);
        if self.views.len() < MAX_BOOKMARKS && !self.views.contains(&view) {
            self.views.push(view);
            self.write();
        }
    }

    pub(super) fn remove(&mut self, index: usize) {
        self.views.remove(index);
        self.write();
    }

    fn write(&self) {
        let Some(list) = &self.list else { return };
        let text = toml::to_string(&List { view: self.views.clone() }).unwrap_or_default();
        write_whole(list, text.as_bytes()).unwrap_or_else(|error| log::warn!("{}: {error}", list.display()));
    }
}

/// A camera with the view of `view` but its own time and clip plane.
pub(super) fn looking(camera: &Camera, view: &Camera) -> Camera {
    let Camera { projection, azimuth, elevation, rotation, pan, zoom, field_of_view, .. } = view.clone();
    Camera { projection, azimuth, elevation, rotation, pan, zoom, field_of_view, ..camera.clone() }
}
