//! What commands record to fill and copy buffers and images.

use ash::vk;

use super::synchronization::Access;
use super::Commands;
use crate::vulkan::error::Result;
use crate::vulkan::resources::buffer::Buffer;
use crate::vulkan::resources::image::{aspect, Image};

impl Commands {
    /// Sets every 32-bit word of a range, in bytes that are multiples of 4.
    ///
    /// # Errors
    /// A range past the end, empty or not of whole words.
    pub fn fill_buffer(&mut self, buffer: &Buffer, offset: u64, bytes: u64, word: u32) -> Result<()> {
        let commands = self.outside_rendering()?;
        buffer.raw.check_range(offset, bytes)?;
        if bytes == 0 || !offset.is_multiple_of(4) || !bytes.is_multiple_of(4) {
            return Err(self.misuse("fill_buffer needs a range of whole 32-bit words"));
        }
        self.keep(buffer);
        // SAFETY: the commands are recording, the range is checked.
        unsafe {
            let device = self.context.device();
            device.cmd_fill_buffer(commands, buffer.raw.handle, offset, bytes, word);
        }
        Ok(())
    }

    /// Copies bytes from one buffer to another.
    ///
    /// # Errors
    /// A range past the end, or empty.
    pub fn copy_buffer(&mut self, from: (&Buffer, u64), to: (&Buffer, u64), bytes: u64) -> Result<()> {
        let commands = self.outside_rendering()?;
        let ((source, source_offset), (target, target_offset)) = (from, to);
        source.raw.check_range(source_offset, bytes)?;
        target.raw.check_range(target_offset, bytes)?;
        if bytes == 0 {
            return Err(self.misuse("copy_buffer of 0 bytes"));
        }
        self.keep(source);
        self.keep(target);
        let region = vk::BufferCopy { src_offset: source_offset, dst_offset: target_offset, size: bytes };
        let (source, target) = (source.raw.handle, target.raw.handle);
        // SAFETY: the commands are recording, the ranges are checked.
        unsafe { self.context.device().cmd_copy_buffer(commands, source, target, &[region]) };
        Ok(())
    }

    /// Copies tightly packed texels from `offset` (a multiple of 4 and of the texel size) to a layer and level, which is
    /// in the layout of [`Access::TransferWrite`].
    ///
    /// # Errors
    /// A layer or level that does not exist, or too small a buffer.
    pub fn copy_buffer_to_image(&mut self, from: (&Buffer, u64), image: &Image, layer: u32, mip: u32) -> Result<()> {
        let (commands, region) = self.image_copy(from, image, layer, mip)?;
        let (source, target) = (from.0.raw.handle, image.raw().handle);
        let (_, _, layout) = Access::TransferWrite.parts();
        // SAFETY: the commands are recording, the region is checked, buffer and image are kept.
        unsafe {
            let device = self.context.device();
            device.cmd_copy_buffer_to_image(commands, source, target, layout, &[region]);
        }
        Ok(())
    }

    /// Copies a layer and level, which is in the layout of [`Access::TransferRead`], to tightly packed texels.
    ///
    /// # Errors
    /// As [`copy_buffer_to_image`](Self::copy_buffer_to_image).
    pub fn copy_image_to_buffer(&mut self, image: &Image, layer: u32, mip: u32, to: (&Buffer, u64)) -> Result<()> {
        let (commands, region) = self.image_copy(to, image, layer, mip)?;
        let (source, target) = (image.raw().handle, to.0.raw.handle);
        let (_, _, layout) = Access::TransferRead.parts();
        // SAFETY: the commands are recording, the region is checked, buffer and image are kept.
        unsafe {
            let device = self.context.device();
            device.cmd_copy_image_to_buffer(commands, source, layout, target, &[region]);
        }
        Ok(())
    }

    fn image_copy(
        &mut self,
        (buffer, offset): (&Buffer, u64),
        image: &Image,
        layer: u32,
        mip: u32,
    ) -> Result<(vk::CommandBuffer, vk::BufferImageCopy)> {
        let commands = self.outside_rendering()?;
        image.check(layer, mip)?;
        let bytes = image.layer_bytes(mip)?;
        buffer.raw.check_range(offset, bytes)?;
        self.keep(buffer);
        self.keep_raw(image.view().raw.clone());
        let (width, height) = image.mip_size(mip);
        let region = vk::BufferImageCopy::default()
            .buffer_offset(offset)
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: aspect(image.format()),
                mip_level: mip,
                base_array_layer: layer,
                layer_count: 1,
            })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        Ok((commands, region))
    }
}
