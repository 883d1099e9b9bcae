//! Stage `gui`: the user interface over a finished picture. Shaders: `gui.vert`, `gui.frag`.
//!
//! In: triangles, and what has changed of the images that they show. Out: blended into the picture, one draw a mesh.

use crate::shaders;
use crate::vulkan::{
    vk, Access, Blend, Buffer, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, Image, ImageDescription,
    ImageRegion, ImageView, Memory, Resource, Result, Sampler, SamplerDescription, Upload, Usage, FRAMES_IN_FLIGHT,
};
use egui::epaint::{ClippedPrimitive, ImageData, ImageDelta, Mesh, Primitive, Vertex};
use egui::{Rect, TextureId, TexturesDelta};
use std::collections::HashMap;
use std::sync::Arc;
use terrane_planet::draw::layout::GuiCorner;

/// Bytes that buffers begin with.
const FIRST_BYTES: u64 = 1 << 16;

// The interface's corners are copied as they are.
const _: () = assert!(size_of::<Vertex>() == size_of::<GuiCorner>());

/// A frame of the interface.
pub struct GuiFrame {
    /// What to draw, in this order. Callbacks are not drawn.
    pub primitives: Vec<ClippedPrimitive>,
    /// What has changed of its images.
    pub images: TexturesDelta,
    /// Pixels of the picture for a point of the interface.
    pub pixels_per_point: f32,
}

/// The stage's pipeline, the images of the interface, and the buffers of each frame in flight.
pub struct Gui {
    context: Arc<Context>,
    pipeline: GraphicsPipeline,
    sampler: Sampler,
    images: HashMap<TextureId, Image>,
    slots: Vec<Slot>,
    slot: usize,
}

/// Corners and indices of all meshes of a frame.
struct Slot {
    corners: Buffer,
    indices: Buffer,
}

impl Gui {
    /// Builds the pipeline for pictures of a format.
    pub fn new(context: &Arc<Context>, format: vk::Format) -> Result<Gui> {
        let formats = [format];
        let mut description = GraphicsDescription::new(shaders::GUI_VERT, Some(shaders::GUI_FRAG), &formats);
        description.blend = Blend::Premultiplied;
        let slot = || {
            Ok(Slot {
                corners: buffer(context, "gui corners", FIRST_BYTES)?,
                indices: buffer(context, "gui indices", FIRST_BYTES)?,
            })
        };
        Ok(Gui {
            context: context.clone(),
            pipeline: GraphicsPipeline::new(context, "gui", &description)?,
            sampler: Sampler::new(context, "gui", &SamplerDescription::default())?,
            images: HashMap::new(),
            slots: (0..FRAMES_IN_FLIGHT).map(|_| slot()).collect::<Result<_>>()?,
            slot: 0,
        })
    }

    /// Records the stage: blends the interface into `picture`. Call it once a frame: the frame before the last must have finished.
    pub fn record(&mut self, commands: &mut Commands, picture: &ImageView, frame: &GuiFrame) -> Result<()> {
        self.slot = (self.slot + 1) % self.slots.len();
        for (id, delta) in &frame.images.set {
            self.update(commands, *id, delta)?;
        }
        let meshes: Vec<(&Rect, &Mesh)> = frame.primitives.iter().filter_map(shown).collect();
        self.slots[self.slot].write(&self.context, &meshes)?;
        commands.zone("gui", |commands| {
            commands.ready(&[picture.to(Access::ColorTarget)])?;
            commands.begin_rendering(&[ColorTarget { view: picture, clear: None }], None)?;
            self.draw(commands, picture.size(), frame.pixels_per_point, &meshes)?;
            commands.end_rendering()
        })?;
        // Commands keep alive what they use.
        frame.images.free.iter().for_each(|id| drop(self.images.remove(id)));
        Ok(())
    }

    fn draw(&self, commands: &mut Commands, size: (u32, u32), scale: f32, meshes: &[(&Rect, &Mesh)]) -> Result<()> {
        let slot = &self.slots[self.slot];
        let to_clip = |side: u32| 2.0 * scale / side as f32;
        let (mut corner, mut index) = (0, 0);
        for (within, mesh) in meshes {
            if let Some(image) = self.images.get(&mesh.texture_id) {
                let [left, top, right, bottom] =
                    [within.min.x, within.min.y, within.max.x, within.max.y].map(|at| (at * scale).round().max(0.0) as u32);
                commands.clip((left, top), (right.saturating_sub(left), bottom.saturating_sub(top)))?;
                let image = Resource::Sampled(image.view(), &self.sampler);
                let [corners, indices] = [&slot.corners, &slot.indices].map(Resource::Storage);
                commands.bind(&self.pipeline, &[("Corners", corners), ("Indices", indices), ("image", image)])?;
                commands.push_constants(&[to_clip(size.0).to_bits(), to_clip(size.1).to_bits(), index, corner])?;
                commands.draw(mesh.indices.len() as u32, 1)?;
            }
            (corner, index) = (corner + mesh.vertices.len() as u32, index + mesh.indices.len() as u32);
        }
        Ok(())
    }

    /// Makes an image anew, or changes a part of it.
    fn update(&mut self, commands: &mut Commands, id: TextureId, delta: &ImageDelta) -> Result<()> {
        let ImageData::Color(pixels) = &delta.image;
        let size = (pixels.width() as u32, pixels.height() as u32);
        let mut upload = Upload::new(&self.context, 4 * pixels.pixels.len() as u64);
        match (delta.pos, self.images.get(&id)) {
            (Some([x, y]), Some(image)) => {
                let region = ImageRegion { layer: 0, mip: 0, origin: (x as u32, y as u32), size };
                upload.image_region(image, &region, &pixels.pixels)?;
            }
            _ => {
                let usage = vk::ImageUsageFlags::SAMPLED;
                let image =
                    Image::new(&self.context, &ImageDescription::new("gui image", size, vk::Format::R8G8B8A8_UNORM, usage))?;
                upload.image(&image, 0, 0, &pixels.pixels)?;
                self.images.insert(id, image);
            }
        }
        upload.record(commands)
    }
}

impl Slot {
    /// Puts the corners and the indices of all meshes one after another.
    fn write(&mut self, context: &Arc<Context>, meshes: &[(&Rect, &Mesh)]) -> Result<()> {
        let corners: usize = meshes.iter().map(|(_, mesh)| size_of_val(mesh.vertices.as_slice())).sum();
        let indices: usize = meshes.iter().map(|(_, mesh)| size_of_val(mesh.indices.as_slice())).sum();
        hold(&mut self.corners, context, corners as u64)?;
        hold(&mut self.indices, context, indices as u64)?;
        let (mut corner, mut index) = (0, 0);
        for (_, mesh) in meshes {
            self.corners.write(corner, &mesh.vertices)?;
            self.indices.write(index, &mesh.indices)?;
            corner += size_of_val(mesh.vertices.as_slice()) as u64;
            index += size_of_val(mesh.indices.as_slice()) as u64;
        }
        Ok(())
    }
}

fn buffer(context: &Arc<Context>, name: &str, bytes: u64) -> Result<Buffer> {
    Buffer::new(context, name, bytes, Usage::STORAGE_BUFFER, Memory::Upload)
}

/// Makes a buffer large enough, and then some. What it held is gone then.
fn hold(held: &mut Buffer, context: &Arc<Context>, bytes: u64) -> Result<()> {
    if held.bytes() < bytes {
        *held = buffer(context, held.name(), bytes.next_power_of_two())?;
    }
    Ok(())
}

/// The mesh of a primitive, and what it is shown within.
fn shown(primitive: &ClippedPrimitive) -> Option<(&Rect, &Mesh)> {
    match &primitive.primitive {
        Primitive::Mesh(mesh) if !mesh.indices.is_empty() => Some((&primitive.clip_rect, mesh)),
        _ => None,
    }
}
