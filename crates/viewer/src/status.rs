//! What the window knows about its picture.

/// How good the picture on the screen is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Stage {
    /// There is none yet.
    #[default]
    None,
    /// Fewer pixels and samples than the scene asks for, in time for the next one.
    Coarse,
    /// On the way from there to the next: some rows are of that already.
    Partial,
    /// What `render` makes of the scene, in the size of the window.
    Scene,
    /// The mean of so many pictures, each with its own place in the pixels and phase.
    Refined(u32),
    /// As good as was asked for.
    Converged(u32),
    /// In place of a converged one: which pixels of the scene's own are not to be trusted.
    Validity,
}

/// What the window knows about its picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Figures {
    /// Device and driver.
    pub(super) device: String,
    /// How good the picture is.
    pub(super) stage: Stage,
    /// Its width and height in pixels.
    pub(super) size: [u32; 2],
    /// Samples of its rays.
    pub(super) samples: u32,
    /// Milliseconds on the device.
    pub(super) gpu_ms: f64,
    /// Whether the device is the CPU.
    pub(super) is_cpu: bool,
    /// Milliseconds that a picture may take while the scene moves.
    pub(super) budget_ms: f64,
    /// Root mean square difference from the converged image, about; linear light, all channels.
    pub(super) error: Option<f64>,
    /// Standard error of a value of the mean, root mean square: that of independent pictures, so it is an upper bound.
    pub(super) standard_error: Option<f64>,
    /// The difference of two variants that are as finely sampled, root mean square.
    pub(super) difference: Option<f64>,
    /// Milliseconds of the last coarse pictures, the newest last.
    pub(super) recent_ms: Vec<f64>,
    /// Frames of the recording, finished and in all.
    pub(super) recording: Option<(u32, u32)>,
    /// What the colors of pixels that are not to be trusted mean; empty where the picture is shown.
    pub(super) validity: Vec<([u8; 3], String)>,
    /// How much of the search for a way to draw is done, 0 to 1.
    pub(super) picking: Option<f32>,
    /// Fields of the scene that change nothing in the picture.
    pub(super) ignored: Vec<String>,
    /// What the picture was made with.
    pub(super) made: Vec<[String; 2]>,
}

impl Figures {
    /// What is on the screen, and how far it is from a picture whose error is at most `max_error`: the error of a mean falls
    /// with the square root of its pictures.
    pub(super) fn words(&self, max_error: f64) -> String {
        let done = self.error.map(|error| ((max_error / error).powi(2) * 100.0).clamp(0.0, 99.0));
        match self.stage {
            Stage::None => "no picture yet".into(),
            Stage::Coarse => "preview".into(),
            Stage::Partial => "drawing".into(),
            Stage::Scene => "drawn, converging".into(),
            Stage::Refined(count) => match done {
                Some(done) => format!("converging, {done:.0} %"),
                None => format!("converging, picture {count}"),
            },
            Stage::Converged(_) => "converged".into(),
            Stage::Validity => "validity: colored pixels are not to be trusted".into(),
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
