//! Requests to the child process and its answers, lines of JSON.

use hypertexture::render::Measurements;
use hypertexture::scene::Object;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Name of the hidden command.
pub const COMMAND: &str = "draw";

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

/// First line read by the process.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Task {
    pub(super) load: Load,
    /// Texts of modules that differ from the shipped ones.
    pub(super) changed: BTreeMap<String, String>,
}

/// Requests to the process, a line each.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Request {
    /// Renders a scene with the renderer of this number; `true` recomputes shadows.
    Draw(u64, String, bool),
    /// Drops a renderer.
    Forget(u64),
}

/// Answers of the process, a line each.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Answer {
    /// The device and the object are ready.
    Ready,
    /// A picture, followed by its pixels as bytes.
    Drawn([u32; 2], Box<Measurements>),
    /// An error, and whether the device is lost.
    Failed { reason: String, is_lost: bool },
}

/// A value as a line of JSON.
pub(super) fn line(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("requests and answers are valid JSON") + "\n"
}
