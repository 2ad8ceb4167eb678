//! Images with their memory, and their uploads.

use super::memory::{allocate, release};
use super::{Area, Buffer, BufferUse, Format, Gpu, GpuError, Named};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Dimensions of an image in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Length of a 1D image.
    Line(u32),
    /// Width and height of a 2D image.
    Plane(u32, u32),
    /// Width, height and depth of a 3D image.
    Volume(u32, u32, u32),
}

impl Dimension {
    /// Texels along each axis.
    pub fn size(self) -> [u32; 3] {
        match self {
            Dimension::Line(x) => [x, 1, 1],
            Dimension::Plane(x, y) => [x, y, 1],
            Dimension::Volume(x, y, z) => [x, y, z],
        }
    }
}

/// Purpose of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageUse {
    /// Uploaded once, then sampled.
    Sampled,
    /// Drawn into and sampled in turns.
    SampledTarget,
    /// Blended into with this many samples per pixel, then read or resolved. With one sample also sampled.
    Target(u32),
    /// Depth attachment for marks of pixels.
    Depth,
}

/// An image in device memory with a view of the whole.
pub struct Image {
    gpu: Gpu,
    pub(super) handle: vk::Image,
    pub(super) view: vk::ImageView,
    allocation: Allocation,
    pub(super) extent: vk::Extent3D,
    /// Size of each mip level.
    pub(super) levels: Vec<vk::Extent3D>,
    layout: AtomicI32,
    format: Format,
    name: String,
}

impl Image {
    /// Creates an image without content.
    ///
    /// # Errors
    /// The image is larger than the device allows, or memory is exhausted.
    pub fn new(
        gpu: &Gpu,
        name: &str,
        dimension: Dimension,
        format: Format,
        purpose: ImageUse,
    ) -> Result<Image, GpuError> {
        Image::with_texels(gpu, name, dimension, format, purpose, 0)
    }

    /// Creates an image without content, with as many mip levels as `texels` texels fill.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub(crate) fn with_texels(
        gpu: &Gpu,
        name: &str,
        dimension: Dimension,
        format: Format,
        purpose: ImageUse,
        texels: u64,
    ) -> Result<Image, GpuError> {
        use vk::{ImageType as Type, ImageViewType as View};
        let info = gpu.info();
        let (kind, view_kind, limit) = match dimension {
            Dimension::Line(_) => (Type::TYPE_1D, View::TYPE_1D, info.max_line),
            Dimension::Plane(..) => (Type::TYPE_2D, View::TYPE_2D, info.max_image),
            Dimension::Volume(..) => (Type::TYPE_3D, View::TYPE_3D, info.max_volume),
        };
        let format = if purpose == ImageUse::Sampled { gpu.stored(format) } else { format };
        let size = dimension.size();
        Image::check(gpu, name, size, limit)?;
        let extent = vk::Extent3D { width: size[0], height: size[1], depth: size[2] };
        let levels = levels(extent, texels);
        let (usage, samples) = match purpose {
            ImageUse::Sampled => {
                let read = if cfg!(test) { vk::ImageUsageFlags::TRANSFER_SRC } else { Default::default() };
                (vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST | read, 1)
            }
            ImageUse::SampledTarget => (vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED, 1),
            ImageUse::Target(1) => {
                let drawn = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
                let is_stored = gpu.info().computes && Format::STORED.contains(&format);
                let stored = if is_stored { vk::ImageUsageFlags::STORAGE } else { Default::default() };
                (drawn | stored | vk::ImageUsageFlags::TRANSFER_SRC, 1)
            }
            ImageUse::Depth => (vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT, 1),
            ImageUse::Target(samples) => {
                (vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC, samples)
            }
        };
        let info = vk::ImageCreateInfo::default()
            .image_type(kind)
            .format(format.vk())
            .extent(extent)
            .mip_levels(levels.len() as u32)
            .array_layers(1)
            .samples(vk::SampleCountFlags::from_raw(samples))
            .usage(usage);
        let device = &gpu.0.device;
        // SAFETY: the device is alive; the new handle is owned before anything can fail.
        let handle = unsafe { device.create_image(&info, None) }.named("vkCreateImage")?;
        let mut image = Image {
            gpu: gpu.clone(),
            handle,
            view: vk::ImageView::null(),
            allocation: Allocation::default(),
            extent,
            levels,
            layout: AtomicI32::new(vk::ImageLayout::UNDEFINED.as_raw()),
            format,
            name: name.into(),
        };
        // SAFETY: the image belongs to the device.
        let requirements = unsafe { device.get_image_memory_requirements(handle) };
        image.allocation = allocate(gpu, name, requirements, MemoryLocation::GpuOnly, false)?;
        let info = vk::ImageViewCreateInfo::default()
            .image(handle)
            .view_type(view_kind)
            .format(format.vk())
            .subresource_range(format.range());
        // SAFETY: the memory was allocated for this image and is bound once, before the view is created.
        unsafe {
            device
                .bind_image_memory(handle, image.allocation.memory(), image.allocation.offset())
                .named("vkBindImageMemory")?;
            image.view = device.create_image_view(&info, None).named("vkCreateImageView")?;
        }
        Ok(image)
    }

    /// Creates a sampled image from texels: x fastest, then y, then z. Texels of mip levels may follow, each with half the size
    /// along every axis.
    ///
    /// # Errors
    /// The image is larger than the device allows, memory is exhausted, or the upload fails.
    ///
    /// # Panics
    /// If `texels` is not exactly as long as the image and its mip levels.
    pub fn sampled(
        gpu: &Gpu,
        name: &str,
        dimension: Dimension,
        format: Format,
        texels: &[u8],
    ) -> Result<Image, GpuError> {
        let (image, staging) = Image::staged(gpu, name, dimension, format, texels)?;
        gpu.submit("upload", |commands| commands.upload(&staging, &image))?;
        Ok(image)
    }

    /// Creates a sampled image, and a buffer of its texels for the copy.
    fn staged(
        gpu: &Gpu,
        name: &str,
        dimension: Dimension,
        format: Format,
        texels: &[u8],
    ) -> Result<(Image, Buffer), GpuError> {
        let stored = gpu.stored(format);
        let wide = (stored != format).then(|| format.widen(texels));
        let (format, texels) = (stored, wide.as_deref().unwrap_or(texels));
        let count = texels.len() as u64 / format.bytes();
        let image = Image::with_texels(gpu, name, dimension, format, ImageUse::Sampled, count)?;
        let bytes = image.levels.iter().map(|level| image.level_bytes(*level)).sum::<u64>();
        assert_eq!(texels.len() as u64, bytes, "`{name}`: texels and size agree");
        Ok((image, Buffer::new(gpu, "upload", BufferUse::Upload, texels)?))
    }

    /// Checks the size of an image against a limit of the device.
    pub(super) fn check(gpu: &Gpu, name: &str, size: [u32; 3], limit: u32) -> Result<(), GpuError> {
        if size.iter().all(|side| (1..=limit).contains(side)) {
            return Ok(());
        }
        let asked = format!("{} x {} x {} texels", size[0], size[1], size[2]);
        let (device, limit) = (gpu.info().name.clone(), format!("1 to {limit} for each axis"));
        Err(GpuError::TooLarge { device, what: name.into(), asked, limit })
    }

    /// Reads the texels of a single-sampled target, row by row.
    ///
    /// # Errors
    /// Memory is exhausted, or the download fails.
    pub fn read(&self) -> Result<Vec<[f32; 4]>, GpuError> {
        self.read_areas(&[Area::whole([self.extent.width, self.extent.height])], &mut None)
    }

    /// Reads the texels of areas of a target one after another, each row by row, through a `buffer` that is made if it is
    /// missing or too small: devices take milliseconds to allocate one.
    ///
    /// # Errors
    /// Those of [`Image::read`].
    ///
    /// # Panics
    /// If an area is empty or exceeds the image.
    pub(crate) fn read_areas(&self, areas: &[Area], buffer: &mut Option<Buffer>) -> Result<Vec<[f32; 4]>, GpuError> {
        let vk::Extent3D { width, height, .. } = self.extent;
        let within = |area: &Area| area.pixels() > 0 && area.columns.end <= width && area.rows.end <= height;
        assert!(areas.iter().all(within), "{areas:?} of {width} x {height}");
        let bytes = areas.iter().map(Area::pixels).sum::<u64>() * self.format.bytes();
        let buffer = match buffer {
            Some(made) if made.bytes() >= bytes => made,
            _ => buffer.insert(Buffer::empty(&self.gpu, "download", BufferUse::Download, bytes)?),
        };
        self.gpu.submit("download", |commands| commands.download(self, areas, buffer))?;
        Ok(self.format.decode(&buffer.content()[..bytes as usize]))
    }

    /// Passes the texels of a single-sampled target, row by row, to a function without a copy.
    ///
    /// # Errors
    /// Those of [`Image::read`].
    ///
    /// # Panics
    /// If its format is not [`Format::Rgba32Float`].
    pub fn read_with<T>(&self, take: impl FnOnce(&[[f32; 4]]) -> T) -> Result<T, GpuError> {
        assert_eq!(self.format, Format::Rgba32Float);
        let (all, bytes) = (Area::whole([self.extent.width, self.extent.height]), self.level_bytes(self.extent));
        let buffer = Buffer::empty(&self.gpu, "download", BufferUse::Download, bytes)?;
        self.gpu.submit("download", |commands| commands.download(self, &[all], &buffer))?;
        Ok(take(bytemuck::cast_slice(buffer.content())))
    }

    /// Reads the texels of all mip levels of a sampled image, in the order of an upload.
    #[cfg(test)]
    pub(crate) fn read_levels(&self) -> Result<Vec<u8>, GpuError> {
        let bytes = self.levels.iter().map(|level| self.level_bytes(*level)).sum();
        let buffer = Buffer::empty(&self.gpu, "download", BufferUse::Download, bytes)?;
        self.gpu.submit("download", |commands| commands.download_levels(self, &buffer))?;
        Ok(buffer.content().to_vec())
    }

    /// Records the layout after new commands, and returns the previous one.
    pub(super) fn set_layout(&self, layout: vk::ImageLayout) -> vk::ImageLayout {
        vk::ImageLayout::from_raw(self.layout.swap(layout.as_raw(), Ordering::Relaxed))
    }

    /// Bytes of device memory.
    pub fn bytes(&self) -> u64 {
        self.allocation.size()
    }

    /// Texels along each axis.
    pub fn size(&self) -> [u32; 3] {
        [self.extent.width, self.extent.height, self.extent.depth]
    }

    /// Texel format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Name for errors.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of a mip level.
    pub(super) fn level_bytes(&self, level: vk::Extent3D) -> u64 {
        texels(level) * self.format.bytes()
    }
}

fn texels(vk::Extent3D { width, height, depth }: vk::Extent3D) -> u64 {
    u64::from(width) * u64::from(height) * u64::from(depth)
}

/// Sizes of the mip levels that `filled` texels fill, the image itself first.
fn levels(extent: vk::Extent3D, filled: u64) -> Vec<vk::Extent3D> {
    let (mut levels, mut last, mut count) = (vec![extent], extent, texels(extent));
    while count < filled && texels(last) > 1 {
        let [width, height, depth] = [last.width, last.height, last.depth].map(|side| (side / 2).max(1));
        last = vk::Extent3D { width, height, depth };
        count += texels(last);
        levels.push(last);
    }
    levels
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: submissions with the image have finished; view and image are destroyed once, in this order, and a null view
        // is ignored.
        self.gpu.free(|device| unsafe {
            device.destroy_image_view(self.view, None);
            device.destroy_image(self.handle, None);
        });
        release(&self.gpu, &mut self.allocation);
    }
}

/// Queue of uploads for a later submission or the commands of a host. Clones share it.
#[derive(Clone, Default)]
pub struct Uploads(Arc<Mutex<Vec<Upload>>>);

/// Texels and their image.
pub(super) struct Upload {
    pub(super) texels: Buffer,
    pub(super) image: Arc<Image>,
}

impl Uploads {
    /// Creates a sampled image as [`Image::sampled`] does, and queues the copy.
    ///
    /// # Errors
    /// The image is larger than the device allows, or memory is exhausted.
    ///
    /// # Panics
    /// Those of [`Image::sampled`].
    pub fn image(
        &self,
        gpu: &Gpu,
        name: &str,
        dimension: Dimension,
        format: Format,
        texels: &[u8],
    ) -> Result<Arc<Image>, GpuError> {
        let (image, texels) = Image::staged(gpu, name, dimension, format, texels)?;
        let image = Arc::new(image);
        self.all().push(Upload { texels, image: image.clone() });
        Ok(image)
    }

    /// Submits the queued copies, if any, and waits for them.
    ///
    /// # Errors
    /// The submission fails.
    pub fn submit(&self, gpu: &Gpu) -> Result<(), GpuError> {
        let mut all = self.all();
        if !all.is_empty() {
            gpu.submit("upload", |commands| all.iter().for_each(|own| commands.upload(&own.texels, &own.image)))?;
            all.clear();
        }
        Ok(())
    }

    /// The queued uploads.
    pub(super) fn all(&self) -> MutexGuard<'_, Vec<Upload>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
