//! What the panels are told.

use crate::message::Message;
use crate::playback::Playback;
use std::sync::Arc;

/// What the window knows and the panels show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// Time of the last frame and its spread, milliseconds.
    pub frame_ms: Option<[f64; 2]>,
    /// Milliseconds of the last pictures on the device, the newest last.
    pub recent_ms: Vec<f64>,
    /// Milliseconds that one may take while the scene moves.
    pub budget_ms: f64,
    /// Estimated root mean square error of the picture that is shown, and its own spread, in units of 1.
    pub error: Option<[f64; 2]>,
    /// What is on the screen and how far it is, in words.
    pub picture: String,
    /// Its size and samples, in words.
    pub detail: String,
    /// Device and driver.
    pub device: String,
    /// What went wrong or was done, beside what the model says.
    pub message: Option<Message>,
    /// Fields of the scene that change nothing in the picture, with their values.
    pub ignored: Vec<String>,
    /// Settings that the picture does not read: they have no control, unless all are asked for.
    pub idle: Vec<String>,
    /// Width and height of the picture in the window, pixels; 0 while there is none.
    pub window: [u32; 2],
    /// What the picture was made with: what each line is about, and what there is.
    pub made: Vec<[String; 2]>,
    /// Part of what is under way that is done, 0 to 1.
    pub progress: Option<f32>,
    /// Whether time stands still.
    pub paused: bool,
    /// Whether frames are being written.
    pub recording: bool,
    /// Whether a second scene is shown beside this one.
    pub split: bool,
    /// The error that the picture may have; without one, the scene says how it is made.
    pub max_error: Option<f64>,
    /// Whether pixels that are not to be trusted are shown.
    pub validity: bool,
    /// How many points of the object have which density, from 0 to 1, where that is known.
    pub densities: Option<Arc<[u32]>>,
    /// The time, while it runs.
    pub time: Option<f64>,
    /// How it runs.
    pub playback: Playback,
    /// Whether a drag keeps the vertical axis upright.
    pub level: bool,
}
