//! The state of a lesson.

use super::strategies::Strategies;
use super::study::Study;
use crate::background::Notify;
use crate::worker::LoadedScene;
use egui::TextureHandle;
use hypertexture::gpu::Gpu;
use hypertexture::scene::{Jitter, Quality};

/// The subject of a lesson.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Page {
    /// Slices and samples (MJ 3).
    #[default]
    Samples,
    /// Soft region, bias, gain and DMFs (PH 2).
    Density,
    /// Octaves, and where they come from (MJ 4).
    Turbulence,
}

/// A lesson.
#[derive(Default)]
pub(crate) struct Lesson {
    pub(crate) is_open: bool,
    pub(super) page: Page,
    /// The settings from before the picture was held as drawn, while it is.
    pub(super) held: Option<Quality>,
    pub(super) study: Study,
    pub(super) strategies: Strategies,
    /// Pictures of the measured ways.
    pub(super) textures: Vec<TextureHandle>,
    gpu: Option<Gpu>,
}

impl Lesson {
    /// Whether the picture is held as it is drawn, without refinement.
    pub(crate) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Whether ways to get turbulence are being measured.
    pub(crate) fn is_measuring(&self) -> bool {
        self.strategies.running.is_some()
    }

    /// Uses a device, or leaves it.
    pub(crate) fn use_device(&mut self, gpu: Option<&Gpu>) {
        (self.gpu, self.strategies.running) = (gpu.cloned(), None);
    }

    /// Holds the picture as drawn, or refines it again: changes `quality` accordingly.
    pub(super) fn set_held(&mut self, on: bool, quality: &mut Quality) {
        if on {
            self.held.get_or_insert_with(|| quality.clone());
            (quality.supersampling, quality.msaa, quality.jitter) = (1, 1, Jitter::None);
        } else if let Some(held) = self.held.take() {
            (quality.supersampling, quality.msaa, quality.jitter) = (held.supersampling, held.msaa, held.jitter);
        }
    }

    /// Measures the ways to get turbulence.
    pub(super) fn measure(&mut self, variant: &LoadedScene, notify: &Notify) {
        self.textures.clear();
        if let Some(gpu) = &self.gpu {
            self.strategies.start(gpu, variant, notify);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_picture_has_single_rays_and_gives_its_settings_back() {
        let (mut lesson, mut quality) = (Lesson::default(), Quality { supersampling: 16, ..Quality::default() });
        quality.jitter = Jitter::Blue;
        let before = quality.clone();
        lesson.set_held(true, &mut quality);
        assert!(lesson.is_held() && (quality.supersampling, quality.jitter) == (1, Jitter::None));
        lesson.set_held(true, &mut quality);
        quality.samples = 7;
        lesson.set_held(false, &mut quality);
        assert_eq!(quality, Quality { samples: 7, ..before });
        assert!(!lesson.is_held());
    }
}
