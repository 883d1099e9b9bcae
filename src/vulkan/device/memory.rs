//! Device memory, in blocks shared by many resources.

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::atomic::Ordering;

use gpu_allocator::{AllocationError, MemoryLocation};

use crate::vulkan::error::{Result, VulkanError};
use crate::vulkan::Context;

/// Where a buffer lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// Fast for the GPU; the host cannot see it.
    Device,
    /// Written by the host, read by the GPU.
    Upload,
    /// Written by the GPU, read by the host.
    Readback,
}

impl Memory {
    fn location(self) -> MemoryLocation {
        match self {
            Self::Device => MemoryLocation::GpuOnly,
            Self::Upload => MemoryLocation::CpuToGpu,
            Self::Readback => MemoryLocation::GpuToCpu,
        }
    }
}

/// Allocates memory for the resource `name`; `linear` is true for buffers.
pub(crate) fn allocate(
    context: &Context,
    name: &str,
    requirements: vk::MemoryRequirements,
    memory: Memory,
    linear: bool,
) -> Result<Allocation> {
    let description = AllocationCreateDesc {
        name,
        requirements,
        location: memory.location(),
        linear,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    };
    let allocation =
        context.allocator().allocate(&description).map_err(|error| allocation_error(name, requirements.size, &error))?;
    context.allocated.fetch_add(allocation.size(), Ordering::Relaxed);
    context.allocations.fetch_add(1, Ordering::Relaxed);
    Ok(allocation)
}

/// Gives memory back.
pub(crate) fn free(context: &Context, allocation: Allocation) {
    context.allocated.fetch_sub(allocation.size(), Ordering::Relaxed);
    if let Err(error) = context.allocator().free(allocation) {
        tracing::error!("freeing device memory: {error}");
    }
}

pub(crate) fn allocation_error(what: &str, bytes: u64, error: &AllocationError) -> VulkanError {
    match error {
        AllocationError::OutOfMemory => VulkanError::OutOfMemory { what: what.to_owned(), bytes },
        other => VulkanError::Access { what: what.to_owned(), problem: other.to_string() },
    }
}
