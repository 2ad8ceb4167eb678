//! Samplers.

use super::{Gpu, GpuError, Named};
use ash::vk;

/// Continuation of an image outside of [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Address {
    /// The border texel.
    Clamp,
    /// Repetition.
    Repeat,
    /// Repetition, mirrored every second time.
    Mirror,
}

/// A sampler with linear filtering, or of the nearest texel.
pub struct Sampler {
    gpu: Gpu,
    pub(super) handle: vk::Sampler,
}

impl Sampler {
    /// Creates a linear sampler; an `anisotropy` of 1 is off.
    ///
    /// # Errors
    /// The device does not support the anisotropy.
    pub fn new(gpu: &Gpu, address: Address, anisotropy: f32) -> Result<Sampler, GpuError> {
        let info = gpu.info();
        if anisotropy > info.max_anisotropy {
            return Err(GpuError::Unsupported {
                device: info.name.clone(),
                what: format!("anisotropy {anisotropy}"),
                remedy: format!("use quality.anisotropy = 1 to {}", info.max_anisotropy),
            });
        }
        Sampler::of(gpu, address, anisotropy, vk::Filter::LINEAR, vk::SamplerMipmapMode::LINEAR)
    }

    /// Creates a sampler of the nearest texel, which every format supports.
    ///
    /// # Errors
    /// Memory is exhausted.
    pub fn nearest(gpu: &Gpu, address: Address) -> Result<Sampler, GpuError> {
        Sampler::of(gpu, address, 1.0, vk::Filter::NEAREST, vk::SamplerMipmapMode::NEAREST)
    }

    fn of(
        gpu: &Gpu,
        address: Address,
        anisotropy: f32,
        filter: vk::Filter,
        levels: vk::SamplerMipmapMode,
    ) -> Result<Sampler, GpuError> {
        let mode = match address {
            Address::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
            Address::Repeat => vk::SamplerAddressMode::REPEAT,
            Address::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
        };
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(filter)
            .min_filter(filter)
            .mipmap_mode(levels)
            .max_lod(vk::LOD_CLAMP_NONE)
            .address_mode_u(mode)
            .address_mode_v(mode)
            .address_mode_w(mode)
            .anisotropy_enable(anisotropy > 1.0)
            .max_anisotropy(anisotropy.max(1.0));
        // SAFETY: the device is alive, and its anisotropy was enabled where it has any.
        let handle = unsafe { gpu.0.device.create_sampler(&info, None) }.named("vkCreateSampler")?;
        Ok(Sampler { gpu: gpu.clone(), handle })
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: submissions that used the sampler were waited for; it is destroyed once.
        self.gpu.free(|device| unsafe { device.destroy_sampler(self.handle, None) });
    }
}
