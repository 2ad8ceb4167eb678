//! Jobs and tasks for the render thread, and its events.

use crate::status::Stage;
use egui::ColorImage;
use hypertexture::render::{Subject, ViewPose};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use measure::pick::{ErrorBound, Pick};
use std::path::PathBuf;
use std::sync::Arc;

/// A scene with its modules and its object.
#[derive(Clone)]
pub(crate) struct Variant {
    pub(crate) scene: Scene,
    pub(crate) library: Arc<Library>,
    pub(crate) subject: Arc<Subject>,
}

impl Variant {
    /// Whether another one has the same modules and object.
    pub(crate) fn has_same_program(&self, other: &Variant) -> bool {
        Arc::ptr_eq(&self.library, &other.library) && Arc::ptr_eq(&self.subject, &other.subject)
    }
}

/// What is to be on the screen.
#[derive(Clone)]
pub(crate) struct Job {
    /// Larger than that of the job before.
    pub(crate) number: u64,
    /// One, or two to be compared; their pictures have the same size.
    pub(crate) variants: Vec<Variant>,
    /// Whether the next one is expected soon.
    pub(crate) moving: bool,
    /// The error that is good enough.
    pub(crate) max_error: f64,
    /// Where one looks, in parts of the width and height of a picture: what is there gets finer first.
    pub(crate) focus: [f32; 2],
    /// Whether the pixels that are not to be trusted are shown, once the picture is finished; of one variant.
    pub(crate) validity: bool,
}

/// What is done between two jobs.
pub(crate) enum Task {
    /// Writes the picture of a scene, or the `frames` of a turntable. `edited` are modules whose text is in no file.
    Write { variant: Box<Variant>, path: PathBuf, frames: Option<u32>, edited: Vec<String> },
    /// Looks for the fastest settings within an error.
    Pick { variant: Box<Variant>, bound: ErrorBound },
}

/// A picture, ready to be shown, and what is known about it.
#[derive(Default)]
pub(crate) struct Picture {
    /// That of its job.
    pub(crate) number: u64,
    /// One for each variant.
    pub(crate) images: Vec<ColorImage>,
    /// What they are of: premultiplied linear RGBA; none where pixels are colored by what they are worth.
    pub(crate) frames: Vec<Arc<[[f32; 4]]>>,
    /// Root mean square difference of two variants, where both are as finely sampled.
    pub(crate) difference: Option<f64>,
    pub(crate) size: [u32; 2],
    pub(crate) samples: u32,
    /// Where it is looked at from.
    pub(crate) sight: Option<ViewPose>,
    pub(crate) stage: Stage,
    /// Milliseconds on the device, of all variants.
    pub(crate) gpu_ms: f64,
    pub(crate) error: Option<f64>,
    pub(crate) standard_error: Option<f64>,
    /// What the colors of pixels that are not to be trusted mean.
    pub(crate) validity: Vec<([u8; 3], String)>,
}

/// What the thread tells.
pub(crate) enum Event {
    /// There is a picture.
    Picture(Box<Picture>),
    /// What the picture of a job was made with: what each line is about, and what there is.
    Made(Vec<[String; 2]>),
    /// What was set and changes nothing in the picture.
    Ignored(Vec<String>),
    /// A file was written.
    Wrote(PathBuf),
    /// So much of the search for a way to draw is done.
    Picking(f32),
    /// A way to draw was found, or the search was given up.
    Picked(Option<Box<Pick>>),
    /// So many frames of a recording are written.
    Recorded(u32, u32),
    /// A recording was ended by hand; one line.
    Stopped(String),
    /// A program may not be drawn; one line.
    Refused(String),
    /// Something could not be done; one line.
    Failed(String),
    /// The device is gone, and the thread with it.
    Lost,
}
