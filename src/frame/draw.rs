//! Stage `draw`: one indexed indirect draw of all patches, with vertex pulling, into colour and reversed-Z depth. Shaders:
//! `draw.vert`, `draw.frag`; `wire.frag` for the mesh's edges.

use super::buffers::FrameBuffers;
use super::passed::{Drawn, Shared};
use super::targets::{DEPTH_FORMAT, RADIANCE_FORMAT};
use crate::shaders;
use crate::vulkan::{
    vk, Access, Blend, ColorTarget, Commands, Context, DepthTarget, DepthTest, GraphicsDescription, GraphicsPipeline, ImageView,
    Resource, Result,
};
use std::sync::Arc;
use terrane_planet::draw::layout::EmitState;

/// Byte offset of the indirect draw in the emit state.
const ARGUMENTS_OFFSET: u64 = std::mem::offset_of!(EmitState, index_count) as u64;

/// Factor on the reversed depth of lines: they win against the surface they lie on, and against nothing a thousandth nearer.
const LINE_LIFT: f32 = 1.001;

/// The stage's pipelines.
pub(super) struct Draw {
    fill: GraphicsPipeline,
    lines: GraphicsPipeline,
}

impl Draw {
    /// Builds the pipelines.
    pub(super) fn new(context: &Arc<Context>, samples: u32) -> Result<Draw> {
        let formats = [RADIANCE_FORMAT];
        let mut description = GraphicsDescription::new(shaders::DRAW_VERT, Some(shaders::DRAW_FRAG), &formats);
        description.depth_format = Some(DEPTH_FORMAT);
        description.depth = Some(DepthTest { compare: vk::CompareOp::GREATER_OR_EQUAL, write: true });
        description.cull = vk::CullModeFlags::BACK;
        description.samples = samples;
        let fill = GraphicsPipeline::new(context, "draw", &description)?;
        description.samples = 1;
        description.fragment = Some(shaders::WIRE_FRAG);
        description.polygon = vk::PolygonMode::LINE;
        description.depth = Some(DepthTest { compare: vk::CompareOp::GREATER_OR_EQUAL, write: false });
        description.blend = Blend::Alpha;
        let lift = [(0, LINE_LIFT.to_bits())];
        description.specialization = &lift;
        let lines = GraphicsPipeline::new(context, "draw lines", &description)?;
        Ok(Draw { fill, lines })
    }

    /// Records the stage: the lit ground and its depth.
    pub(super) fn record<'a>(&self, commands: &mut Commands, shared: &Shared<'a>) -> Result<Drawn<'a>> {
        let drawn = shared.targets.drawn();
        ready_geometry(commands, shared.buffers)?;
        commands.ready(&[drawn.color.anew(Access::ColorTarget), drawn.depth.anew(Access::DepthTarget)])?;
        commands.begin_rendering(
            &[ColorTarget { view: drawn.color, clear: Some([0.0; 4]) }],
            Some(DepthTarget { view: drawn.depth, clear: Some(0.0) }),
        )?;
        let (geometry, textures) = (geometry(shared.buffers), shared.scene.textures());
        let shading = [
            ("slopes", Resource::Sampled(textures.slopes.view(), &textures.sampler)),
            ("albedo", Resource::Sampled(textures.albedo.view(), &textures.sampler)),
            ("relief", Resource::Sampled(textures.relief.view(), &textures.sampler)),
            shared.tiles.grain(),
        ];
        let (air, clouds) = (shared.air.light(), shared.scene.clouds().bound());
        commands.bind(&self.fill, &[geometry.as_slice(), &shading, &air, &clouds].concat())?;
        draw_mesh(commands, shared.buffers)?;
        commands.end_rendering()?;
        Ok(drawn)
    }

    /// Records the mesh's edges over `water`, hidden by `depth`.
    pub(super) fn record_lines(
        &self,
        commands: &mut Commands,
        shared: &Shared<'_>,
        water: &ImageView,
        depth: &ImageView,
    ) -> Result<()> {
        ready_geometry(commands, shared.buffers)?;
        commands.ready(&[water.to(Access::ColorTarget), depth.to(Access::DepthTarget)])?;
        commands.begin_rendering(&[ColorTarget { view: water, clear: None }], Some(DepthTarget { view: depth, clear: None }))?;
        commands.bind(&self.lines, &geometry(shared.buffers))?;
        draw_mesh(commands, shared.buffers)?;
        commands.end_rendering()
    }
}

/// Makes ready what the mesh stages wrote.
fn ready_geometry(commands: &mut Commands, buffers: &FrameBuffers) -> Result<()> {
    commands.ready(&[
        buffers.resolved.to(Access::GraphicsRead),
        buffers.drawn_positions.to(Access::GraphicsRead),
        buffers.indices.to(Access::IndexRead),
        buffers.state.to(Access::IndirectRead),
    ])
}

/// Draws the emitted triangles.
fn draw_mesh(commands: &mut Commands, buffers: &FrameBuffers) -> Result<()> {
    commands.draw_indexed_indirect(&buffers.indices, &buffers.state, ARGUMENTS_OFFSET)
}

/// What the vertex shader reads.
fn geometry(buffers: &FrameBuffers) -> [(&'static str, Resource<'_>); 5] {
    [
        ("ShadingBlock", Resource::Uniform(buffers.shading())),
        ("Resolved", Resource::Storage(&buffers.resolved)),
        ("View", Resource::Uniform(buffers.view())),
        ("Patches", Resource::Storage(buffers.patches())),
        ("DrawnPositions", Resource::Storage(&buffers.drawn_positions)),
    ]
}
