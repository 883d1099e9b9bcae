//! A pass over every pixel: one triangle that covers the picture, and a fragment shader. Shader: `fullscreen.vert`.

use crate::shaders;
use crate::vulkan::{
    vk, Access, ColorTarget, Commands, Context, DepthTarget, GraphicsDescription, GraphicsPipeline, ImageView, Resource, Result,
    Shader,
};
use std::sync::Arc;

/// The pipeline of such a pass.
pub(super) struct Fullscreen {
    pipeline: GraphicsPipeline,
}

impl Fullscreen {
    /// Where the description of a fragment shader begins that writes colour targets of some formats.
    pub(super) fn description<'a>(fragment: Shader<'a>, formats: &'a [vk::Format]) -> GraphicsDescription<'a> {
        GraphicsDescription::new(shaders::FULLSCREEN_VERT, Some(fragment), formats)
    }

    /// Builds the pipeline of a [`description`](Self::description).
    pub(super) fn described(context: &Arc<Context>, name: &str, description: &GraphicsDescription<'_>) -> Result<Fullscreen> {
        Ok(Fullscreen { pipeline: GraphicsPipeline::new(context, name, description)? })
    }

    /// Records the pass, which writes every pixel of its targets anew. The caller has made ready what it reads.
    pub(super) fn record(
        &self,
        commands: &mut Commands,
        colors: &[&ImageView],
        depth: Option<&ImageView>,
        resources: &[(&str, Resource<'_>)],
    ) -> Result<()> {
        let targets = colors.iter().map(|view| view.anew(Access::ColorTarget));
        let targets = targets.chain(depth.map(|view| view.anew(Access::DepthTarget)));
        commands.ready(&targets.collect::<Vec<_>>())?;
        let colors: Vec<_> = colors.iter().map(|view| ColorTarget { view, clear: Some([0.0; 4]) }).collect();
        commands.begin_rendering(&colors, depth.map(|view| DepthTarget { view, clear: Some(0.0) }))?;
        self.draw(commands, 1, resources)?;
        commands.end_rendering()
    }

    /// Draws so many triangles over the whole picture, while rendering.
    pub(super) fn draw(&self, commands: &mut Commands, count: u32, resources: &[(&str, Resource<'_>)]) -> Result<()> {
        commands.bind(&self.pipeline, resources)?;
        commands.draw(3, count)
    }
}
