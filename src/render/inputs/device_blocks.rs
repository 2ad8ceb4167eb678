//! Noise blocks that the device makes, by the noise of `glsl/`.
//!
//! Invariant: a texel differs from that of [`NoiseTexels::encode`] by [`apart`] at most, since sums are rounded in another
//! order.

use super::noise_blocks::{NoiseTexels, Recipe};
use crate::field::Progress;
use crate::gpu::{BindSet, Binding, BindingKind, Buffer, BufferUse, Dimension, Gpu, GpuError, Image, ImageUse};
use crate::gpu::{Pipeline, Resource};
use crate::noise::{Bake, Weights};
use crate::render::texture::{Depth, block_scales};
use crate::render::variant::NoiseImage;
use crate::scene::Scene;
use std::sync::Arc;

/// Most invocations of a submission. Higher: a slow device is busy for longer than a desktop can wait.
const INVOCATIONS: u32 = 1 << 21;
/// Invocations of a group, and numbers that an invocation writes: see `glsl/block.comp`.
const GROUP: u32 = 64;
const NUMBERS: u32 = 4;
/// Bound of the difference of a number in [0, 1] before it is stored; lavapipe gives 9e-8.
const ROUNDING: f32 = 5e-7;

/// Largest difference of a texel of a scene's image between device and CPU; `None` if only the CPU makes it.
pub(crate) fn apart(scene: &Scene, image: NoiseImage) -> Option<f32> {
    let own = NoiseTexels::of(scene, image);
    own.recipe.bake().map(|_| match own.depth {
        Depth::Eight => 1.01 / 255.0,
        Depth::Sixteen => 1.01 / 65535.0,
        Depth::Float => ROUNDING,
    })
}

/// Makes a block of lattice noise on the device. `progress` receives the finished share.
///
/// # Errors
/// The image is larger than the device allows, memory is exhausted, or a submission fails.
pub(crate) fn block_image(gpu: &Gpu, own: &NoiseTexels, progress: Progress<'_>) -> Result<Image, GpuError> {
    let (name, format, channels) = (own.image.label(), own.format(), own.recipe.channels());
    let cube = |level: u32| u64::from((own.size >> level).max(1)).pow(3);
    let (volume, count) = (Dimension::Volume(own.size, own.size, own.size), (0..=own.faded).map(cube).sum());
    let image = Image::with_texels(gpu, name, volume, format, ImageUse::Sampled, count)?;
    let (bits, texels) = (8 * format.bytes() as u32 / channels, NUMBERS / channels);
    let most = (own.size.pow(3) / texels).min(INVOCATIONS);
    let words = Arc::new(Buffer::empty(gpu, name, BufferUse::Words, u64::from(most) * u64::from(NUMBERS * bits / 8))?);
    let mut made: Option<(Pipeline, BindSet)> = None;
    for level in 0..=own.faded {
        let (recipe, raised) = if level == 0 { (own.recipe, 0.0) } else { own.recipe.level(level) };
        let Some(bake) = recipe.bake() else { break };
        let (pipeline, set) = match &made {
            Some(made) => made,
            None => made.insert(program(gpu, &recipe, bake, bits, &words)?),
        };
        let (side, plane) = (bake.size, bake.size.pow(2));
        let at_once = (most * texels / plane).clamp(1, side);
        for first in (0..side).step_by(at_once as usize) {
            let planes = first..side.min(first + at_once);
            let invocations = (planes.len() as u32 * plane).div_ceil(texels);
            gpu.submit("noise block", |commands| {
                let constants = [side, bake.octaves, raised.to_bits(), first * plane / texels];
                commands.write_words(pipeline, set, constants, invocations.div_ceil(GROUP));
                commands.copy_planes(&words, &image, level, planes.clone());
            })?;
            progress(if level == 0 { planes.end as f32 / side as f32 } else { 1.0 });
        }
    }
    Ok(image)
}

/// The pipeline that writes words of a recipe's texels, and its inputs.
fn program(
    gpu: &Gpu,
    recipe: &Recipe,
    bake: &Bake,
    bits: u32,
    words: &Arc<Buffer>,
) -> Result<(Pipeline, BindSet), GpuError> {
    let code: &[u8] = match bake.weights {
        Weights::Cubic => include_bytes!(concat!(env!("OUT_DIR"), "/block_cubic.comp")),
        Weights::Quintic => include_bytes!(concat!(env!("OUT_DIR"), "/block_quintic.comp")),
    };
    let kind = match recipe {
        Recipe::Values(_) => 0,
        Recipe::Gradients(_) => 1,
        _ => 2,
    };
    let [scale, offset, slope] = block_scales(bake.absolute).map(f32::to_bits);
    let constants = [bake.cells, kind, bake.absolute.into(), bits, scale, offset, slope];
    let constants: Vec<(u32, u32)> = (1..).zip(constants).collect();
    let binding = [Binding { index: 0, kind: BindingKind::Words, vertex: false, fragment: false }];
    let pipeline = Pipeline::compute(gpu, &bytemuck::pod_collect_to_vec(code), &constants, &binding)?;
    let set = pipeline.bind(&[(0, Resource::Words(words.clone()))])?;
    Ok((pipeline, set))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Options;
    use crate::render::{Subject, render};
    use crate::scene::{BlockFormat, preset};
    use crate::shader;
    use hypertexture_support::validation_lock::ValidationLock;

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_block_of_the_device_is_that_of_the_processor() {
        let _lock = ValidationLock::acquire();
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        let mut scene = Scene::default();
        (scene.effect.bandlimit, scene.effect.octaves) = ("clamp".into(), 8);
        let images = [
            NoiseImage::Noise,
            NoiseImage::NoiseValues,
            NoiseImage::Turbulence,
            NoiseImage::TurbulenceValues,
            NoiseImage::Channels,
        ];
        for (weights, size) in [("quintic", 16), ("cubic", 64)] {
            (scene.effect.weights, scene.quality.block_size) = (weights.into(), size);
            for format in [BlockFormat::Unorm8, BlockFormat::Unorm16, BlockFormat::Float32] {
                scene.quality.block_format = format;
                for image in images {
                    let own = NoiseTexels::of(&scene, image);
                    let made = block_image(&gpu, &own, &|_| ()).unwrap().read_levels().unwrap();
                    let expected = own.encode(&|_| ()).bytes;
                    assert_eq!(made.len(), expected.len());
                    let [made, expected] = [made, expected].map(|bytes| own.format().decode(&bytes));
                    let all = made.as_flattened().iter().zip(expected.as_flattened());
                    let largest = all.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    assert!(largest <= apart(&scene, image).unwrap(), "{image:?} of {format:?}: {largest}");
                }
            }
        }
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn a_picture_of_blocks_of_the_device_is_that_of_the_processors() {
        let _lock = ValidationLock::acquire();
        let library = shader::shipped();
        let mut scene = preset("fire").unwrap();
        (scene.image.size, scene.effect.bandlimit, scene.object.input) = ([48, 48], "clamp".into(), "sphere".into());
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let [cpu, taken] = [false, true].map(|taken| {
            let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
            let gpu = if taken { gpu.taken_for_a_gpu() } else { gpu };
            render(&gpu, &library, &scene, &subject).unwrap().pixels
        });
        let all = cpu.as_flattened().iter().zip(taken.as_flattened());
        let largest = all.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(largest > 0.0 && largest < 1e-4, "{largest}");
    }
}
