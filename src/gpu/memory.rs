//! Device memory.

use super::{Gpu, GpuError};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use hypertexture_support::memory;

/// Bytes of the memory blocks that small resources share.
pub(super) const MEMORY_BLOCK: u64 = 16 << 20;

pub(super) fn allocate(
    gpu: &Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation, GpuError> {
    // Drivers on the CPU overcommit memory (docs/notes/drivers.md).
    let left = if gpu.info().cpu && requirements.size > MEMORY_BLOCK { memory::available() } else { None };
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

pub(super) fn release(gpu: &Gpu, allocation: &mut Allocation) {
    gpu.free(|_| {
        if let Err(error) = gpu.allocator().free(std::mem::take(allocation)) {
            log::error!("device memory could not be freed: {error}");
        }
    });
}
