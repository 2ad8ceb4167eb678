//! Buffers with their memory.

use super::memory::{allocate, release};
use super::{Gpu, GpuError, Named};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

/// Purpose of a buffer.
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
    /// Texels that a compute shader writes, and their copy reads.
    Words,
}

/// A buffer, in memory that the CPU can access unless a compute shader writes it.
pub struct Buffer {
    gpu: Gpu,
    pub(super) handle: vk::Buffer,
    allocation: Allocation,
    bytes: u64,
}

impl Buffer {
    /// Creates an unwritten buffer.
    ///
    /// # Errors
    /// Device memory is exhausted.
    pub fn empty(gpu: &Gpu, name: &str, purpose: BufferUse, bytes: u64) -> Result<Buffer, GpuError> {
        let (usage, location) = match purpose {
            BufferUse::Uniform => (vk::BufferUsageFlags::UNIFORM_BUFFER, MemoryLocation::CpuToGpu),
            BufferUse::Vertices => (vk::BufferUsageFlags::VERTEX_BUFFER, MemoryLocation::CpuToGpu),
            BufferUse::Upload => (vk::BufferUsageFlags::TRANSFER_SRC, MemoryLocation::CpuToGpu),
            BufferUse::Download => (vk::BufferUsageFlags::TRANSFER_DST, MemoryLocation::GpuToCpu),
            BufferUse::Words => {
                (vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC, MemoryLocation::GpuOnly)
            }
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

    /// Creates a buffer with content.
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

    /// Content after a submission that made it visible to the CPU.
    pub(super) fn content(&self) -> &[u8] {
        self.allocation.mapped_slice().map(|slice| &slice[..self.bytes as usize]).unwrap_or_default()
    }

    /// Bytes of the content.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: submissions with the buffer have finished; it is destroyed once.
        self.gpu.free(|device| unsafe { device.destroy_buffer(self.handle, None) });
        release(&self.gpu, &mut self.allocation);
    }
}
