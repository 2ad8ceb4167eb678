//! What the panels ask for.

use crate::playback::Playback;
use hypertexture::scene::Scene;
use std::path::PathBuf;

/// What only the window can do.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Write the picture that is shown.
    Screenshot(PathBuf),
    /// Look at the object as the preset does.
    ResetCamera,
    /// Show this scene beside the one that is edited; none ends it.
    Split(Option<Box<Scene>>),
    /// Start or end the writing of frames.
    Record(bool),
    /// Let time stand still, or go on.
    Pause(bool),
    /// Go to a time, seconds.
    Time(f64),
    /// How time runs from now on.
    Playback(Playback),
    /// Whether a drag keeps the vertical axis upright.
    Level(bool),
    /// Choose samples so that the error is at most this; none leaves them to the scene.
    MaxError(Option<f64>),
    /// Show which pixels are not to be trusted, or the picture again.
    Validity(bool),
    /// Find how many points of the object have which density, in time: the transfer map is looked at.
    Densities,
    /// Show a mesh, a scan, a scene or a module.
    Open(PathBuf),
    /// End the program.
    Quit,
}
