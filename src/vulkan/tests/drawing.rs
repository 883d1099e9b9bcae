//! Drawing: dynamic rendering, indexed indirect, reversed depth, capture.

use std::sync::Arc;

use super::device;
use crate::shaders::test::{TRIANGLE_FRAG, TRIANGLE_VERT};
use crate::vulkan::{
    capture, vk, Access, Buffer, Captured, ColorTarget, Commands, Context, DepthTarget, DepthTest, GraphicsDescription,
    GraphicsPipeline, Image, ImageDescription, Resource, Result, Sampler, SamplerDescription, Upload, Usage,
};

const SIZE: (u32, u32) = (64, 48);
const COLOR: vk::Format = vk::Format::R8G8B8A8_UNORM;
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Push {
    tint: [f32; 4],
    layer: u32,
}

/// A near triangle in the lower left half and a far one over everything.
struct Scene {
    pipeline: GraphicsPipeline,
    vertices: Buffer,
    indices: Buffer,
    arguments: Buffer,
    pages: Image,
    sampler: Sampler,
    color: Image,
    depth: Image,
}

impl Scene {
    fn new(context: &Arc<Context>, cull: vk::CullModeFlags) -> Self {
        let mut description = GraphicsDescription::new(TRIANGLE_VERT, Some(TRIANGLE_FRAG), &[COLOR]);
        description.depth_format = Some(DEPTH);
        description.depth = Some(DepthTest { compare: vk::CompareOp::GREATER_OR_EQUAL, write: true });
        description.cull = cull;
        let pipeline = GraphicsPipeline::new(context, "triangles", &description).unwrap();
        let near = [[-1.0, -1.0, 0.75, 1.0], [-1.0, 1.0, 0.75, 1.0], [1.0, 1.0, 0.75, 1.0f32]];
        let far = [[-1.0, -1.0, 0.25, 1.0], [-1.0, 3.0, 0.25, 1.0], [3.0, -1.0, 0.25, 1.0]];
        let all = [near, far];
        let buffer = |name, usage, words: &[u32]| Buffer::from_slice(context, name, usage, words).unwrap();
        let vertices = Buffer::from_slice(context, "vertices", Usage::STORAGE_BUFFER, &all).unwrap();
        // The near triangle is drawn first: without a depth test the far one would hide it.
        let indices = buffer("indices", Usage::INDEX_BUFFER, &[0, 1, 2, 3, 4, 5]);
        let arguments = [3, 1, 0, 0, 0, 3, 1, 3, 0, 0];
        let arguments = buffer("arguments", Usage::INDIRECT_BUFFER, &arguments);
        let target = |name, format, usage| Image::new(context, &ImageDescription::new(name, SIZE, format, usage)).unwrap();
        let color = target("color", COLOR, vk::ImageUsageFlags::COLOR_ATTACHMENT);
        let depth = target("depth", DEPTH, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT);
        let pages = pages(context);
        let sampler = Sampler::new(context, "sampler", &SamplerDescription::default()).unwrap();
        Self { pipeline, vertices, indices, arguments, pages, sampler, color, depth }
    }

    fn record(&self, commands: &mut Commands) -> Result<()> {
        commands.ready(&[self.color.view().anew(Access::ColorTarget), self.depth.view().anew(Access::DepthTarget)])?;
        let color = ColorTarget { view: self.color.view(), clear: Some([0.0, 0.0, 0.0, 1.0]) };
        let depth = DepthTarget { view: self.depth.view(), clear: Some(0.0) };
        commands.zone("draw", |commands| {
            commands.begin_rendering(&[color], Some(depth))?;
            let resources =
                [("vertices", Resource::Storage(&self.vertices)), ("pages", Resource::Sampled(self.pages.view(), &self.sampler))];
            commands.bind(&self.pipeline, &resources)?;
            for draw in 0..2u32 {
                let tint = [1.0, 1.0 - draw as f32, 1.0, 1.0];
                commands.push_constants(&Push { tint, layer: draw })?;
                let offset = u64::from(draw) * 20;
                commands.draw_indexed_indirect(&self.indices, &self.arguments, offset)?;
            }
            commands.end_rendering()
        })
    }
}

/// Two pages of one colour each: orange and cyan.
fn pages(context: &Arc<Context>) -> Image {
    let usage = vk::ImageUsageFlags::SAMPLED;
    let mut description = ImageDescription::new("pages", (4, 4), COLOR, usage);
    description.layers = 2;
    let pages = Image::new(context, &description).unwrap();
    let mut upload = Upload::new(context, 64);
    upload.image(&pages, 0, 0, &[[255u8, 128, 0, 255]; 16]).unwrap();
    upload.image(&pages, 1, 0, &[[0u8, 255, 255, 255]; 16]).unwrap();
    upload.finish().unwrap();
    pages
}

fn draw(context: &Arc<Context>, scene: &Scene) -> (Captured, Captured) {
    Commands::once(context, "triangles", |commands| scene.record(commands)).unwrap();
    let color = capture(context, &scene.color, (0, 0), Access::ColorTarget).unwrap();
    let depth = capture(context, &scene.depth, (0, 0), Access::DepthTarget).unwrap();
    (color, depth)
}

fn count(picture: &Captured, color: [u8; 4]) -> usize {
    picture.bytes.chunks_exact(4).filter(|texel| *texel == color).count()
}

#[test]
fn nearer_triangles_hide_farther_ones_with_reversed_depth() {
    let Some(context) = device() else { return };
    let scene = Scene::new(&context, vk::CullModeFlags::NONE);
    let (color, depth) = draw(&context, &scene);
    let (near, far) = (count(&color, [255, 128, 0, 255]), count(&color, [0, 0, 255, 255]));
    let texels = (SIZE.0 * SIZE.1) as usize;
    assert_eq!(near + far, texels, "every texel is covered");
    // The diagonal goes through texel centres here and there.
    assert!(near.abs_diff(texels / 2) <= SIZE.0 as usize, "{near} of {texels} texels are near");
    // Row 0 is the top, where y is -1: only the far triangle is there, but for the first texel.
    let last = (SIZE.0 as usize - 1) * 4;
    assert_eq!(color.bytes[last..last + 4], [0, 0, 255, 255]);
    let depths = depth.to_f32().unwrap();
    assert_eq!(depths.iter().filter(|d| **d == 0.75).count(), near);
    assert_eq!(depths.iter().filter(|d| **d == 0.25).count(), far);
}

#[test]
fn culled_triangles_leave_the_background() {
    let Some(context) = device() else { return };
    let faces = [vk::CullModeFlags::BACK, vk::CullModeFlags::FRONT];
    let drawn: Vec<usize> = faces
        .iter()
        .map(|cull| {
            let (color, _) = draw(&context, &Scene::new(&context, *cull));
            count(&color, [255, 128, 0, 255])
        })
        .collect();
    assert_eq!(drawn.iter().filter(|texels| **texels == 0).count(), 1, "one side only: {drawn:?}");
}

#[test]
fn compute_and_copies_while_rendering_are_errors() {
    let Some(context) = device() else { return };
    let scene = Scene::new(&context, vk::CullModeFlags::NONE);
    let mut commands = Commands::new(&context, "rendering").unwrap();
    commands.begin().unwrap();
    let view = scene.color.view();
    commands.ready(&[view.anew(Access::ColorTarget)]).unwrap();
    assert!(commands.begin_rendering(&[], None).is_err(), "no target");
    commands.begin_rendering(&[ColorTarget { view, clear: None }], None).unwrap();
    assert!(commands.zone("draw", |_| Ok(())).is_err());
    assert!(commands.dispatch(1, 1, 1).is_err());
    assert!(commands.fill_buffer(&scene.vertices, 0, 4, 0).is_err());
    assert!(commands.submit_and_wait().is_err(), "still rendering");
    commands.end_rendering().unwrap();
    commands.submit_and_wait().unwrap();
}
