//! Renderers of a variant.

use super::background_renderer::BackgroundRenderer;
use super::job::LoadedScene;
use super::progressive::{Level, PREVIEW_BLOCK};
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::{Variant, VariantError};
use hypertexture::render::{Renderer, ViewPose};
use hypertexture::scene::{Pass, Scene};
use hypertexture::shader::Library;

/// Number of prepared scenes per renderer: the scene, and its preview, which may use the other pass or smaller noise
/// blocks.
const CACHED_SCENES: usize = 2;

/// Renderers of a variant, each with its own cache.
pub(super) struct VariantRenderers {
    /// Draws previews and the scene's own picture.
    pub(super) own: Renderer,
    /// Draws sub-frames.
    pub(super) mean: BackgroundRenderer,
    /// Draws previews of the other pass while it is timed.
    pub(super) trial: Option<BackgroundRenderer>,
    /// The faster pass for previews, if measured, and the scene's own pass.
    pub(super) faster: Option<[Pass; 2]>,
}

impl VariantRenderers {
    pub(super) fn new(gpu: &Gpu, variant: &LoadedScene) -> VariantRenderers {
        let renderer = || Renderer::new(gpu, &variant.library, &variant.subject);
        let mut own = renderer();
        own.set_cache_size(CACHED_SCENES);
        VariantRenderers { own, mean: BackgroundRenderer::new(renderer()), trial: None, faster: None }
    }

    /// The preview of a scene, by the faster pass.
    pub(super) fn preview(&self, scene: &Scene, level: Level) -> Scene {
        self.by_faster_pass(scene, level.scene(scene, self.has_blocks(scene)))
    }

    /// The picture of a scene during a stroke, by the faster pass.
    pub(super) fn stroke_preview(&self, scene: &Scene, level: Level) -> Scene {
        self.by_faster_pass(scene, level.stroke_scene(scene, self.has_blocks(scene)))
    }

    /// Whether the noise blocks of a scene are small or baked.
    fn has_blocks(&self, scene: &Scene) -> bool {
        scene.quality.block_size <= PREVIEW_BLOCK || self.own.is_prepared(scene)
    }

    fn by_faster_pass(&self, scene: &Scene, mut preview: Scene) -> Scene {
        if let Some([faster, own]) = self.faster
            && own == scene.quality.pass
        {
            preview.quality.pass = faster;
        }
        preview
    }
}

/// View of a variant.
pub(crate) fn pose_of(variant: &LoadedScene) -> Result<ViewPose, VariantError> {
    Ok(ViewPose::of(&Variant::of(&variant.scene, &variant.library)?, &variant.subject))
}

/// The scene with the other pass, if that is valid.
pub(super) fn with_other_pass(scene: &Scene, library: &Library) -> Option<Scene> {
    let mut other = scene.clone();
    other.quality.pass = match scene.quality.pass {
        Pass::Slices => Pass::March,
        Pass::March => Pass::Slices,
    };
    (!scene.camera.slice_stack && other.check(library).is_ok()).then_some(other)
}
