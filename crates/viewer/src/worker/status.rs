//! Status of the picture.

/// Costs of the scene's own picture of a variant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    /// Time on the device, milliseconds.
    pub(crate) ms: f64,
    /// Root mean square error against the mean, linear light, once that has enough sub-frames.
    pub(crate) rmse: Option<f64>,
}

/// Stage of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Stage {
    /// No picture.
    #[default]
    None,
    /// A preview with fewer pixels and samples.
    Coarse,
    /// A mixture of a preview and the scene's own picture.
    Partial,
    /// The scene's own picture, as `render` makes it in the size of the window.
    Scene,
    /// The mean of this many sub-frames.
    Refined(u32),
    /// A mean within the error target.
    Converged(u32),
    /// The validity of the pixels.
    Validity,
}

/// Status of the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Figures {
    /// Device and driver.
    pub(crate) device: String,
    /// Stage of the picture.
    pub(crate) stage: Stage,
    /// Part of an unfinished picture that is drawn, 0 to 1.
    pub(crate) done: f32,
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
    /// Samples of a ray.
    pub(crate) samples: u32,
    /// Time on the device, milliseconds.
    pub(crate) gpu_ms: f64,
    /// Whether the device is the CPU.
    pub(crate) is_cpu: bool,
    /// Time budget of a preview, milliseconds.
    pub(crate) budget_ms: f64,
    /// Estimated root mean square error, linear light, all channels.
    pub(crate) error: Option<f64>,
    /// Standard error of a value of the mean: an upper bound, as the sub-frames are not independent.
    pub(crate) standard_error: Option<f64>,
    /// Root mean square difference of two equally sampled variants.
    pub(crate) difference: Option<f64>,
    /// Costs of the own pictures of the variants.
    pub(crate) costs: Vec<Cost>,
    /// Times of the last previews, the newest last, milliseconds.
    pub(crate) recent_ms: Vec<f64>,
    /// Legend of the validity colors.
    pub(crate) validity: Vec<([u8; 3], String)>,
    /// Progress of the search for the fastest settings, 0 to 1.
    pub(crate) picking: Option<f32>,
    /// Fields of the scene without an effect on the picture.
    pub(crate) ignored: Vec<String>,
    /// The list of facts about the rendering.
    pub(crate) made: Vec<[String; 2]>,
}

impl Figures {
    /// Stage in words, with the progress towards `max_error`: the error of a mean falls with the square root of its
    /// pictures.
    pub(crate) fn words(&self, max_error: f64) -> String {
        let done = self.error.map(|error| ((max_error / error).powi(2) * 100.0).clamp(0.0, 99.0));
        match self.stage {
            Stage::None => "no picture yet".into(),
            Stage::Coarse => "preview".into(),
            Stage::Partial => format!("drawing, {:.0} %", (100.0 * self.done).floor()),
            Stage::Scene => "drawn, converging".into(),
            Stage::Refined(count) => match done {
                Some(done) => format!("converging, {done:.0} %"),
                None => format!("converging, picture {count}"),
            },
            Stage::Converged(_) => "converged".into(),
            Stage::Validity => "validity: colored pixels are invalid".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_error_takes_four_times_the_pictures() {
        let at = |error: f64| Figures { stage: Stage::Refined(8), error: Some(error), ..Figures::default() };
        assert_eq!(at(2e-3).words(1e-3), "converging, 25 %");
        assert_eq!(at(1e-4).words(1e-3), "converging, 99 %");
        assert_eq!(Figures { error: None, ..at(1.0) }.words(1e-3), "converging, picture 8");
        assert_eq!(Figures { stage: Stage::Converged(16), ..at(1e-3) }.words(1e-3), "converged");
    }
}
