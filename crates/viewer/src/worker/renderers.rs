//! What a variant is drawn with.

use super::background_renderer::BackgroundRenderer;
use super::job::Variant;
use crate::progressive::{Level, PREVIEW_BLOCK};
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::{Variant as Program, VariantError};
use hypertexture::render::{Renderer, ViewPose};
use hypertexture::scene::{Pass, Scene};
use hypertexture::shader::Library;

/// Scenes of one object for which a renderer keeps what it has made: that of the person, and a preview of it that is drawn
/// by the other pass or reads smaller blocks of noise.
const KEPT: usize = 2;

/// What a variant is drawn with: each renderer keeps what it has made.
pub(super) struct VariantRenderers {
    /// Draws previews and the scene's own picture.
    pub(super) own: Renderer,
    /// Draws the pictures of which the converged one is the mean.
    pub(super) mean: BackgroundRenderer,
    /// Tries the other pass, while it is tried.
    pub(super) trial: Option<BackgroundRenderer>,
    /// The pass that draws previews faster, where that was measured, and the scene's own.
    pub(super) faster: Option<[Pass; 2]>,
}

impl VariantRenderers {
    pub(super) fn new(gpu: &Gpu, variant: &Variant) -> VariantRenderers {
        let renderer = || Renderer::new(gpu, &variant.library, &variant.subject);
        let mut own = renderer();
        own.set_cache_size(KEPT);
        VariantRenderers { own, mean: BackgroundRenderer::new(renderer()), trial: None, faster: None }
    }

    /// The preview of a scene, by the pass that draws it faster.
    pub(super) fn preview(&self, scene: &Scene, level: Level) -> Scene {
        let has_blocks = scene.quality.block_size <= PREVIEW_BLOCK || self.own.is_prepared(scene);
        let mut preview = level.scene(scene, has_blocks);
        if let Some([faster, own]) = self.faster
            && own == scene.quality.pass
        {
            preview.quality.pass = faster;
        }
        preview
    }
}

/// Where a variant is looked at from.
pub(crate) fn sight(variant: &Variant) -> Result<ViewPose, VariantError> {
    Ok(ViewPose::of(&variant.scene, &variant.subject, &Program::of(&variant.scene, &variant.library)?))
}

/// A scene drawn by the other pass, where that can be.
pub(super) fn with_other_pass(scene: &Scene, library: &Library) -> Option<Scene> {
    let mut other = scene.clone();
    other.quality.pass = match scene.quality.pass {
        Pass::Slices => Pass::March,
        Pass::March => Pass::Slices,
    };
    (!scene.camera.slice_stack && other.check(library).is_ok()).then_some(other)
}
