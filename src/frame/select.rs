//! Stage `select`: awake bits and drawn positions of every vertex in reach. Shader: `select.comp`. Twin: `reference/select.rs`.

use super::buffers::FrameBuffers;
use crate::shaders;
use crate::vulkan::{Access, Commands, ComputePipeline, Context, Resource, Result};
use std::sync::Arc;

/// Subgroups at least this wide make a word of awake bits with one ballot; narrower ones do better with 32 vertices an
/// invocation (docs/design.md, "Stages on a software renderer").
const BALLOT_WIDTH: u32 = 32;

/// The stage's pipeline.
pub(super) struct Select {
    pipeline: ComputePipeline,
}

impl Select {
    /// Builds the pipeline, in the variant that suits the device.
    pub(super) fn new(context: &Arc<Context>) -> Result<Select> {
        let ballot = u32::from(context.device_info().subgroup_size >= BALLOT_WIDTH);
        Ok(Select { pipeline: ComputePipeline::new(context, &shaders::SELECT_COMP, &[(0, ballot)])? })
    }

    /// Records the stage: fills `buffers.awake` and `buffers.drawn_positions`, and counts the awake vertices.
    pub(super) fn record(&self, commands: &mut Commands, buffers: &FrameBuffers) -> Result<()> {
        let tasks = &buffers.tasks().select;
        commands
            .ready(&[&buffers.awake, &buffers.drawn_positions, &buffers.state].map(|buffer| buffer.to(Access::ComputeWrite)))?;
        commands.bind(
            &self.pipeline,
            &[
                ("View", Resource::Storage(buffers.view())),
                ("Patches", Resource::Storage(buffers.patches())),
                ("Tasks", Resource::Storage(&tasks.buffer)),
                ("Awake", Resource::Storage(&buffers.awake)),
                ("State", Resource::Storage(&buffers.state)),
                ("DrawnPositions", Resource::Storage(&buffers.drawn_positions)),
            ],
        )?;
        commands.push_constants(&tasks.count)?;
        commands.dispatch_rows(tasks.count)
    }
}
