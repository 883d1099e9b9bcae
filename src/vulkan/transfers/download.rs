//! Reads buffers in device memory back to the host.

use std::sync::Arc;

use bytemuck::{AnyBitPattern, NoUninit};

use crate::vulkan::commands::Commands;
use crate::vulkan::device::memory::Memory;
use crate::vulkan::error::Result;
use crate::vulkan::resources::buffer::{Buffer, Usage};
use crate::vulkan::Context;

/// Copies `count` values from the start of a buffer to the host and waits for them. For tests and checks: it stalls.
///
/// # Errors
/// A range past the end, out of memory, or device loss.
pub fn download<T: AnyBitPattern + NoUninit>(context: &Arc<Context>, buffer: &Buffer, count: usize) -> Result<Vec<T>> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    buffer.raw.check_range(0, bytes)?;
    let usage = Usage::TRANSFER_DST;
    let target = Buffer::new(context, "download", bytes, usage, Memory::Readback)?;
    Commands::once(context, "download", |commands| commands.copy_buffer((buffer, 0), (&target, 0), bytes))?;
    target.read(0, count)
}
