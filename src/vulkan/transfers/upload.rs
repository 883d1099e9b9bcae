//! Batches of host data on their way to device memory.

use std::sync::Arc;

use bytemuck::NoUninit;

use crate::vulkan::commands::synchronization::Access;
use crate::vulkan::commands::Commands;
use crate::vulkan::device::memory::Memory;
use crate::vulkan::error::{Result, VulkanError};
use crate::vulkan::resources::buffer::{Buffer, Usage};
use crate::vulkan::resources::image::{Image, ImageView};
use crate::vulkan::Context;

/// Offsets in staging memory are multiples of this, as copies to images of every format need.
const ALIGNMENT: u64 = 16;

/// Data copied to staging memory now and to its targets later, all in one go. The memory it takes is what is staged:
/// the caller decides how much that is per frame.
pub struct Upload {
    context: Arc<Context>,
    chunk_bytes: u64,
    chunks: Vec<Chunk>,
    copies: Vec<Copy>,
}

struct Chunk {
    buffer: Buffer,
    used: u64,
}

struct Copy {
    chunk: usize,
    offset: u64,
    bytes: u64,
    target: Target,
}

enum Target {
    Buffer(Buffer, u64),
    Layer(Layer),
}

struct Layer {
    image: Image,
    view: ImageView,
    layer: u32,
    mip: u32,
}

impl Upload {
    /// Creates an empty batch that allocates `chunk_bytes` (at least) at a time.
    pub fn new(context: &Arc<Context>, chunk_bytes: u64) -> Self {
        Self { context: context.clone(), chunk_bytes, chunks: Vec::new(), copies: Vec::new() }
    }

    /// Bytes staged and not yet recorded.
    pub fn staged_bytes(&self) -> u64 {
        self.copies.iter().map(|copy| copy.bytes).sum()
    }

    /// Stages `data` for byte `offset` of a buffer.
    ///
    /// # Errors
    /// A range past the end, or out of memory.
    pub fn buffer<T: NoUninit>(&mut self, target: &Buffer, offset: u64, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        target.raw.check_range(offset, bytes.len() as u64)?;
        if bytes.is_empty() {
            return Ok(());
        }
        let target = Target::Buffer(Buffer { raw: target.raw.clone() }, offset);
        self.stage(bytes, target)
    }

    /// Stages the tightly packed texels of one whole layer and level. Afterwards it is in the layout of
    /// [`Access::Sampled`]; whatever it was in before, its old texels are gone.
    ///
    /// # Errors
    /// A layer or level that does not exist, texels of another size, or out of memory.
    pub fn image<T: NoUninit>(&mut self, image: &Image, layer: u32, mip: u32, texels: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        let view = image.layer_view(layer, mip)?;
        let expected = image.layer_bytes(mip)?;
        if bytes.len() as u64 != expected {
            let problem = format!("{} bytes of texels; level {mip} has {expected}", bytes.len());
            return Err(VulkanError::Access { what: image.name().to_owned(), problem });
        }
        let image = image.share();
        self.stage(bytes, Target::Layer(Layer { image, view, layer, mip }))
    }

    /// Records all copies, with barriers before and after; the batch is empty again. Commands recorded later see the data.
    ///
    /// # Errors
    /// Not recording, or rendering.
    pub fn record(&mut self, commands: &mut Commands) -> Result<()> {
        if self.copies.is_empty() {
            return Ok(());
        }
        let all = ash::vk::PipelineStageFlags2::ALL_COMMANDS;
        let (write, read) = (ash::vk::AccessFlags2::MEMORY_WRITE, ash::vk::AccessFlags2::MEMORY_READ);
        commands.memory_barrier(all, write, all, read | write)?;
        for copy in &self.copies {
            let from = (&self.chunks[copy.chunk].buffer, copy.offset);
            match &copy.target {
                Target::Buffer(buffer, offset) => {
                    commands.copy_buffer(from, (buffer, *offset), copy.bytes)?;
                }
                Target::Layer(Layer { image, view, layer, mip }) => {
                    commands.ready(&[view.anew(Access::TransferWrite)])?;
                    commands.copy_buffer_to_image(from, image, *layer, *mip)?;
                    commands.ready(&[view.to(Access::Sampled)])?;
                }
            }
        }
        commands.memory_barrier(all, write, all, read | write)?;
        self.copies.clear();
        self.chunks.clear();
        Ok(())
    }

    /// Submits all copies and waits for them.
    ///
    /// # Errors
    /// Those of [`Commands::wait`].
    pub fn finish(&mut self) -> Result<()> {
        if self.copies.is_empty() {
            return Ok(());
        }
        let context = self.context.clone();
        Commands::once(&context, "upload", |commands| self.record(commands)).map(|_| ())
    }

    fn stage(&mut self, data: &[u8], target: Target) -> Result<()> {
        let bytes = data.len() as u64;
        let full = |chunk: &Chunk| chunk.used + bytes > chunk.buffer.bytes();
        if self.chunks.last().is_none_or(full) {
            let size = self.chunk_bytes.max(bytes);
            let usage = Usage::TRANSFER_SRC;
            let buffer = Buffer::new(&self.context, "staging", size, usage, Memory::Upload)?;
            self.chunks.push(Chunk { buffer, used: 0 });
        }
        let index = self.chunks.len() - 1;
        let chunk = &mut self.chunks[index];
        chunk.buffer.write(chunk.used, data)?;
        self.copies.push(Copy { chunk: index, offset: chunk.used, bytes, target });
        chunk.used = (chunk.used + bytes).next_multiple_of(ALIGNMENT);
        Ok(())
    }
}
