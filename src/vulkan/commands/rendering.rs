//! What commands record to draw: rendering to targets and the draws themselves.

use ash::vk;

use super::synchronization::Access;
use super::Commands;
use crate::vulkan::error::Result;
use crate::vulkan::resources::buffer::{Buffer, Usage};
use crate::vulkan::resources::image::ImageView;

/// Size of the arguments of one indexed indirect draw: index count, instance count, first index, vertex offset (signed),
/// first instance.
const DRAW_BYTES: u64 = 20;

/// A colour target, in the layout of [`Access::ColorTarget`].
#[derive(Clone, Copy)]
pub struct ColorTarget<'a> {
    /// What to draw to.
    pub view: &'a ImageView,
    /// The colour to start from; none keeps what is there.
    pub clear: Option<[f32; 4]>,
}

/// A depth target, in the layout of [`Access::DepthTarget`].
#[derive(Clone, Copy)]
pub struct DepthTarget<'a> {
    /// What to test against.
    pub view: &'a ImageView,
    /// The depth to start from, 0 being the farthest; none keeps what is there.
    pub clear: Option<f32>,
}

impl Commands {
    /// Begins drawing to all of the targets, which have the same size; viewport and scissor are set to it.
    ///
    /// # Errors
    /// No target, or targets of different sizes, or already rendering.
    pub fn begin_rendering(&mut self, colors: &[ColorTarget<'_>], depth: Option<DepthTarget<'_>>) -> Result<()> {
        let commands = self.outside_rendering()?;
        let views = || colors.iter().map(|c| c.view).chain(depth.iter().map(|d| d.view));
        let Some(size) = views().next().map(ImageView::size) else {
            return Err(self.misuse("begin_rendering without a target"));
        };
        if views().any(|view| view.size() != size) {
            return Err(self.misuse("begin_rendering with targets of different sizes"));
        }
        let (width, height) = size;
        let area = vk::Rect2D::default().extent(vk::Extent2D { width, height });
        let attachments: Vec<_> = colors.iter().map(color_attachment).collect();
        let depth_attachment = depth.as_ref().map(depth_attachment);
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachments);
        if let Some(attachment) = &depth_attachment {
            info = info.depth_attachment(attachment);
        }
        let viewport =
            vk::Viewport { x: 0.0, y: 0.0, width: width as f32, height: height as f32, min_depth: 0.0, max_depth: 1.0 };
        let device = self.context.device();
        // SAFETY: the commands are recording outside rendering; the views are kept below.
        unsafe {
            device.cmd_begin_rendering(commands, &info);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
        }
        let kept: Vec<_> = views().map(|view| view.raw.clone()).collect();
        kept.into_iter().for_each(|view| self.keep_raw(view));
        self.rendering = true;
        Ok(())
    }

    /// Ends drawing.
    ///
    /// # Errors
    /// Not rendering.
    pub fn end_rendering(&mut self) -> Result<()> {
        let commands = self.while_rendering()?;
        // SAFETY: the commands are rendering.
        unsafe { self.context.device().cmd_end_rendering(commands) };
        self.rendering = false;
        Ok(())
    }

    /// Lets what is drawn next change only the pixels of a rectangle: its upper left corner and its size. Parts of it that lie outside the
    /// targets change nothing.
    ///
    /// # Errors
    /// Not rendering.
    pub fn clip(&mut self, corner: (u32, u32), size: (u32, u32)) -> Result<()> {
        let commands = self.while_rendering()?;
        let most = i32::MAX as u32;
        let (x, y) = (corner.0.min(most), corner.1.min(most));
        let extent = vk::Extent2D { width: size.0.min(most - x), height: size.1.min(most - y) };
        let area = vk::Rect2D { offset: vk::Offset2D { x: x as i32, y: y as i32 }, extent };
        // SAFETY: the commands are rendering, and the rectangle ends within the numbers that Vulkan allows.
        unsafe { self.context.device().cmd_set_scissor(commands, 0, &[area]) };
        Ok(())
    }

    /// Draws `vertices` vertices, `instances` times.
    ///
    /// # Errors
    /// Not rendering, or no graphics pipeline.
    pub fn draw(&mut self, vertices: u32, instances: u32) -> Result<()> {
        let commands = self.drawing()?;
        // SAFETY: the commands are rendering, and a graphics pipeline with its resources is bound.
        unsafe { self.context.device().cmd_draw(commands, vertices, instances, 0, 0) };
        Ok(())
    }

    /// Draws with 32-bit indices, with one set of arguments (five 32-bit words) at byte `offset` of `arguments`.
    ///
    /// # Errors
    /// Not rendering, no graphics pipeline, buffers not created for this, or an offset past the end.
    pub fn draw_indexed_indirect(&mut self, indices: &Buffer, arguments: &Buffer, offset: u64) -> Result<()> {
        let commands = self.drawing()?;
        arguments.raw.check_range(offset, DRAW_BYTES)?;
        let indexed = indices.raw.usage.contains(Usage::INDEX_BUFFER);
        let indirect = arguments.raw.usage.contains(Usage::INDIRECT_BUFFER);
        if !indexed || !indirect || !offset.is_multiple_of(4) {
            return Err(
                self.misuse("draw_indexed_indirect needs an INDEX_BUFFER, an INDIRECT_BUFFER and an offset of whole words")
            );
        }
        self.keep(indices);
        self.keep(arguments);
        let (indices, arguments) = (indices.raw.handle, arguments.raw.handle);
        let device = self.context.device();
        // SAFETY: the commands are rendering, a graphics pipeline with its resources is bound, the range is checked.
        unsafe {
            device.cmd_bind_index_buffer(commands, indices, 0, vk::IndexType::UINT32);
            device.cmd_draw_indexed_indirect(commands, arguments, offset, 1, DRAW_BYTES as u32);
        }
        Ok(())
    }

    fn drawing(&self) -> Result<vk::CommandBuffer> {
        self.check_bound(vk::PipelineBindPoint::GRAPHICS)?;
        self.while_rendering()
    }

    fn while_rendering(&self) -> Result<vk::CommandBuffer> {
        if !self.rendering {
            return Err(self.misuse("this can only be recorded while rendering"));
        }
        self.recorder()
    }
}

fn color_attachment<'a>(target: &ColorTarget<'a>) -> vk::RenderingAttachmentInfo<'a> {
    let color = vk::ClearColorValue { float32: target.clear.unwrap_or_default() };
    let clear = vk::ClearValue { color };
    attachment(target.view, Access::ColorTarget, target.clear.map(|_| clear))
}

fn depth_attachment<'a>(target: &DepthTarget<'a>) -> vk::RenderingAttachmentInfo<'a> {
    let clear = |depth| vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } };
    attachment(target.view, Access::DepthTarget, target.clear.map(clear))
}

fn attachment<'a>(view: &'a ImageView, access: Access, clear: Option<vk::ClearValue>) -> vk::RenderingAttachmentInfo<'a> {
    let (_, _, layout) = access.parts();
    let load = if clear.is_some() { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD };
    vk::RenderingAttachmentInfo::default()
        .image_view(view.raw.handle)
        .image_layout(layout)
        .load_op(load)
        .store_op(vk::AttachmentStoreOp::STORE)
        .clear_value(clear.unwrap_or_default())
}
