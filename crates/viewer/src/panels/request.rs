//! Requests of the panels.

use crate::keys::Action;
use crate::playback::Playback;
use hypertexture::scene::Scene;
use std::path::PathBuf;

/// A request that only the window can fulfill.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Writes the current picture.
    Screenshot(PathBuf),
    /// Resets the camera to that of the preset.
    ResetCamera,
    /// Compares with this scene; `None` ends the comparison.
    Split(Option<Box<Scene>>),
    /// Starts or stops a turntable.
    Record(bool),
    /// Pauses or resumes time.
    Pause(bool),
    /// Sets the time, seconds.
    Time(f64),
    /// Sets speed, range and repetition of time.
    Playback(Playback),
    /// Whether a drag keeps the vertical axis upright.
    Level(bool),
    /// Shows or hides the lesson.
    Lesson(bool),
    /// Sets the error target; `None` uses the samples of the scene.
    MaxError(Option<f64>),
    /// Shows or hides the validity of pixels.
    Validity(bool),
    /// Computes the histogram of densities for the transfer map.
    Densities,
    /// Opens a mesh, a scan, a scene or a module.
    Open(PathBuf),
    /// Performs the action of a key.
    Act(Action),
    /// Begins a new scene, after a question if this one is not saved.
    New,
    /// Begins a new scene.
    Begin,
    /// Closes the program.
    Quit,
}
