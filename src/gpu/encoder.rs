//! Pictures as textures of a window, encoded on the device.

use super::bind_set::{Binding, BindingKind, Resource};
use super::canvas::words;
use super::pipeline::Pipeline;
use super::sampler::{Address, Sampler};
use super::{Area, Buffer, BufferUse, Dimension, Format, Gpu, GpuError, Image, ImageUse};
use std::sync::Arc;

/// Encodes pictures as `encode.comp` says.
pub struct Encoder {
    gpu: Gpu,
    pipeline: Pipeline,
    sampler: Arc<Sampler>,
}

impl Encoder {
    /// Compiles the program.
    ///
    /// # Errors
    /// Memory is exhausted.
    pub fn new(gpu: &Gpu) -> Result<Encoder, GpuError> {
        let kinds = [BindingKind::Image, BindingKind::Sampler, BindingKind::Uniform, BindingKind::Storage];
        let bindings: Vec<Binding> =
            (0..).zip(kinds).map(|(index, kind)| Binding { index, kind, vertex: false, fragment: false }).collect();
        let code = words(include_bytes!(concat!(env!("OUT_DIR"), "/encode.comp")));
        let pipeline = Pipeline::compute(gpu, &code, &[], &bindings)?;
        Ok(Encoder { gpu: gpu.clone(), pipeline, sampler: Arc::new(Sampler::new(gpu, Address::Clamp, 1.0)?) })
    }

    /// Encodes a picture of linear premultiplied colors over both gray levels of a checkerboard, each linear with its code,
    /// or over a background that is given twice.
    ///
    /// # Errors
    /// Memory is exhausted, or the submission fails.
    pub fn encode(&self, picture: &Arc<Image>, behind: [[f32; 4]; 2]) -> Result<Arc<Image>, GpuError> {
        let ([width, height, _], gpu) = (picture.size(), &self.gpu);
        let plane = Dimension::Plane(width, height);
        let image = Arc::new(Image::new(gpu, "encoded picture", plane, Format::Rgba8Unorm, ImageUse::Target(1))?);
        let behind = Buffer::new(gpu, "backgrounds", BufferUse::Uniform, bytemuck::cast_slice(&behind))?;
        let set = self.pipeline.bind(&[
            (0, Resource::Image(picture.clone())),
            (1, Resource::Sampler(self.sampler.clone())),
            (2, Resource::Uniform(Arc::new(behind))),
            (3, Resource::Storage(image.clone())),
        ])?;
        gpu.submit("encoding", |commands| {
            commands.sample(picture);
            commands.dispatch(&self.pipeline, &set, &image, &[Area::whole([width, height])]);
            commands.sample(&image);
        })?;
        Ok(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Options;
    use hypertexture_support::random::SplitMix;
    use hypertexture_support::validation_lock::ValidationLock;

    /// sRGB code of linear light (IEC 61966-2-1).
    fn code(linear: f32) -> f32 {
        let held = linear.clamp(0.0, 1.0);
        if held <= 0.003_130_8 { 12.92 * held } else { 1.055 * held.powf(1.0 / 2.4) - 0.055 }
    }

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn codes_blend_over_what_is_behind_as_light_does() {
        let _lock = ValidationLock::acquire();
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        let mut random = SplitMix(5);
        let mut pixel = || {
            let alpha = random.unit() as f32;
            [(); 3].map(|()| random.unit() as f32 * alpha).into_iter().chain([alpha]).collect::<Vec<f32>>()
        };
        let pixels: Vec<f32> = (0..32 * 16).flat_map(|_| pixel()).collect();
        let (plane, texels) = (Dimension::Plane(32, 16), bytemuck::cast_slice(&pixels));
        let picture = Arc::new(Image::sampled(&gpu, "picture", plane, Format::Rgba32Float, texels).unwrap());
        let encoder = Encoder::new(&gpu).unwrap();
        let greys = [28.0, 42.0f32].map(|grey| ([((grey / 255.0 + 0.055) / 1.055).powf(2.4); 3], grey / 255.0));
        let with = |([r, g, b], code): ([f32; 3], f32)| [r, g, b, code];
        let red = with(([0.6, 0.0, 0.1], 0.0));
        for (behind, tolerance) in [(greys.map(with), 5.0 / 255.0), ([red; 2], 0.6 / 255.0)] {
            let made = encoder.encode(&picture, behind).unwrap().read().unwrap();
            for (own, made) in pixels.as_chunks::<4>().0.iter().zip(made) {
                for [r, g, b, grey] in behind {
                    for (c, behind) in [r, g, b].into_iter().enumerate() {
                        let apart = made[c] + (1.0 - made[3]) * grey - code(own[c] + (1.0 - own[3]) * behind);
                        assert!(apart.abs() < tolerance, "{own:?} over {behind}: {made:?}");
                    }
                }
            }
        }
    }
}
