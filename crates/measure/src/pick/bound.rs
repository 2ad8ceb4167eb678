//! Bounds of an error, and what is picked within them.

use crate::compare::{CompareError, Failure};
use crate::metric::Metric;
use crate::statistics::rounded_up;
use hypertexture::render::{Frame, RenderError};
use hypertexture::scene::Scene;
use serde::{Deserialize, Serialize};

/// An error that a picture may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBound {
    /// How it is measured.
    pub metric: Metric,
    /// The largest error, above 0.
    pub error: f64,
}

impl ErrorBound {
    /// A bound on an error.
    ///
    /// # Errors
    /// Not above 0, or not finite.
    pub fn new(metric: Metric, error: f64) -> Result<ErrorBound, PickError> {
        if !error.is_finite() || error <= 0.0 {
            return Err(PickError::Value(error));
        }
        Ok(ErrorBound { metric, error })
    }
}

/// What was found of a whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verified {
    /// What its error is below, with 99.9 % of confidence in the pixels that were chosen to be looked at; with what the truth
    /// may be wrong by itself as far as samples say.
    pub error: f64,
    /// Its error by the pixels that were looked at.
    pub found: f64,
    /// What the truth may be wrong by itself, as far as samples say; a part of the error.
    pub estimate: f64,
    /// The same with all the opacity that bounds leave open; no part of the error.
    pub open: f64,
    /// Pixels that were looked at, and in how many of them it is proven that the truth has overlooked nothing.
    pub pixels: [usize; 2],
    /// Milliseconds of the whole picture on the device.
    pub ms: f64,
}

/// What was picked.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The scene, drawn with the settings that were picked.
    pub scene: Scene,
    /// Those settings in words.
    pub settings: String,
    /// What was found of the whole picture.
    pub verified: Verified,
    /// Why that is not by the reference, where there is none.
    pub unverified: Option<String>,
    /// Candidates that were left out beforehand, that were drawn, and that kept the bound; and methods that were not tried,
    /// since something kept the bound and time was up.
    pub counts: [usize; 4],
    /// The fastest settings of another pass that should keep the bound: in words, and how many times longer they should
    /// take.
    pub other: Option<(String, f64)>,
    /// Candidates that could not be drawn.
    pub failures: Vec<Failure>,
    /// Whether it is remembered from an earlier time.
    pub remembered: bool,
    /// The whole picture, where it was drawn for this.
    pub picture: Option<Frame>,
}

/// Why nothing was picked.
#[derive(Debug, thiserror::Error)]
pub enum PickError {
    /// No error that a picture can have.
    #[error("a largest error of {0}: it must be above 0, such as 1e-3")]
    Value(f64),
    /// The scene cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// No settings draw it.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Nobody waits for it any more.
    #[error("stopped")]
    Stopped,
    /// Nothing is that accurate.
    #[error(
        "no settings draw this scene with a {metric} error of {asked:e}: the nearest, {nearest}, has {}; {}try another `--metric`",
        known(*found, *own),
        allow.map(|error| format!("{error:e} can be kept: allow that, or ")).unwrap_or_default()
    )]
    Bound {
        /// How it is measured.
        metric: Metric,
        /// What was asked for.
        asked: f64,
        /// The nearest settings in words.
        nearest: String,
        /// What the truth may be wrong by itself; a part of the error.
        own: f64,
        /// Its error, or what that is below.
        found: f64,
        /// An error that can be kept: it was tried.
        allow: Option<f64>,
    },
}

/// An error, and how much of it is that of the truth, where that is much.
fn known(error: f64, own: f64) -> String {
    match own > 0.1 * error {
        true => format!("{:.1e}, of which the truth may be wrong by {own:.1e} itself", rounded_up(error)),
        false => format!("{:.1e}", rounded_up(error)),
    }
}
