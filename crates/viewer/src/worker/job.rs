//! Jobs for the render thread, and its events.

use super::status::{Cost, Stage};
use crate::document::painting::Trace;
use crate::screen::Encoded;
use hypertexture::render::{Subject, ViewPose};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture_measure::pick::Pick;
use std::sync::Arc;

/// A scene with its modules and its object.
#[derive(Clone)]
pub(crate) struct LoadedScene {
    pub(crate) scene: Arc<Scene>,
    pub(crate) library: Arc<Library>,
    pub(crate) subject: Arc<Subject>,
}

impl LoadedScene {
    /// Whether another variant has the same modules and object, with any groom.
    pub(crate) fn has_same_program(&self, other: &LoadedScene) -> bool {
        let same = Arc::ptr_eq(&self.subject, &other.subject) || self.subject.is_same_object(&other.subject);
        same && Arc::ptr_eq(&self.library, &other.library)
    }
}

/// Whether two shared scenes are equal, which those of one address are.
pub(crate) fn is_same_scene(a: &Arc<Scene>, b: &Arc<Scene>) -> bool {
    Arc::ptr_eq(a, b) || a == b
}

/// A job: the pictures for the screen.
#[derive(Clone)]
pub(crate) struct Job {
    /// Ascending number.
    pub(crate) number: u64,
    /// One variant, or two of equal size to compare.
    pub(crate) variants: Vec<LoadedScene>,
    /// Whether another job is expected soon.
    pub(crate) moving: bool,
    /// Error target.
    pub(crate) max_error: f64,
    /// Focus of the refinement, in fractions of the picture.
    pub(crate) focus: [f32; 2],
    /// Whether the picture is held as drawn, without refinement.
    pub(crate) held: bool,
    /// Whether to compute the validity of the finished picture; with one variant only.
    pub(crate) validity: bool,
    /// The touches of the last stroke of the brush.
    pub(crate) trace: Option<Arc<Trace>>,
}

/// A picture and its measurements.
#[derive(Default)]
pub(crate) struct Picture {
    /// Number of its job.
    pub(crate) number: u64,
    /// Encoded images.
    pub(crate) images: Encoded,
    /// Premultiplied linear RGBA of the images; empty for validity colors.
    pub(crate) frames: Vec<Arc<[[f32; 4]]>>,
    /// Root mean square difference of two equally sampled variants.
    pub(crate) difference: Option<f64>,
    /// Costs of the finished own pictures, one for each variant.
    pub(crate) costs: Vec<Cost>,
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    /// View of the picture.
    pub(crate) pose: Option<ViewPose>,
    pub(crate) stage: Stage,
    /// Part of an unfinished picture that is drawn, 0 to 1.
    pub(crate) done: f32,
    /// Time of all variants on the device, milliseconds.
    pub(crate) gpu_ms: f64,
    pub(crate) error: Option<f64>,
    pub(crate) standard_error: Option<f64>,
    /// Shows the legend of the validity colors.
    pub(crate) validity: Vec<([u8; 3], String)>,
}

/// An event of the render thread.
pub(crate) enum Event {
    /// A picture is available.
    Picture(Box<Picture>),
    /// Facts about the rendering: pairs of a name and a value.
    Made(Vec<[String; 2]>),
    /// Fields without an effect on the picture.
    Ignored(Vec<String>),
    /// Progress of a search.
    Picking(f32),
    /// Result of a search; `None` if it was stopped.
    Picked(Option<Box<Pick>>),
    /// A program was refused.
    Refused(String),
    /// A search or a job has failed.
    Failed(String),
    /// The device is lost, and the thread ends.
    Lost,
}
