//! Stage `edges`: one sample of the ground a pixel from several, and where the others show something else. Shader: `edges.frag`.

use super::targets::{Targets, DEPTH_FORMAT, EDGE_FORMAT, SCENE_FORMAT};
use crate::shaders;
use crate::vulkan::{
    vk, Access, ColorTarget, Commands, Context, DepthTarget, DepthTest, GraphicsDescription, GraphicsPipeline, Resource, Result,
};
use std::sync::Arc;

/// The stage's pipeline.
pub(super) struct Edges {
    pipeline: GraphicsPipeline,
}

impl Edges {
    /// Builds the pipeline for targets of so many samples.
    pub(super) fn new(context: &Arc<Context>, samples: u32) -> Result<Edges> {
        let formats = [SCENE_FORMAT, EDGE_FORMAT];
        let mut description = GraphicsDescription::new(shaders::FULLSCREEN_VERT, Some(shaders::EDGES_FRAG), &formats);
        description.depth_format = Some(DEPTH_FORMAT);
        description.depth = Some(DepthTest { compare: vk::CompareOp::ALWAYS, write: true });
        let constants = [(0, samples)];
        description.specialization = &constants;
        Ok(Edges { pipeline: GraphicsPipeline::new(context, "edges", &description)? })
    }

    /// Records the stage: reads the samples, fills `targets.ground`, `targets.depth` and `targets.edges`.
    pub(super) fn record(&self, commands: &mut Commands, targets: &Targets) -> Result<()> {
        let Some(samples) = &targets.samples else { return Ok(()) };
        commands.ready(&[
            samples.ground.view().to(Access::Sampled),
            samples.depth.view().to(Access::Sampled),
            targets.ground.view().anew(Access::ColorTarget),
            targets.edges.view().anew(Access::ColorTarget),
            targets.depth.view().anew(Access::DepthTarget),
        ])?;
        let color = |view| ColorTarget { view, clear: Some([0.0; 4]) };
        commands.begin_rendering(
            &[color(targets.ground.view()), color(targets.edges.view())],
            Some(DepthTarget { view: targets.depth.view(), clear: Some(0.0) }),
        )?;
        commands.bind(
            &self.pipeline,
            &[
                ("ground_samples", Resource::Sampled(samples.ground.view(), &targets.nearest)),
                ("depth_samples", Resource::Sampled(samples.depth.view(), &targets.nearest)),
            ],
        )?;
        commands.draw(3, 1)?;
        commands.end_rendering()
    }
}
