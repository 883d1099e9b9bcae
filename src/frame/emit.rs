//! Stage `emit`: the triangles to draw, compacted into one index buffer with its indirect draw. Shaders: `emit.comp`,
//! `arguments.comp`. Twin: `reference/emit.rs`.

use super::buffers::FrameBuffers;
use crate::shaders;
use crate::vulkan::{Access, Commands, ComputePipeline, Context, Resource, Result};
use std::sync::Arc;

/// The stage's pipelines.
pub(super) struct Emit {
    emit: ComputePipeline,
    arguments: ComputePipeline,
}

impl Emit {
    /// Builds the pipelines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Emit> {
        Ok(Emit {
            emit: ComputePipeline::new(context, &shaders::EMIT_COMP, &[])?,
            arguments: ComputePipeline::new(context, &shaders::ARGUMENTS_COMP, &[])?,
        })
    }

    /// Records the stage: reads `buffers.resolved` and `buffers.drawn_positions`, fills `buffers.indices` and `buffers.state`.
    pub(super) fn record(&self, commands: &mut Commands, buffers: &FrameBuffers) -> Result<()> {
        let tasks = &buffers.tasks().emit;
        commands.ready(&[&buffers.resolved, &buffers.drawn_positions].map(|buffer| buffer.to(Access::ComputeRead)))?;
        commands.ready(&[&buffers.indices, &buffers.state].map(|buffer| buffer.to(Access::ComputeWrite)))?;
        commands.bind(
            &self.emit,
            &[
                ("View", Resource::Storage(buffers.view())),
                ("Patches", Resource::Storage(buffers.patches())),
                ("Tasks", Resource::Storage(&tasks.buffer)),
                ("Resolved", Resource::Storage(&buffers.resolved)),
                ("Indices", Resource::Storage(&buffers.indices)),
                ("State", Resource::Storage(&buffers.state)),
                ("DrawnPositions", Resource::Storage(&buffers.drawn_positions)),
            ],
        )?;
        commands.push_constants(&tasks.count)?;
        commands.dispatch_rows(tasks.count)?;
        commands.ready(&[buffers.state.to(Access::ComputeWrite)])?;
        commands.bind(&self.arguments, &[("State", Resource::Storage(&buffers.state))])?;
        commands.dispatch(1, 1, 1)
    }
}
