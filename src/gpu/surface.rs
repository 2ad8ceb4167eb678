//! The device of a window, and its swapchain.

use super::device::Gpu;
use super::format::COLOR;
use super::instance::Instance;
use super::window::{WindowHandle, WindowSurface, handles};
use super::{GpuError, Named, Options};
use ash::{khr, vk};
use std::sync::Arc;

/// A device with the swapchain of a window.
pub(super) struct Surface {
    pub(super) gpu: Gpu,
    pub(super) swapchains: khr::swapchain::Device,
    pub(super) format: vk::SurfaceFormatKHR,
    swapchain: Option<Swapchain>,
}

/// A swapchain and its images.
pub(super) struct Swapchain {
    pub(super) handle: vk::SwapchainKHR,
    pub(super) extent: vk::Extent2D,
    pub(super) images: Vec<ChainImage>,
    /// Size of the window that it was created for.
    asked: [u32; 2],
}

/// An image of a swapchain.
#[derive(Clone, Copy)]
pub(super) struct ChainImage {
    pub(super) image: vk::Image,
    pub(super) view: vk::ImageView,
    /// Signaled when the image is drawn. One per image: it is free again when the image is acquired.
    pub(super) drawn: vk::Semaphore,
}

impl Surface {
    /// Opens a device that can draw into a window.
    pub(super) fn open(options: &Options, window: Arc<dyn WindowHandle>) -> Result<Surface, GpuError> {
        let (display, _) = handles(&Instance::loader()?, &*window)?;
        let extensions = ash_window::enumerate_required_extensions(display).named("the extensions of the display")?;
        let mut instance = Instance::new(options.validation, extensions)?;
        let surface = WindowSurface::new(&instance.entry, &instance.raw, window)?;
        let (functions, handle) = (surface.functions.clone(), surface.handle);
        instance.surface = Some(surface);
        let presents = |physical, family| {
            // SAFETY: device, family and surface belong to the same instance, which is alive.
            unsafe { functions.get_physical_device_surface_support(physical, family, handle) }.unwrap_or(false)
        };
        let gpu = match Gpu::with_instance(options, instance, &[khr::swapchain::NAME.as_ptr()], presents) {
            // The device exists but cannot present to this window.
            Err(GpuError::NoQueue { .. }) => return Err(GpuError::NoPresent),
            other => other?,
        };
        let swapchains = khr::swapchain::Device::new(&gpu.0.instance.raw, &gpu.0.device);
        let mut surface = Surface { gpu, swapchains, format: vk::SurfaceFormatKHR::default(), swapchain: None };
        surface.format = surface.choose_format()?;
        Ok(surface)
    }

    /// Surface functions, physical device and surface.
    fn parts(&self) -> Result<(&khr::surface::Instance, vk::PhysicalDevice, vk::SurfaceKHR), GpuError> {
        let surface = self.gpu.0.instance.surface.as_ref().ok_or(GpuError::NoPresent)?;
        Ok((&surface.functions, self.gpu.0.physical, surface.handle))
    }

    /// Chooses the format, preferably unorm: then sRGB codes are blended as in other programs.
    fn choose_format(&self) -> Result<vk::SurfaceFormatKHR, GpuError> {
        use vk::Format as F;
        let (functions, physical, surface) = self.parts()?;
        // SAFETY: device and surface belong to the same instance.
        let formats = unsafe { functions.get_physical_device_surface_formats(physical, surface) }
            .named("vkGetPhysicalDeviceSurfaceFormatsKHR")?;
        let wanted = [F::B8G8R8A8_UNORM, F::R8G8B8A8_UNORM, F::B8G8R8A8_SRGB, F::R8G8B8A8_SRGB];
        let find = |format: F| formats.iter().find(|found| found.format == format);
        wanted.into_iter().find_map(find).copied().ok_or(GpuError::NoPresent)
    }

    /// The swapchain for a window of this size; `None` if it has no pixels.
    pub(super) fn swapchain(&mut self, size: [u32; 2]) -> Result<Option<&Swapchain>, GpuError> {
        if size.contains(&0) {
            return Ok(None);
        }
        if self.swapchain.as_ref().is_none_or(|chain| chain.asked != size) {
            self.renew(size)?;
        }
        Ok(self.swapchain.as_ref())
    }

    /// Marks the swapchain for renewal at its next use.
    pub(super) fn outdated(&mut self) {
        if let Some(chain) = &mut self.swapchain {
            chain.asked = [0; 2];
        }
    }

    fn renew(&mut self, size: [u32; 2]) -> Result<(), GpuError> {
        let old = self.swapchain.take();
        let new = self.create(size, old.as_ref().map_or(vk::SwapchainKHR::null(), |chain| chain.handle));
        self.drop_swapchain(old);
        self.swapchain = new?;
        self.fill()
    }

    /// Creates a swapchain that replaces `old`, without its images.
    fn create(&self, size: [u32; 2], old: vk::SwapchainKHR) -> Result<Option<Swapchain>, GpuError> {
        let (functions, physical, surface) = self.parts()?;
        // SAFETY: device and surface belong to the same instance.
        let can = unsafe { functions.get_physical_device_surface_capabilities(physical, surface) }
            .named("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")?;
        let own = can.current_extent;
        let extent = match own.width {
            // The size of the surface follows the swapchain.
            u32::MAX => vk::Extent2D {
                width: size[0].clamp(can.min_image_extent.width, can.max_image_extent.width),
                height: size[1].clamp(can.min_image_extent.height, can.max_image_extent.height),
            },
            _ => own,
        };
        if extent.width == 0 || extent.height == 0 {
            return Ok(None);
        }
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface)
            .min_image_count((can.min_image_count + 1).min(most))
            .image_format(self.format.format)
            .image_color_space(self.format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT)
            .pre_transform(can.current_transform)
            .composite_alpha(vk::CompositeAlphaFlagsKHR::OPAQUE)
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old);
        // SAFETY: surface and old swapchain belong together; FIFO is always supported.
        let handle = unsafe { self.swapchains.create_swapchain(&info, None) }.named("vkCreateSwapchainKHR")?;
        Ok(Some(Swapchain { handle, asked: size, extent, images: Vec::new() }))
    }

    /// Creates views and semaphores of the images.
    fn fill(&mut self) -> Result<(), GpuError> {
        let Some(chain) = &mut self.swapchain else { return Ok(()) };
        let device = &self.gpu.0.device;
        // SAFETY: the swapchain is alive.
        let images = unsafe { self.swapchains.get_swapchain_images(chain.handle) }.named("vkGetSwapchainImagesKHR")?;
        for image in images {
            let info = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(self.format.format)
                .subresource_range(COLOR);
            chain.images.push(ChainImage { image, view: vk::ImageView::null(), drawn: vk::Semaphore::null() });
            let Some(own) = chain.images.last_mut() else { continue };
            // SAFETY: the image is one of the swapchain; each handle is owned as soon as it exists.
            unsafe {
                own.view = device.create_image_view(&info, None).named("vkCreateImageView")?;
                own.drawn = device.create_semaphore(&Default::default(), None).named("vkCreateSemaphore")?;
            }
        }
        Ok(())
    }

    fn drop_swapchain(&self, chain: Option<Swapchain>) {
        let Some(chain) = chain else { return };
        let _queue = self.gpu.queue();
        // SAFETY: the device is idle while its queue is locked; null is ignored.
        self.gpu.free(|device| unsafe {
            let _ = device.device_wait_idle();
            for shown in chain.images {
                device.destroy_semaphore(shown.drawn, None);
                device.destroy_image_view(shown.view, None);
            }
            self.swapchains.destroy_swapchain(chain.handle, None);
        });
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        let chain = self.swapchain.take();
        self.drop_swapchain(chain);
    }
}
