//! Jobs of the render thread, and their inputs.

use crate::worker::Job;
use hypertexture::render::ViewPose;
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use std::sync::Arc;
use std::time::Instant;

/// Contents of the picture while an object of the scene is not loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Standing {
    /// No picture.
    #[default]
    Nothing,
    /// The object with another field.
    Coarser,
    /// The object that was shown before.
    Before,
}

/// Inputs of the variants of a job, which are made anew if one has changed. Shared ones are compared by address.
pub(super) struct Inputs {
    pub(super) scene: Arc<Scene>,
    pub(super) library: Arc<Library>,
    pub(super) pinned: Option<(Arc<Scene>, Arc<Library>)>,
    pub(super) clock: Option<f64>,
    /// Width and height of the picture, pixels.
    pub(super) size: [u32; 2],
    /// Whether the field of a scan is coarse.
    pub(super) is_coarse: bool,
    /// Revision of the groom.
    pub(super) groom: u64,
}

impl Inputs {
    /// Whether these inputs give the variants of the others.
    pub(super) fn is_same(&self, other: &Inputs) -> bool {
        let is_pinned_same = match (&self.pinned, &other.pinned) {
            (Some(own), Some(other)) => Arc::ptr_eq(&own.0, &other.0) && Arc::ptr_eq(&own.1, &other.1),
            (own, other) => own.is_none() && other.is_none(),
        };
        Arc::ptr_eq(&self.scene, &other.scene)
            && Arc::ptr_eq(&self.library, &other.library)
            && is_pinned_same
            && (self.clock, self.size) == (other.clock, other.size)
            && (self.is_coarse, self.groom) == (other.is_coarse, other.groom)
    }
}

/// Jobs of the render thread, and the picture on the screen.
pub(crate) struct Jobs {
    /// The job that was submitted last, and the inputs of its variants.
    pub(super) submitted: Option<Job>,
    pub(super) inputs: Option<Inputs>,
    /// Number of the newest job.
    pub(crate) number: u64,
    /// Number of the job whose picture is on the screen.
    pub(crate) on_screen: u64,
    /// Number of the first job of the current scene.
    pub(super) since: u64,
    /// Time of the last change of the scene.
    pub(super) changed: Instant,
    /// Start of the wait for a preview.
    pub(super) waiting_since: Option<Instant>,
    /// Whether a picture has arrived that the window does not show yet.
    pub(super) fresh: bool,
    /// Whether an object of the current scene is not loaded.
    pub(crate) lacks_object: bool,
    /// Contents of the picture while that is so.
    pub(super) standing: Standing,
    /// View of the picture on the screen.
    pub(super) shown_view: Option<ViewPose>,
    /// View of the current scene.
    pub(super) current_view: Option<ViewPose>,
}

impl Jobs {
    pub(super) fn new(now: Instant) -> Jobs {
        Jobs {
            submitted: None,
            inputs: None,
            number: 0,
            on_screen: 0,
            since: 0,
            changed: now,
            waiting_since: None,
            fresh: false,
            lacks_object: false,
            standing: Standing::Nothing,
            shown_view: None,
            current_view: None,
        }
    }
}
