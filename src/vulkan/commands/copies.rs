//! What commands record to fill and copy buffers and images.

use std::ops::Range;

use ash::vk;

use super::synchronization::Access;
use super::Commands;
use crate::vulkan::error::Result;
use crate::vulkan::resources::buffer::Buffer;
use crate::vulkan::resources::image::{aspect, Image, ImageRegion, ImageView};

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

    /// Copies tightly packed texels from `offset` (a multiple of 4 and of the texel size) to a region, which is in the
    /// layout of [`Access::TransferWrite`].
    ///
    /// # Errors
    /// A region that does not lie in the image, or too small a buffer.
    pub fn copy_buffer_to_image(&mut self, from: (&Buffer, u64), image: &Image, region: &ImageRegion) -> Result<()> {
        let (commands, region) = self.image_copy(from, image, region)?;
        let (source, target) = (from.0.raw.handle, image.raw().handle);
        let (_, _, layout) = Access::TransferWrite.parts();
        // SAFETY: the commands are recording, the region is checked, buffer and image are kept.
        unsafe {
            let device = self.context.device();
            device.cmd_copy_buffer_to_image(commands, source, target, layout, &[region]);
        }
        Ok(())
    }

    /// Copies a region, which is in the layout of [`Access::TransferRead`], to tightly packed texels.
    ///
    /// # Errors
    /// As [`copy_buffer_to_image`](Self::copy_buffer_to_image).
    pub fn copy_image_to_buffer(&mut self, image: &Image, region: &ImageRegion, to: (&Buffer, u64)) -> Result<()> {
        let (commands, region) = self.image_copy(to, image, region)?;
        let (source, target) = (image.raw().handle, to.0.raw.handle);
        let (_, _, layout) = Access::TransferRead.parts();
        // SAFETY: the commands are recording, the region is checked, buffer and image are kept.
        unsafe {
            let device = self.context.device();
            device.cmd_copy_image_to_buffer(commands, source, layout, target, &[region]);
        }
        Ok(())
    }

    /// Copies all layers and levels of an image, which is in the layout of [`Access::TransferRead`], to the first layers of
    /// another, which is in that of [`Access::TransferWrite`].
    ///
    /// # Errors
    /// Images of different formats, sizes or numbers of levels, or fewer layers to copy to.
    pub fn copy_image(&mut self, from: &Image, to: &Image) -> Result<()> {
        let commands = self.outside_rendering()?;
        let kind = |image: &Image| (image.format(), image.size(), image.mips());
        if kind(from) != kind(to) || from.layers() > to.layers() {
            return Err(self.misuse(&format!("image `{}` cannot hold the layers of `{}`", to.name(), from.name())));
        }
        self.keep_raw(from.view().raw.clone());
        self.keep_raw(to.view().raw.clone());
        let regions: Vec<vk::ImageCopy> = (0..from.mips())
            .map(|mip| {
                let layers = subresource(from, mip, 0..from.layers());
                let (width, height) = from.mip_size(mip);
                let extent = vk::Extent3D { width, height, depth: 1 };
                vk::ImageCopy::default().src_subresource(layers).dst_subresource(layers).extent(extent)
            })
            .collect();
        let ((_, _, read), (_, _, write)) = (Access::TransferRead.parts(), Access::TransferWrite.parts());
        let (source, target) = (from.raw().handle, to.raw().handle);
        // SAFETY: the commands are recording, both images have these layers and levels and are kept.
        unsafe { self.context.device().cmd_copy_image(commands, source, read, target, write, &regions) };
        Ok(())
    }

    /// Copies an image of one layer and level, in the layout of [`Access::TransferRead`], to a view of the same size and format, in that of
    /// [`Access::TransferWrite`].
    ///
    /// # Errors
    /// Another size or format.
    pub fn copy_to_view(&mut self, from: &Image, to: &ImageView) -> Result<()> {
        let commands = self.outside_rendering()?;
        if (from.format(), from.size()) != (to.format(), to.size()) {
            return Err(
                self.misuse(&format!("image `{}` and the view that it is copied to differ in size or format", from.name()))
            );
        }
        self.keep_raw(from.view().raw.clone());
        self.keep_raw(to.raw.clone());
        let range = to.raw.range;
        let target_layers = vk::ImageSubresourceLayers {
            aspect_mask: range.aspect_mask,
            mip_level: range.base_mip_level,
            base_array_layer: range.base_array_layer,
            layer_count: 1,
        };
        let (width, height) = from.size();
        let region = vk::ImageCopy::default()
            .src_subresource(subresource(from, 0, 0..1))
            .dst_subresource(target_layers)
            .extent(vk::Extent3D { width, height, depth: 1 });
        let ((_, _, read), (_, _, write)) = (Access::TransferRead.parts(), Access::TransferWrite.parts());
        let (source, target) = (from.raw().handle, to.raw.image.handle);
        // SAFETY: the commands are recording, both have this size and format and are kept.
        unsafe { self.context.device().cmd_copy_image(commands, source, read, target, write, &[region]) };
        Ok(())
    }

    /// Sets all texels of some layers of a colour image, which is in the layout of [`Access::TransferWrite`], to 0.
    ///
    /// # Errors
    /// Layers that do not exist, or none.
    pub fn clear_layers(&mut self, image: &Image, layers: Range<u32>) -> Result<()> {
        let commands = self.outside_rendering()?;
        if layers.is_empty() || layers.end > image.layers() {
            return Err(self.misuse(&format!("image `{}` has no layers {layers:?} to clear", image.name())));
        }
        self.keep_raw(image.view().raw.clone());
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(aspect(image.format()))
            .level_count(image.mips())
            .base_array_layer(layers.start)
            .layer_count(layers.end - layers.start);
        let (_, _, layout) = Access::TransferWrite.parts();
        let (target, zero) = (image.raw().handle, vk::ClearColorValue { float32: [0.0; 4] });
        // SAFETY: the commands are recording, the image has these layers and is kept.
        unsafe { self.context.device().cmd_clear_color_image(commands, target, layout, &zero, &[range]) };
        Ok(())
    }

    fn image_copy(
        &mut self,
        (buffer, offset): (&Buffer, u64),
        image: &Image,
        region: &ImageRegion,
    ) -> Result<(vk::CommandBuffer, vk::BufferImageCopy)> {
        let commands = self.outside_rendering()?;
        buffer.raw.check_range(offset, image.region_bytes(region)?)?;
        self.keep(buffer);
        self.keep_raw(image.view().raw.clone());
        let ((x, y), (width, height)) = (region.origin, region.size);
        let region = vk::BufferImageCopy::default()
            .buffer_offset(offset)
            .image_subresource(subresource(image, region.mip, region.layer..region.layer + 1))
            .image_offset(vk::Offset3D { x: x as i32, y: y as i32, z: 0 })
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        Ok((commands, region))
    }
}

fn subresource(image: &Image, mip: u32, layers: Range<u32>) -> vk::ImageSubresourceLayers {
    vk::ImageSubresourceLayers {
        aspect_mask: aspect(image.format()),
        mip_level: mip,
        base_array_layer: layers.start,
        layer_count: layers.end - layers.start,
    }
}
