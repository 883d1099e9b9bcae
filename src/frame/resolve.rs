//! Stage `resolve`: the vertex that each vertex is drawn as. Shader: `resolve.comp`. Twin: `reference/resolve.rs`.

use super::buffers::FrameBuffers;
use crate::shaders;
use crate::vulkan::{Access, Commands, ComputePipeline, Context, Resource, Result};
use std::sync::Arc;

/// The stage's pipeline.
pub(super) struct Resolve {
    pipeline: ComputePipeline,
}

impl Resolve {
    /// Builds the pipeline.
    pub(super) fn new(context: &Arc<Context>) -> Result<Resolve> {
        Ok(Resolve { pipeline: ComputePipeline::new(context, &shaders::RESOLVE_COMP, &[])? })
    }

    /// Records the stage: reads `buffers.awake`, fills `buffers.resolved`.
    pub(super) fn record(&self, commands: &mut Commands, buffers: &FrameBuffers) -> Result<()> {
        let tasks = &buffers.tasks().resolve;
        commands.ready(&[buffers.awake.to(Access::ComputeRead), buffers.resolved.to(Access::ComputeWrite)])?;
        commands.bind(
            &self.pipeline,
            &[
                ("Patches", Resource::Storage(buffers.patches())),
                ("Tasks", Resource::Storage(&tasks.buffer)),
                ("Awake", Resource::Storage(&buffers.awake)),
                ("Resolved", Resource::Storage(&buffers.resolved)),
            ],
        )?;
        commands.push_constants(&tasks.count)?;
        commands.dispatch_rows(tasks.count)
    }
}
