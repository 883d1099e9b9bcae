//! A command buffer with its fence and timestamps: begin, record, submit, wait; then again.
//!
//! What is recorded is in `recording.rs` (compute, barriers), `copies.rs` and `rendering.rs` (drawing).

pub(super) mod accesses;
pub(super) mod copies;
pub(super) mod recording;
pub(super) mod rendering;
pub(super) mod synchronization;
pub(super) mod timestamps;

use std::any::Any;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;

use crate::vulkan::error::{api, Result, VulkanError};
use crate::vulkan::pipelines::layout::RawPipeline;
use crate::vulkan::Context;
use accesses::Accesses;
use timestamps::{Queries, Timestamps};

/// How long to wait for the GPU; a frame of a software renderer takes seconds at worst. Past it: `Timeout`.
pub(crate) const WAIT_LIMIT: Duration = Duration::from_secs(120);

/// Semaphores of a submission, both optional.
#[derive(Debug, Clone, Copy, Default)]
pub struct Submission {
    /// Stages wait for this.
    pub(crate) wait: Option<(vk::Semaphore, vk::PipelineStageFlags2)>,
    /// Signalled when everything is done.
    pub(crate) signal: Option<vk::Semaphore>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Idle,
    Recording,
    Submitted,
}

/// Records commands and runs them. Keeps alive everything that they use, until they are done.
pub struct Commands {
    pub(crate) context: Arc<Context>,
    name: String,
    pool: vk::CommandPool,
    handle: vk::CommandBuffer,
    fence: vk::Fence,
    pub(crate) queries: Queries,
    state: State,
    submitted_at: Instant,
    pub(crate) kept: Vec<Arc<dyn Any + Send + Sync>>,
    pub(crate) bound: Option<Arc<RawPipeline>>,
    pub(crate) rendering: bool,
    accesses: Accesses,
}

impl Commands {
    /// Creates commands that are not yet begun.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(context: &Arc<Context>, name: &str) -> Result<Self> {
        let queries = Queries::new(context)?;
        let mut commands = Self {
            context: context.clone(),
            name: name.to_owned(),
            pool: vk::CommandPool::null(),
            handle: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries,
            state: State::Idle,
            submitted_at: Instant::now(),
            kept: Vec::new(),
            bound: None,
            rendering: false,
            accesses: Accesses::default(),
        };
        commands.create()?;
        Ok(commands)
    }

    /// Records with `record`, submits and waits.
    ///
    /// # Errors
    /// Those of `record`, and of [`wait`](Self::wait).
    pub fn once(context: &Arc<Context>, name: &str, record: impl FnOnce(&mut Self) -> Result<()>) -> Result<Timestamps> {
        let mut commands = Self::new(context, name)?;
        commands.begin()?;
        record(&mut commands)?;
        commands.submit_and_wait()
    }

    /// Starts recording, after waiting for an earlier submission of these commands. All that earlier submissions wrote
    /// is visible.
    ///
    /// # Errors
    /// Those of [`wait`](Self::wait).
    pub fn begin(&mut self) -> Result<()> {
        if self.state == State::Submitted {
            self.wait()?;
        }
        self.forget();
        let device = self.context.device();
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool's only buffer is not in use: it was waited for.
        unsafe {
            device.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty()).map_err(api("vkResetCommandPool"))?;
            device.begin_command_buffer(self.handle, &info).map_err(api("vkBeginCommandBuffer"))?;
        }
        self.state = State::Recording;
        self.queries.reset(self.handle);
        // One barrier between submissions, rather than one for each resource that crosses them.
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let read_write = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        self.memory_barrier(all, vk::AccessFlags2::MEMORY_WRITE, all, read_write)
    }

    /// Submits and waits until the GPU is done.
    ///
    /// # Errors
    /// Those of [`submit`](Self::submit) and [`wait`](Self::wait).
    pub fn submit_and_wait(&mut self) -> Result<Timestamps> {
        self.submit(&Submission::default())?;
        self.wait()
    }

    /// Ends recording and submits. What was written is visible to the host after [`wait`](Self::wait).
    ///
    /// # Errors
    /// Not recording, still rendering, or device loss.
    pub fn submit(&mut self, submission: &Submission) -> Result<()> {
        if self.rendering {
            return Err(self.misuse("submitted between begin_rendering and end_rendering"));
        }
        self.memory_barrier(
            vk::PipelineStageFlags2::ALL_COMMANDS,
            vk::AccessFlags2::MEMORY_WRITE,
            vk::PipelineStageFlags2::HOST,
            vk::AccessFlags2::HOST_READ,
        )?;
        self.state = State::Idle;
        let device = self.context.device();
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let semaphore = |semaphore, stages| vk::SemaphoreSubmitInfo::default().semaphore(semaphore).stage_mask(stages);
        let waits: Vec<_> = submission.wait.iter().map(|(s, stages)| semaphore(*s, *stages)).collect();
        let signals: Vec<_> = submission.signal.iter().map(|s| semaphore(*s, all)).collect();
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(self.handle)];
        let info = vk::SubmitInfo2::default()
            .wait_semaphore_infos(&waits)
            .signal_semaphore_infos(&signals)
            .command_buffer_infos(&buffers);
        // Taken before: a software renderer begins within the call.
        self.submitted_at = Instant::now();
        // SAFETY: the buffer is recording and its resources are kept; fence and queue are not in use elsewhere.
        let submitted = unsafe {
            device.end_command_buffer(self.handle).map_err(api("vkEndCommandBuffer"))?;
            device.reset_fences(&[self.fence]).map_err(api("vkResetFences"))?;
            let queue = self.context.queue();
            device.queue_submit2(*queue, &[info], self.fence)
        };
        submitted.map_err(|result| self.failed("vkQueueSubmit2", result))?;
        self.state = State::Submitted;
        Ok(())
    }

    /// Waits for the submission and returns the times of its zones.
    ///
    /// # Errors
    /// Nothing submitted, device loss, or the GPU takes more than two minutes.
    pub fn wait(&mut self) -> Result<Timestamps> {
        if self.state != State::Submitted {
            return Err(self.misuse("waited for without a submission"));
        }
        let _span = tracing::trace_span!("wait", commands = %self.name).entered();
        let nanoseconds = WAIT_LIMIT.as_nanos() as u64;
        // SAFETY: the fence belongs to the submission.
        unsafe { self.context.device().wait_for_fences(&[self.fence], true, nanoseconds) }
            .map_err(|result| self.failed("vkWaitForFences", result))?;
        self.state = State::Idle;
        let wall = self.submitted_at.elapsed();
        let timestamps = self.queries.resolve(wall)?;
        self.forget();
        Ok(timestamps)
    }

    /// Whether a submission is still to be waited for.
    pub fn is_pending(&self) -> bool {
        self.state == State::Submitted
    }

    /// Name, as in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The command buffer, if it is being recorded.
    pub(crate) fn recorder(&self) -> Result<vk::CommandBuffer> {
        match self.state {
            State::Recording => Ok(self.handle),
            _ => Err(self.misuse("recorded before begin")),
        }
    }

    pub(crate) fn misuse(&self, problem: &str) -> VulkanError {
        VulkanError::Commands { commands: self.name.clone(), problem: problem.to_owned() }
    }

    fn failed(&self, call: &'static str, result: vk::Result) -> VulkanError {
        let zone = self.queries.last_begun();
        match result {
            vk::Result::ERROR_DEVICE_LOST => VulkanError::DeviceLost { zone },
            vk::Result::TIMEOUT => VulkanError::Timeout { what: self.name.clone(), seconds: WAIT_LIMIT.as_secs(), zone },
            result => api(call)(result),
        }
    }

    fn forget(&mut self) {
        self.kept.clear();
        self.bound = None;
        self.rendering = false;
        self.accesses.clear();
    }

    fn create(&mut self) -> Result<()> {
        let device = self.context.device();
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(self.context.gpu().queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device is alive.
        self.pool = unsafe { device.create_command_pool(&info, None) }.map_err(api("vkCreateCommandPool"))?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        // SAFETY: the pool is alive.
        let buffers = unsafe { device.allocate_command_buffers(&info) }.map_err(api("vkAllocateCommandBuffers"))?;
        self.handle = buffers[0];
        // SAFETY: the device is alive.
        self.fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }.map_err(api("vkCreateFence"))?;
        self.context.set_name(self.handle, &self.name);
        Ok(())
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        if self.state == State::Submitted && self.wait().is_err() {
            // Late or lost: this returns when the device no longer uses what is dropped next.
            let _ = self.context.wait_idle();
        }
        let device = self.context.device();
        // SAFETY: nothing is in use any more; null handles are ignored.
        unsafe {
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}
