//! Batches of host data on their way to device memory.

use std::sync::Arc;

use bytemuck::NoUninit;

use crate::vulkan::commands::accesses::Use;
use crate::vulkan::commands::synchronization::Access;
use crate::vulkan::commands::Commands;
use crate::vulkan::device::memory::Memory;
use crate::vulkan::error::{Result, VulkanError};
use crate::vulkan::resources::buffer::{Buffer, Usage};
use crate::vulkan::resources::image::{Image, ImageRegion, ImageView};
use crate::vulkan::Context;

/// Offsets in staging memory are multiples of this, as copies to images of every format need.
const ALIGNMENT: u64 = 16;

/// Data copied to staging memory now and to its targets later, all in one go. The memory it takes is what is staged:
/// the caller decides how much that is per frame.
pub struct Upload {
    context: Arc<Context>,
    chunk_bytes: u64,
    chunks: Vec<Chunk>,
    steps: Vec<Step>,
}

struct Chunk {
    buffer: Buffer,
    used: u64,
}

/// What is to be recorded, in this order.
enum Step {
    Copy(Copy),
    /// An image to be begun, with the layers of another.
    Begin(Image, Option<Image>),
}

struct Copy {
    chunk: usize,
    offset: u64,
    bytes: u64,
    target: Target,
}

enum Target {
    Buffer(Buffer, u64),
    /// A whole layer and level, and its view.
    Layer(Image, ImageRegion, ImageView),
    Region(Image, ImageRegion),
}

impl Upload {
    /// Creates an empty batch that allocates `chunk_bytes` (at least) at a time.
    pub fn new(context: &Arc<Context>, chunk_bytes: u64) -> Self {
        Self { context: context.clone(), chunk_bytes, chunks: Vec::new(), steps: Vec::new() }
    }

    /// Bytes staged and not yet recorded.
    pub fn staged_bytes(&self) -> u64 {
        self.steps.iter().map(|step| if let Step::Copy(copy) = step { copy.bytes } else { 0 }).sum()
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
        let region = image.whole(layer, mip)?;
        let bytes = bytes_of_region(image, &region, texels)?;
        self.stage(bytes, Target::Layer(image.share(), region, image.layer_view(layer, mip)?))
    }

    /// Stages the tightly packed texels of a region of an image that was last used as [`Access::Sampled`], and is left ready for
    /// that again. Its other texels stay. Do not mix with [`Upload::image`] for the same image in one batch.
    ///
    /// # Errors
    /// A region that does not lie in the image, texels of another size, or out of memory.
    pub fn image_region<T: NoUninit>(&mut self, image: &Image, region: &ImageRegion, texels: &[T]) -> Result<()> {
        let bytes = bytes_of_region(image, region, texels)?;
        self.stage(bytes, Target::Region(image.share(), *region))
    }

    /// Stages the beginning of a new colour image: its first layers are those of `from`, of the same size, format and levels and
    /// last used as [`Access::Sampled`]; all other texels are 0. Both are left ready to be sampled.
    pub fn begin_image(&mut self, image: &Image, from: Option<&Image>) {
        self.steps.push(Step::Begin(image.share(), from.map(Image::share)));
    }

    /// Records all copies, with barriers before and after; the batch is empty again. Commands recorded later see the data.
    ///
    /// # Errors
    /// Not recording, or rendering.
    pub fn record(&mut self, commands: &mut Commands) -> Result<()> {
        if self.steps.is_empty() {
            return Ok(());
        }
        let _span = tracing::trace_span!("record upload", steps = self.steps.len()).entered();
        let all = ash::vk::PipelineStageFlags2::ALL_COMMANDS;
        let (write, read) = (ash::vk::AccessFlags2::MEMORY_WRITE, ash::vk::AccessFlags2::MEMORY_READ);
        commands.memory_barrier(all, write, all, read | write)?;
        let mut filling = Filling::default();
        for step in &self.steps {
            match step {
                Step::Copy(copy) => copy.record((&self.chunks[copy.chunk].buffer, copy.offset), commands, &mut filling)?,
                Step::Begin(image, from) => filling.begin(commands, image, from.as_ref())?,
            }
        }
        filling.end(commands)?;
        commands.memory_barrier(all, write, all, read | write)?;
        self.steps.clear();
        self.chunks.clear();
        Ok(())
    }

    /// Submits all copies and waits for them.
    ///
    /// # Errors
    /// Those of [`Commands::wait`].
    pub fn finish(&mut self) -> Result<()> {
        if self.steps.is_empty() {
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
        self.steps.push(Step::Copy(Copy { chunk: index, offset: chunk.used, bytes, target }));
        chunk.used = (chunk.used + bytes).next_multiple_of(ALIGNMENT);
        Ok(())
    }
}

impl Copy {
    fn record(&self, from: (&Buffer, u64), commands: &mut Commands, filling: &mut Filling) -> Result<()> {
        match &self.target {
            Target::Buffer(buffer, offset) => commands.copy_buffer(from, (buffer, *offset), self.bytes),
            Target::Layer(image, region, view) => {
                commands.ready(&[view.anew(Access::TransferWrite)])?;
                commands.copy_buffer_to_image(from, image, region)?;
                commands.ready(&[view.to(Access::Sampled)])
            }
            Target::Region(image, region) => {
                filling.ready(commands, image, region)?;
                commands.copy_buffer_to_image(from, image, region)
            }
        }
    }
}

/// The images that a batch writes regions of, and the regions written since each image's last barrier: a batch of tiles takes one
/// transition of the whole image before and one after it.
#[derive(Default)]
struct Filling {
    images: Vec<(Image, Vec<ImageRegion>)>,
}

impl Filling {
    /// Makes an image ready for a write of a region.
    fn ready(&mut self, commands: &mut Commands, image: &Image, region: &ImageRegion) -> Result<()> {
        let number = match self.number(image) {
            Some(number) => number,
            None => {
                commands.found(image.view(), Access::Sampled);
                commands.ready(&[image.view().to(Access::TransferWrite)])?;
                self.images.push((image.share(), Vec::new()));
                self.images.len() - 1
            }
        };
        let written = &mut self.images[number].1;
        if written.iter().any(|earlier| earlier.overlaps(region)) {
            commands.ready(&[image.view().to(Access::TransferWrite)])?;
            written.clear();
        }
        written.push(*region);
        Ok(())
    }

    /// Begins a new image with the layers of another, which this is done with.
    fn begin(&mut self, commands: &mut Commands, image: &Image, from: Option<&Image>) -> Result<()> {
        commands.ready(&[image.view().anew(Access::TransferWrite)])?;
        if let Some(from) = from {
            match self.number(from) {
                Some(number) => drop(self.images.swap_remove(number)),
                None => commands.found(from.view(), Access::Sampled),
            }
            commands.ready(&[from.view().to(Access::TransferRead)])?;
            commands.copy_image(from, image)?;
            commands.ready(&[from.view().to(Access::Sampled)])?;
        }
        let copied = from.map_or(0, Image::layers);
        if copied < image.layers() {
            commands.clear_layers(image, copied..image.layers())?;
        }
        // Regions may lie in what was just written.
        commands.ready(&[image.view().to(Access::TransferWrite)])?;
        self.images.push((image.share(), Vec::new()));
        Ok(())
    }

    /// Makes all images ready to be sampled.
    fn end(self, commands: &mut Commands) -> Result<()> {
        let uses: Vec<Use<'_>> = self.images.iter().map(|(image, _)| image.view().to(Access::Sampled)).collect();
        commands.ready(&uses)
    }

    fn number(&self, image: &Image) -> Option<usize> {
        self.images.iter().position(|(other, _)| other.raw().handle == image.raw().handle)
    }
}

/// The bytes of a region's texels. Fails unless the region lies in the image and they fill it.
fn bytes_of_region<'a, T: NoUninit>(image: &Image, region: &ImageRegion, texels: &'a [T]) -> Result<&'a [u8]> {
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    let expected = image.region_bytes(region)?;
    if bytes.len() as u64 == expected {
        return Ok(bytes);
    }
    let (ImageRegion { mip, size: (width, height), .. }, found) = (region, bytes.len());
    let problem = format!("{found} bytes of texels; {width} × {height} texels of level {mip} have {expected}");
    Err(VulkanError::Access { what: image.name().to_owned(), problem })
}
