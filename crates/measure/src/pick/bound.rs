//! Bounds of an error, and results of a pick.

use crate::compare::{CompareError, Failure};
use crate::metric::Metric;
use crate::statistics::rounded_up;
use hypertexture::render::{Frame, RenderError};
use hypertexture::scene::Scene;
use serde::{Deserialize, Serialize};

/// Largest error of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBound {
    /// Metric of the error.
    pub metric: Metric,
    /// The largest error, above 0.
    pub error: f64,
}

impl Verified {
    /// Upper bound of the error with all the opacity that bounds of the reference leave open.
    pub fn by_proof(&self) -> f64 {
        self.error - self.estimate + self.open
    }
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

/// Error of a whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verified {
    /// Upper bound of the error, with a confidence of 99.999 % in the choice of pixels; the estimated error of the reference is added.
    pub error: f64,
    /// Error estimated from the compared pixels.
    pub found: f64,
    /// Estimated error of the reference; a part of the error.
    pub estimate: f64,
    /// Error of the reference with all the opacity that its bounds leave open; not a part of the error.
    pub open: f64,
    /// Compared pixels, and those with a proof that the reference overlooks nothing.
    pub pixels: [usize; 2],
    /// Milliseconds on the device.
    pub ms: f64,
}

/// A pick.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The scene with the picked settings.
    pub scene: Scene,
    /// The settings in words.
    pub settings: String,
    /// Error of the whole picture.
    pub verified: Verified,
    /// Reason for a comparison with a finer picture in place of a reference.
    pub unverified: Option<String>,
    /// Candidates excluded by their bound, drawn ones, fitting ones; and methods left out for lack of time.
    pub counts: [usize; 4],
    /// Fastest fitting settings of another pass in words, and their time in parts of the pick's.
    pub other: Option<(String, f64)>,
    /// Candidates that failed.
    pub failures: Vec<Failure>,
    /// Whether it comes from the cache.
    pub remembered: bool,
    /// The whole picture, unless cached.
    pub picture: Option<Frame>,
}

/// Errors of a pick.
#[derive(Debug, thiserror::Error)]
pub enum PickError {
    /// A bound that is not above 0.
    #[error("a largest error of {0}: it must be above 0, such as 1e-3")]
    Value(f64),
    /// The scene cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The candidates cannot be made.
    #[error(transparent)]
    Compare(CompareError),
    /// Every candidate is refused.
    #[error(
        "no settings are left to draw this scene with: each pass and integration is refused; draw it without a largest error to read why"
    )]
    Nothing,
    /// Stopped by the caller.
    #[error("stopped")]
    Stopped,
    /// No candidate is that accurate.
    #[error(
        "no settings draw this scene with a {metric} error of {asked:e}: the nearest, {nearest}, has {}{}; {}try another `--metric`",
        known(*found, *own),
        compared.map(|[some, all]| format!(" in the {some} of {all} pixels compared")).unwrap_or_default(),
        allow.map(|allow| allow.advice(compared.is_some())).unwrap_or_default()
    )]
    Bound {
        /// Metric of the error.
        metric: Metric,
        /// Requested bound.
        asked: f64,
        /// The nearest settings in words.
        nearest: String,
        /// Estimated error of the reference; a part of `found`.
        own: f64,
        /// Error of the nearest, or an upper bound of it.
        found: f64,
        /// Compared pixels and all, where it is an estimate from these.
        compared: Option<[usize; 2]>,
        /// A bound that was tried and kept.
        allow: Option<Kept>,
    },
}

/// A bound that a pick keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept {
    /// The bound.
    pub error: f64,
    /// Error of the pick with all the opacity that bounds of the reference leave open.
    pub by_proof: f64,
}

impl Kept {
    /// The end of a refusal; `all`: the error that was refused is one of some pixels.
    fn advice(self, all: bool) -> String {
        let Kept { error, by_proof } = self;
        let all = if all { ", which holds for all of them" } else { "" };
        let open = if by_proof > error {
            format!(", as far as samples see ({:.1e} with all that bounds leave open)", rounded_up(by_proof))
        } else {
            String::new()
        };
        format!("{error:e} can be kept: allow that{all}{open}, or ")
    }
}

impl From<CompareError> for PickError {
    fn from(error: CompareError) -> PickError {
        match error {
            CompareError::Nothing => PickError::Nothing,
            CompareError::Render(error) => PickError::Render(error),
            other => PickError::Compare(other),
        }
    }
}

/// An error, with the share of the reference if that is above a tenth.
fn known(error: f64, own: f64) -> String {
    if own > 0.1 * error {
        format!("{:.1e}, of which the truth may be wrong by {own:.1e} itself", rounded_up(error))
    } else {
        format!("{:.1e}", rounded_up(error))
    }
}
