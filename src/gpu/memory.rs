//! Buffers and images, each owning its memory.

use super::{Area, Format, Gpu, GpuError, Named};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use support::memory;

/// What a buffer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BufferUse {
    /// A uniform block.
    Uniform,
    /// Vertices.
    Vertices,
    /// The source of an upload.
    Upload,
    /// The destination of a download.
    Download,
}

/// A buffer that the host can write, or read back.
pub struct Buffer {
    gpu: Gpu,
    pub(super) handle: vk::Buffer,
    allocation: Allocation,
    bytes: u64,
}

impl Buffer {
    /// A buffer of `bytes` bytes, not yet written.
    pub(super) fn empty(gpu: &Gpu, name: &str, purpose: BufferUse, bytes: u64) -> Result<Buffer, GpuError> {
        let (usage, location) = match purpose {
            BufferUse::Uniform => (vk::BufferUsageFlags::UNIFORM_BUFFER, MemoryLocation::CpuToGpu),
            BufferUse::Vertices => (vk::BufferUsageFlags::VERTEX_BUFFER, MemoryLocation::CpuToGpu),
            BufferUse::Upload => (vk::BufferUsageFlags::TRANSFER_SRC, MemoryLocation::CpuToGpu),
            BufferUse::Download => (vk::BufferUsageFlags::TRANSFER_DST, MemoryLocation::GpuToCpu),
        };
        let device = &gpu.0.device;
        let info = vk::BufferCreateInfo::default().size(bytes.max(1)).usage(usage);
        // SAFETY: the device is alive; the new handle is owned before anything can fail.
        let handle = unsafe { device.create_buffer(&info, None) }.named("vkCreateBuffer")?;
        let mut buffer = Buffer { gpu: gpu.clone(), handle, allocation: Allocation::default(), bytes };
        // SAFETY: the buffer belongs to the device.
        let requirements = unsafe { device.get_buffer_memory_requirements(handle) };
        buffer.allocation = allocate(gpu, name, requirements, location, true)?;
        // SAFETY: the memory was allocated for this buffer and is bound once.
        unsafe { device.bind_buffer_memory(handle, buffer.allocation.memory(), buffer.allocation.offset()) }
            .named("vkBindBufferMemory")?;
        Ok(buffer)
    }

    /// A buffer with this content.
    ///
    /// # Errors
    /// Device memory is exhausted.
    pub fn new(gpu: &Gpu, name: &str, purpose: BufferUse, content: &[u8]) -> Result<Buffer, GpuError> {
        let mut buffer = Buffer::empty(gpu, name, purpose, content.len() as u64)?;
        let mapped = buffer.allocation.mapped_slice_mut().ok_or_else(|| GpuError::Memory {
            what: name.into(),
            bytes: content.len() as u64,
            reason: "its memory cannot be mapped".into(),
        })?;
        mapped[..content.len()].copy_from_slice(content);
        Ok(buffer)
    }

    /// The content, as the device left it at the end of a submission that made it visible to the host.
    pub(super) fn content(&self) -> &[u8] {
        self.allocation.mapped_slice().map(|slice| &slice[..self.bytes as usize]).unwrap_or_default()
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: submissions that used the buffer were waited for; it is destroyed once.
        self.gpu.free(|device| unsafe { device.destroy_buffer(self.handle, None) });
        release(&self.gpu, &mut self.allocation);
    }
}

/// Shape of an image, with its size in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// A row.
    Line(u32),
    /// Width and height.
    Plane(u32, u32),
    /// Width, height and depth.
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

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageUse {
    /// Uploaded once, then sampled.
    Sampled,
    /// Drawn into, then sampled, again and again.
    SampledTarget,
    /// Blended into, with this many samples per pixel, then read or resolved; of one sample, sampled between.
    Target(u32),
    /// Marks of pixels.
    Depth,
}

/// An image on the device with one view of all of it.
pub struct Image {
    gpu: Gpu,
    pub(super) handle: vk::Image,
    pub(super) view: vk::ImageView,
    allocation: Allocation,
    pub(super) extent: vk::Extent3D,
    /// Size of each level.
    pub(super) levels: Vec<vk::Extent3D>,
    layout: AtomicI32,
    format: Format,
    name: String,
}

impl Image {
    /// An image without content.
    ///
    /// # Errors
    /// Larger than the device allows, or no memory left.
    pub fn new(
        gpu: &Gpu,
        name: &str,
        dimension: Dimension,
        format: Format,
        purpose: ImageUse,
    ) -> Result<Image, GpuError> {
        Image::with_texels(gpu, name, dimension, format, purpose, 0)
    }

    /// An image without content, with as many levels as so many texels fill.
    fn with_texels(
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
            Dimension::Line(_) => (Type::TYPE_1D, View::TYPE_1D, info.max_image),
            Dimension::Plane(..) => (Type::TYPE_2D, View::TYPE_2D, info.max_image),
            Dimension::Volume(..) => (Type::TYPE_3D, View::TYPE_3D, info.max_volume),
        };
        let size = dimension.size();
        Image::check(gpu, name, size, limit)?;
        let extent = vk::Extent3D { width: size[0], height: size[1], depth: size[2] };
        let levels = levels(extent, texels);
        let (usage, samples) = match purpose {
            ImageUse::Sampled => (vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST, 1),
            ImageUse::SampledTarget => (vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED, 1),
            ImageUse::Target(1) => {
                let drawn = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
                (drawn | vk::ImageUsageFlags::TRANSFER_SRC, 1)
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
        // SAFETY: the memory was allocated for this image and is bound once, before the view is made.
        unsafe {
            device
                .bind_image_memory(handle, image.allocation.memory(), image.allocation.offset())
                .named("vkBindImageMemory")?;
            image.view = device.create_image_view(&info, None).named("vkCreateImageView")?;
        }
        Ok(image)
    }

    /// A sampled image with these texels, x fastest, then y, then z. Behind them those of ever coarser levels may follow,
    /// each with half as many along every axis.
    ///
    /// # Errors
    /// Larger than the device allows, no memory left, or the upload fails.
    ///
    /// # Panics
    /// When `texels` is not exactly as long as the image and its levels.
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

    /// The same, and the texels in a buffer that is still to be copied into it.
    fn staged(
        gpu: &Gpu,
        name: &str,
        dimension: Dimension,
        format: Format,
        texels: &[u8],
    ) -> Result<(Image, Buffer), GpuError> {
        let count = texels.len() as u64 / format.bytes();
        let image = Image::with_texels(gpu, name, dimension, format, ImageUse::Sampled, count)?;
        let bytes = image.levels.iter().map(|level| image.level_bytes(*level)).sum::<u64>();
        assert_eq!(texels.len() as u64, bytes, "`{name}`: texels and size agree");
        Ok((image, Buffer::new(gpu, "upload", BufferUse::Upload, texels)?))
    }

    /// Whether a device can have an image of a size.
    pub(super) fn check(gpu: &Gpu, name: &str, size: [u32; 3], limit: u32) -> Result<(), GpuError> {
        if size.iter().all(|side| (1..=limit).contains(side)) {
            return Ok(());
        }
        let asked = format!("{} x {} x {} texels", size[0], size[1], size[2]);
        let (device, limit) = (gpu.info().name.clone(), format!("1 to {limit} for each axis"));
        Err(GpuError::TooLarge { device, what: name.into(), asked, limit })
    }

    /// The texels of a single-sampled target, row by row.
    ///
    /// # Errors
    /// No memory left, or the download fails.
    pub fn read(&self) -> Result<Vec<[f32; 4]>, GpuError> {
        self.read_areas(&[Area::whole([self.extent.width, self.extent.height])])
    }

    /// The texels of areas of it, one behind the other, each row by row.
    ///
    /// # Errors
    /// As [`Image::read`].
    ///
    /// # Panics
    /// Where an area is not within the image, or empty.
    pub fn read_areas(&self, areas: &[Area]) -> Result<Vec<[f32; 4]>, GpuError> {
        let vk::Extent3D { width, height, .. } = self.extent;
        let within = |area: &Area| area.pixels() > 0 && area.columns.end <= width && area.rows.end <= height;
        assert!(areas.iter().all(within), "{areas:?} of {width} x {height}");
        Ok(self.format.decode(self.download(areas)?.content()))
    }

    /// What is made of the texels of a single-sampled target, row by row, where they are: without a copy.
    ///
    /// # Errors
    /// As [`Image::read`].
    ///
    /// # Panics
    /// Where its format is not [`Format::Rgba32Float`].
    pub fn read_with<T>(&self, take: impl FnOnce(&[[f32; 4]]) -> T) -> Result<T, GpuError> {
        assert_eq!(self.format, Format::Rgba32Float);
        let buffer = self.download(&[Area::whole([self.extent.width, self.extent.height])])?;
        Ok(take(bytemuck::cast_slice(buffer.content())))
    }

    fn download(&self, areas: &[Area]) -> Result<Buffer, GpuError> {
        let bytes = areas.iter().map(Area::pixels).sum::<u64>() * self.format.bytes();
        let buffer = Buffer::empty(&self.gpu, "download", BufferUse::Download, bytes)?;
        self.gpu.submit("download", |commands| commands.download(self, areas, &buffer))?;
        Ok(buffer)
    }

    /// The layout that it has after the commands recorded so far.
    pub(super) fn layout(&self) -> vk::ImageLayout {
        vk::ImageLayout::from_raw(self.layout.load(Ordering::Relaxed))
    }

    /// Notes the layout that commands give it, and returns that before.
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

    /// The format of its texels.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The name given when it was made.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of the texels of a level.
    pub(super) fn level_bytes(&self, level: vk::Extent3D) -> u64 {
        texels(level) * self.format.bytes()
    }
}

fn texels(vk::Extent3D { width, height, depth }: vk::Extent3D) -> u64 {
    u64::from(width) * u64::from(height) * u64::from(depth)
}

/// The levels that so many texels fill, the image itself first.
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
        // SAFETY: submissions that used the image were waited for; view and image are destroyed once, in this order,
        // and a null view is ignored.
        self.gpu.free(|device| unsafe {
            device.destroy_image_view(self.view, None);
            device.destroy_image(self.handle, None);
        });
        release(&self.gpu, &mut self.allocation);
    }
}

/// Images whose texels are copied by commands to come: a submission of their own, or a host's commands. Clones share them.
#[derive(Clone, Default)]
pub struct Uploads(Arc<Mutex<Vec<Upload>>>);

/// Texels, and the image that they are for.
pub(super) struct Upload {
    pub(super) texels: Buffer,
    pub(super) image: Arc<Image>,
}

impl Uploads {
    /// An image as [`Image::sampled`] makes it, but for the copy.
    ///
    /// # Errors
    /// Larger than the device allows, or no memory left.
    ///
    /// # Panics
    /// As [`Image::sampled`].
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

    /// Copies those that wait, and waits for it; submits nothing where none does.
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

    /// Those that wait.
    pub(super) fn all(&self) -> MutexGuard<'_, Vec<Upload>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// All of a color image with one layer.
pub(super) const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: vk::REMAINING_MIP_LEVELS,
    base_array_layer: 0,
    layer_count: 1,
};

/// Bytes of the blocks that small resources share.
pub(super) const ALLOCATED_AT_ONCE: u64 = 16 << 20;

fn allocate(
    gpu: &Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation, GpuError> {
    // A device that is the CPU gives what there is not, and the system ends the process when it is written.
    let left = if gpu.info().cpu && requirements.size > ALLOCATED_AT_ONCE { memory::available() } else { None };
    if let Some(left) = left.filter(|left| requirements.size > *left) {
        let reason = format!("{left} bytes of memory are left");
        return Err(GpuError::Memory { what: name.into(), bytes: requirements.size, reason });
    }
    let allocation_scheme = AllocationScheme::GpuAllocatorManaged;
    let description = AllocationCreateDesc { name, requirements, location, linear, allocation_scheme };
    gpu.allocator().allocate(&description).map_err(|error| GpuError::Memory {
        what: name.into(),
        bytes: requirements.size,
        reason: error.to_string(),
    })
}

fn release(gpu: &Gpu, allocation: &mut Allocation) {
    gpu.free(|_| {
        if let Err(error) = gpu.allocator().free(std::mem::take(allocation)) {
            log::error!("device memory could not be freed: {error}");
        }
    });
}
