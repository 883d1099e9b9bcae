//! The buffers that a frame's stages share: what the CPU writes (one set for each frame in flight) and what the GPU writes
//! (one set: frames follow each other on the queue). They grow as needed and never shrink.

use super::tables::{FrameTables, MeshTasks};
use crate::vulkan::{Access, Buffer, Commands, Context, Memory, Result, Usage, FRAMES_IN_FLIGHT};
use std::sync::Arc;
use terrane_planet::draw::layout::{DrawnVertex, EmitState, FrameView, Shading, Task};

/// Most triangles a frame emits unless told otherwise; more are counted, not drawn, and reported.
pub const MAX_TRIANGLES: u32 = 6_000_000;

/// What the CPU writes for one frame.
struct Inputs {
    view: Buffer,
    shading: Buffer,
    reset: Buffer,
    patches: Buffer,
    tasks: MeshTasks<Tasks>,
    /// The emit state, read back.
    readback: Buffer,
}

/// The tasks of a stage on the GPU.
pub(super) struct Tasks {
    /// The tasks.
    pub(super) buffer: Buffer,
    /// How many of them there are.
    pub(super) count: u32,
}

/// All buffers of a renderer.
pub struct FrameBuffers {
    context: Arc<Context>,
    inputs: Vec<Inputs>,
    slot: usize,
    /// Most triangles a frame emits (at least 1); more are counted, not drawn, and reported.
    pub max_triangles: u32,
    /// Awake bits, GPU-written.
    pub awake: Buffer,
    /// Resolved vertices, GPU-written.
    pub resolved: Buffer,
    /// Drawn vertices, GPU-written, at the offsets of the resolved ones.
    pub drawn_positions: Buffer,
    /// Emitted triangles, GPU-written.
    pub indices: Buffer,
    /// Counters and the indirect draw, GPU-written.
    pub state: Buffer,
}

impl FrameBuffers {
    /// Small buffers to begin with.
    pub fn new(context: &Arc<Context>) -> Result<FrameBuffers> {
        let inputs = (0..FRAMES_IN_FLIGHT).map(|_| Inputs::new(context)).collect::<Result<Vec<_>>>()?;
        Ok(FrameBuffers {
            context: context.clone(),
            inputs,
            slot: 0,
            max_triangles: MAX_TRIANGLES,
            awake: storage(context, "awake", 4096)?,
            resolved: storage(context, "resolved", 4096)?,
            drawn_positions: storage(context, "drawn positions", 4096)?,
            indices: indices(context, 1024)?,
            state: Buffer::new(
                context,
                "emit state",
                bytes_of::<EmitState>(),
                Usage::STORAGE_BUFFER | Usage::INDIRECT_BUFFER,
                Memory::Device,
            )?,
        })
    }

    /// Writes the inputs of the next frame into the slot that is free, and makes everything large enough. The frame before the
    /// last must have finished.
    pub fn write(&mut self, tables: &FrameTables, view: &FrameView, shading: &Shading) -> Result<()> {
        self.slot = (self.slot + 1) % self.inputs.len();
        let capacity = tables.triangles.clamp(1, self.max_triangles.max(1));
        let context = self.context.clone();
        grow(&mut self.awake, 4 * u64::from(tables.awake_words), |bytes| storage(&context, "awake", bytes))?;
        grow(&mut self.resolved, 4 * u64::from(tables.vertices), |bytes| storage(&context, "resolved", bytes))?;
        let drawn = bytes_of::<DrawnVertex>() * u64::from(tables.vertices);
        grow(&mut self.drawn_positions, drawn, |bytes| storage(&context, "drawn positions", bytes))?;
        grow(&mut self.indices, 12 * u64::from(capacity), |bytes| indices(&context, bytes))?;
        self.inputs[self.slot].write(&context, tables, view, shading, capacity)
    }

    /// Device-side reset of the counters for this frame.
    pub fn record_reset(&self, commands: &mut Commands) -> Result<()> {
        commands.ready(&[self.state.to(Access::TransferWrite)])?;
        commands.copy_buffer((&self.input().reset, 0), (&self.state, 0), bytes_of::<EmitState>())
    }

    /// Copies the counters to where [`FrameBuffers::counters`] finds them.
    pub fn record_readback(&self, commands: &mut Commands) -> Result<()> {
        commands.ready(&[self.state.to(Access::TransferRead)])?;
        commands.copy_buffer((&self.state, 0), (&self.input().readback, 0), bytes_of::<EmitState>())
    }

    /// Counters of the latest frame; wait for it first.
    pub fn counters(&self) -> Result<EmitState> {
        Ok(self.input().readback.read::<EmitState>(0, 1)?.first().copied().unwrap_or_default())
    }

    /// Counters of the frame that used the slot which is next to be written; wait for it first.
    pub fn earlier_counters(&self) -> Result<EmitState> {
        let earlier = &self.inputs[(self.slot + 1) % self.inputs.len()];
        Ok(earlier.readback.read::<EmitState>(0, 1)?.first().copied().unwrap_or_default())
    }

    fn input(&self) -> &Inputs {
        &self.inputs[self.slot]
    }

    /// The view of this frame.
    pub fn view(&self) -> &Buffer {
        &self.input().view
    }

    /// The shading of this frame.
    pub fn shading(&self) -> &Buffer {
        &self.input().shading
    }

    /// The patches of this frame.
    pub fn patches(&self) -> &Buffer {
        &self.input().patches
    }

    /// Tasks of the mesh stages.
    pub(super) fn tasks(&self) -> &MeshTasks<Tasks> {
        &self.input().tasks
    }
}

impl Inputs {
    fn new(context: &Arc<Context>) -> Result<Inputs> {
        Ok(Inputs {
            view: block(context, "view", bytes_of::<FrameView>())?,
            shading: block(context, "shading", bytes_of::<Shading>())?,
            reset: upload(context, "emit reset", bytes_of::<EmitState>())?,
            patches: upload(context, "patches", 4096)?,
            tasks: MeshTasks {
                select: Tasks::new(context, "select tasks")?,
                resolve: Tasks::new(context, "resolve tasks")?,
                emit: Tasks::new(context, "emit tasks")?,
            },
            readback: Buffer::new(context, "emit readback", bytes_of::<EmitState>(), Usage::TRANSFER_DST, Memory::Readback)?,
        })
    }

    fn write(
        &mut self,
        context: &Arc<Context>,
        tables: &FrameTables,
        view: &FrameView,
        shading: &Shading,
        capacity: u32,
    ) -> Result<()> {
        self.view.write(0, &[*view])?;
        self.shading.write(0, &[*shading])?;
        self.reset.write(0, &[EmitState { capacity, instance_count: 1, ..EmitState::default() }])?;
        grow(&mut self.patches, std::mem::size_of_val(tables.patches.as_slice()) as u64, |bytes| {
            upload(context, "patches", bytes)
        })?;
        self.patches.write(0, &tables.patches)?;
        self.tasks.select.write(context, "select tasks", &tables.tasks.select)?;
        self.tasks.resolve.write(context, "resolve tasks", &tables.tasks.resolve)?;
        self.tasks.emit.write(context, "emit tasks", &tables.tasks.emit)
    }
}

impl Tasks {
    fn new(context: &Arc<Context>, name: &str) -> Result<Tasks> {
        Ok(Tasks { buffer: upload(context, name, 4096)?, count: 0 })
    }

    fn write(&mut self, context: &Arc<Context>, name: &str, tasks: &[Task]) -> Result<()> {
        grow(&mut self.buffer, size_of_val(tasks) as u64, |bytes| upload(context, name, bytes))?;
        self.buffer.write(0, tasks)?;
        self.count = tasks.len() as u32;
        Ok(())
    }
}

fn bytes_of<T>() -> u64 {
    size_of::<T>() as u64
}

fn upload(context: &Arc<Context>, name: &str, bytes: u64) -> Result<Buffer> {
    Buffer::new(context, name, bytes, Usage::STORAGE_BUFFER, Memory::Upload)
}

/// A block of values that shaders read as storage or, where pixels do, as uniforms.
fn block(context: &Arc<Context>, name: &str, bytes: u64) -> Result<Buffer> {
    Buffer::new(context, name, bytes, Usage::STORAGE_BUFFER | Usage::UNIFORM_BUFFER, Memory::Upload)
}

fn storage(context: &Arc<Context>, name: &str, bytes: u64) -> Result<Buffer> {
    Buffer::new(context, name, bytes, Usage::STORAGE_BUFFER, Memory::Device)
}

fn indices(context: &Arc<Context>, bytes: u64) -> Result<Buffer> {
    Buffer::new(context, "indices", bytes, Usage::STORAGE_BUFFER | Usage::INDEX_BUFFER, Memory::Device)
}

/// Replaces a buffer that is too small by one half as large again as needed.
fn grow(buffer: &mut Buffer, bytes: u64, create: impl FnOnce(u64) -> Result<Buffer>) -> Result<()> {
    if bytes > buffer.bytes() {
        *buffer = create((bytes + bytes / 2).next_multiple_of(16))?;
    }
    Ok(())
}
