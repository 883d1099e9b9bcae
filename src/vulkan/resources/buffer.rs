//! Buffers: device memory with a size, a use and a name.

use std::sync::Arc;

use ash::vk;
use bytemuck::{AnyBitPattern, NoUninit};
use gpu_allocator::vulkan::Allocation;

use crate::vulkan::device::memory::{self, Memory};
use crate::vulkan::error::{api, Result, VulkanError};
use crate::vulkan::Context;

/// What a buffer is for. Every buffer can also be copied from and to.
pub type Usage = vk::BufferUsageFlags;

/// A range of memory that shaders and commands use. Commands keep the buffers alive that they use.
pub struct Buffer {
    pub(crate) raw: Arc<RawBuffer>,
}

/// The Vulkan objects of a buffer, shared with the commands that use it.
pub(crate) struct RawBuffer {
    context: Arc<Context>,
    pub(crate) name: String,
    pub(crate) handle: vk::Buffer,
    pub(crate) bytes: u64,
    pub(crate) usage: Usage,
    address: u64,
    allocation: Option<Allocation>,
}

impl Buffer {
    /// Creates a buffer of `bytes` (1 or more). Storage buffers have a [`device_address`](Self::device_address).
    ///
    /// # Errors
    /// Out of memory, a size of zero.
    pub fn new(context: &Arc<Context>, name: &str, bytes: u64, usage: Usage, memory: Memory) -> Result<Self> {
        if bytes == 0 {
            return Err(access(name, "a buffer cannot have 0 bytes".to_owned()));
        }
        let mut usage = usage | Usage::TRANSFER_SRC | Usage::TRANSFER_DST;
        if usage.contains(Usage::STORAGE_BUFFER) {
            usage |= Usage::SHADER_DEVICE_ADDRESS;
        }
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        let device = context.device();
        // SAFETY: the device is alive and the info complete.
        let handle = unsafe { device.create_buffer(&info, None) }.map_err(api("vkCreateBuffer"))?;
        context.set_name(handle, name);
        // From here on dropping `raw` cleans up.
        let mut raw =
            RawBuffer { context: context.clone(), name: name.to_owned(), handle, bytes, usage, address: 0, allocation: None };
        raw.bind(memory)?;
        Ok(Self { raw: Arc::new(raw) })
    }

    /// Creates a buffer in upload memory that holds `data`.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn from_slice<T: NoUninit>(context: &Arc<Context>, name: &str, usage: Usage, data: &[T]) -> Result<Self> {
        let bytes = size_of_val(data) as u64;
        let mut buffer = Self::new(context, name, bytes, usage, Memory::Upload)?;
        buffer.write(0, data)?;
        Ok(buffer)
    }

    /// Size in bytes.
    pub fn bytes(&self) -> u64 {
        self.raw.bytes
    }

    /// Name, as in messages.
    pub fn name(&self) -> &str {
        &self.raw.name
    }

    /// Address for `buffer_reference` in shaders; 0 for buffers that are no storage buffers. For data that shaders read
    /// only: validation does not see writes through addresses. A buffer used by its address alone must be kept alive
    /// with [`Commands::keep`](crate::vulkan::Commands::keep).
    pub fn device_address(&self) -> u64 {
        self.raw.address
    }

    /// Copies `data` to byte `offset`. The GPU must not be using that range.
    ///
    /// # Errors
    /// A range past the end, or device memory.
    pub fn write<T: NoUninit>(&mut self, offset: u64, data: &[T]) -> Result<()> {
        let source: &[u8] = bytemuck::cast_slice(data);
        let target = self.raw.mapped(offset, source.len() as u64)?;
        // SAFETY: `mapped` checked the range; it is not ours alone only if the caller broke the rule above.
        unsafe { std::ptr::copy_nonoverlapping(source.as_ptr(), target, source.len()) };
        Ok(())
    }

    /// Reads `count` values from byte `offset`. The GPU must not be writing that range.
    ///
    /// # Errors
    /// A range past the end, or device memory.
    pub fn read<T: AnyBitPattern + NoUninit>(&self, offset: u64, count: usize) -> Result<Vec<T>> {
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        let source = self.raw.mapped(offset, bytes)?;
        let mut values = vec![T::zeroed(); count];
        let target: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        // SAFETY: `mapped` checked the range, and the target has as many bytes.
        unsafe { std::ptr::copy_nonoverlapping(source, target.as_mut_ptr(), target.len()) };
        Ok(values)
    }
}

impl RawBuffer {
    fn bind(&mut self, memory: Memory) -> Result<()> {
        let device = self.context.device();
        // SAFETY: the buffer is alive and has no memory yet.
        let requirements = unsafe { device.get_buffer_memory_requirements(self.handle) };
        let allocation = memory::allocate(&self.context, &self.name, requirements, memory, true)?;
        // SAFETY: the allocation fits the requirements and belongs to this buffer alone.
        let bound = unsafe { device.bind_buffer_memory(self.handle, allocation.memory(), allocation.offset()) };
        self.allocation = Some(allocation);
        bound.map_err(api("vkBindBufferMemory"))?;
        if self.usage.contains(Usage::SHADER_DEVICE_ADDRESS) {
            let info = vk::BufferDeviceAddressInfo::default().buffer(self.handle);
            // SAFETY: the buffer is bound and was created for this.
            self.address = unsafe { device.get_buffer_device_address(&info) };
        }
        Ok(())
    }

    /// Fails unless the range lies within the buffer.
    pub(crate) fn check_range(&self, offset: u64, bytes: u64) -> Result<()> {
        match offset.checked_add(bytes) {
            Some(end) if end <= self.bytes => Ok(()),
            _ => Err(access(&self.name, format!("{bytes} bytes from {offset} do not fit a buffer of {}", self.bytes))),
        }
    }

    fn mapped(&self, offset: u64, bytes: u64) -> Result<*mut u8> {
        self.check_range(offset, bytes)?;
        let start = self.allocation.as_ref().and_then(Allocation::mapped_ptr);
        let Some(start) = start else {
            return Err(access(&self.name, "the host cannot see device memory".to_owned()));
        };
        // SAFETY: the allocation has at least `self.bytes` bytes, and the range was checked against them.
        Ok(unsafe { start.as_ptr().cast::<u8>().add(offset as usize) })
    }
}

impl Drop for RawBuffer {
    fn drop(&mut self) {
        // SAFETY: commands hold an `Arc` of this until they are done.
        unsafe { self.context.device().destroy_buffer(self.handle, None) };
        if let Some(allocation) = self.allocation.take() {
            memory::free(&self.context, allocation);
        }
    }
}

fn access(what: &str, problem: String) -> VulkanError {
    VulkanError::Access { what: what.to_owned(), problem }
}
