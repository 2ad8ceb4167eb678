//! Status for the panels.

use crate::input::Command;
use crate::message::Message;
use crate::playback::Playback;
use std::sync::Arc;

/// Status of the picture and of the window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// Time of the last frame and its standard deviation, milliseconds.
    pub frame_ms: Option<[f64; 2]>,
    /// Times of the last previews on the device, the newest last, milliseconds.
    pub recent_ms: Vec<f64>,
    /// Time budget of a preview, milliseconds.
    pub budget_ms: f64,
    /// Estimated root mean square error of the picture and its standard error; 1 is full scale.
    pub error: Option<[f64; 2]>,
    /// Stage of the picture, in words.
    pub picture: String,
    /// Size and samples of the picture, in words.
    pub detail: String,
    /// Device and driver.
    pub device: String,
    /// The last message of the window; the model has its own.
    pub message: Option<Message>,
    /// Fields of the scene without an effect on the picture, with their values.
    pub ignored: Vec<String>,
    /// Settings that the picture does not read, whose controls are dimmed.
    pub idle: Vec<String>,
    /// Width and height of the picture in the window, pixels; 0 without a picture.
    pub window: [u32; 2],
    /// Facts about the rendering: pairs of a name and a value.
    pub made: Vec<[String; 2]>,
    /// Progress of the running task, 0 to 1.
    pub progress: Option<f32>,
    /// Whether time is paused.
    pub paused: bool,
    /// Whether a turntable is being written.
    pub recording: bool,
    /// Whether the scene is compared with a pinned one.
    pub split: bool,
    /// Error target; `None` uses the samples of the scene.
    pub max_error: Option<f64>,
    /// Whether the validity of pixels is shown.
    pub validity: bool,
    /// Histogram of the densities of the object from 0 to 1, if known.
    pub densities: Option<Arc<[u32]>>,
    /// The time while it runs.
    pub time: Option<f64>,
    /// Speed, range and repetition of time.
    pub playback: Playback,
    /// Whether the lesson is shown.
    pub lesson: bool,
    /// Whether a drag keeps the vertical axis upright.
    pub level: bool,
    /// States of the commands that are switched on and off.
    pub states: Vec<(Command, bool)>,
}
