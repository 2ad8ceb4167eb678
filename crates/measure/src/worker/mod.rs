//! Pictures rendered in a child process, so that a driver that crashes or hangs loses one picture only.
//!
//! Role: [`Painter`] renders in this process or in a [`Worker`], which restarts its process after a crash. The process
//! ([`serve`]) loads the object once, and holds a renderer for each painter. Invariant: the limit of a picture is processor
//! time, so that a busy machine does not cause failures; times are measured in the process, where nothing else runs.

mod client;
mod serve;

pub use client::{PICTURE_TIME, Painter, Remote, Start, Worker};
pub use serve::serve;

use hypertexture::render::Measurements;
use hypertexture::scene::Object;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Name of the job.
pub const JOB: &str = "draw";

/// Object of a worker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Load {
    /// The text of a scene: [`hypertexture::render::Subject::load`].
    Scene(String),
    /// [`hypertexture::render::Subject::load_with_margin`].
    Object {
        /// The object.
        object: Box<Object>,
        /// Margin of its field, object units.
        margin: f32,
        /// Whether closest points are computed.
        closest: bool,
    },
}

/// First request to the process.
#[derive(Debug, Serialize, Deserialize)]
struct Task {
    load: Load,
    /// Texts of modules that differ from the shipped ones.
    changed: BTreeMap<String, String>,
}

/// Further requests to the process.
#[derive(Debug, Serialize, Deserialize)]
enum Request {
    /// Renders a scene with the renderer of this number; `true` recomputes shadows.
    Draw(u64, String, bool),
    /// Drops a renderer.
    Forget(u64),
}

/// A rendered picture; its pixels are the payload. The answer to a task is `()`, once device and object are ready.
#[derive(Debug, Serialize, Deserialize)]
struct Drawn {
    size: [u32; 2],
    measurements: Measurements,
}

/// An error, and whether the device is lost.
#[derive(Debug, Serialize, Deserialize)]
struct Failed {
    reason: String,
    is_lost: bool,
}
