//! What commands record outside rendering: barriers, zones and compute.

use std::any::Any;
use std::ffi::CString;
use std::sync::Arc;

use ash::vk;
use bytemuck::NoUninit;

use super::synchronization::{union, Access};
use super::Commands;
use crate::vulkan::error::{Result, VulkanError};
use crate::vulkan::pipelines::layout::{Bindable, RawPipeline, Resource};
use crate::vulkan::resources::buffer::Buffer;
use crate::vulkan::resources::image::ImageView;

impl Commands {
    /// Keeps something alive until the commands are done, such as a buffer that is used by its address.
    pub fn keep(&mut self, buffer: &Buffer) {
        self.keep_raw(buffer.raw.clone());
    }

    pub(crate) fn keep_raw(&mut self, object: Arc<dyn Any + Send + Sync>) {
        self.kept.push(object);
    }

    /// Makes what `before` wrote visible to `after`, for all buffers and for images that keep their layout. For what is reached by
    /// address; [`ready`](Self::ready) knows the rest.
    ///
    /// # Errors
    /// Not recording, or rendering.
    pub fn barrier(&mut self, before: &[Access], after: &[Access]) -> Result<()> {
        let ((from, wrote), (to, reads)) = (union(before), union(after));
        self.memory_barrier(from, wrote, to, reads)
    }

    /// A barrier in Vulkan's own terms.
    ///
    /// # Errors
    /// Not recording, or rendering.
    pub fn memory_barrier(
        &mut self,
        source_stages: vk::PipelineStageFlags2,
        source_access: vk::AccessFlags2,
        stages: vk::PipelineStageFlags2,
        access: vk::AccessFlags2,
    ) -> Result<()> {
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(source_stages)
            .src_access_mask(source_access)
            .dst_stage_mask(stages)
            .dst_access_mask(access)];
        self.pipeline_barrier(&vk::DependencyInfo::default().memory_barriers(&barriers))
    }

    /// Labels and times what `body` records. Outside rendering only: timestamps need a barrier after them, or a dispatch
    /// may run before the timestamp that precedes it.
    ///
    /// # Errors
    /// Those of `body`; not recording, or rendering.
    pub fn zone<R>(&mut self, name: &str, body: impl FnOnce(&mut Self) -> Result<R>) -> Result<R> {
        let _span = tracing::trace_span!("record", zone = name).entered();
        let commands = self.outside_rendering()?;
        self.begin_label(commands, name);
        let number = self.queries.begin(commands, name);
        self.execution_barrier()?;
        let result = body(self)?;
        self.queries.end(commands, number);
        self.execution_barrier()?;
        self.end_label(commands);
        Ok(result)
    }

    /// Makes a pipeline current and gives it its resources, every binding by its name.
    ///
    /// # Errors
    /// A binding that is missing, unknown, given twice or of the wrong kind.
    pub fn bind(&mut self, pipeline: &impl Bindable, resources: &[(&str, Resource<'_>)]) -> Result<()> {
        let commands = self.recorder()?;
        let raw = pipeline.raw().0;
        let matched = raw.match_resources(resources)?;
        // SAFETY: the commands are recording, and the pipeline is kept below.
        unsafe { self.context.device().cmd_bind_pipeline(commands, raw.point, raw.handle) };
        self.push_resources(commands, raw, &matched);
        for (_, resource) in &matched {
            resource.keep(&mut self.kept);
        }
        self.kept.push(raw.clone());
        self.bound = Some(raw.clone());
        Ok(())
    }

    /// Sets the push constants of the bound pipeline; `values` must be of exactly their size.
    ///
    /// # Errors
    /// No pipeline, or another size.
    pub fn push_constants<T: NoUninit>(&mut self, values: &T) -> Result<()> {
        let commands = self.recorder()?;
        let Some(pipeline) = &self.bound else {
            return Err(self.misuse("push_constants before bind"));
        };
        let bytes = bytemuck::bytes_of(values);
        let expected = pipeline.push_constant_bytes as usize;
        if bytes.len() != expected || expected == 0 {
            return Err(VulkanError::Binding {
                pipeline: pipeline.name.clone(),
                binding: "push constants".to_owned(),
                problem: format!("{} bytes were given, it takes {expected}", bytes.len()),
            });
        }
        let (layout, stages) = (pipeline.layout, pipeline.stages);
        // SAFETY: the commands are recording, the layout is alive and takes these bytes.
        unsafe {
            self.context.device().cmd_push_constants(commands, layout, stages, 0, bytes);
        }
        Ok(())
    }

    /// Runs the bound compute pipeline on so many workgroups.
    ///
    /// # Errors
    /// No compute pipeline, or more workgroups than the device allows in one dimension.
    pub fn dispatch(&mut self, x: u32, y: u32, z: u32) -> Result<()> {
        let commands = self.outside_rendering()?;
        self.check_bound(vk::PipelineBindPoint::COMPUTE)?;
        let most = self.context.limits().max_compute_work_group_count;
        if [x, y, z].iter().zip(most).any(|(count, most)| *count > most) {
            let problem = format!("{x} × {y} × {z} workgroups; the limits are {most:?}");
            return Err(self.misuse(&problem));
        }
        // SAFETY: the commands are recording and a compute pipeline with its resources is bound.
        unsafe { self.context.device().cmd_dispatch(commands, x, y, z) };
        Ok(())
    }

    /// Runs at least `workgroups` workgroups, in rows if one dimension cannot hold them. The shader computes its number
    /// as `gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x` and must leave when that is `workgroups` or more.
    ///
    /// # Errors
    /// As [`dispatch`](Self::dispatch).
    pub fn dispatch_rows(&mut self, workgroups: u32) -> Result<()> {
        if workgroups == 0 {
            return Ok(());
        }
        let most = self.context.limits().max_compute_work_group_count[0];
        let rows = workgroups.div_ceil(most);
        self.dispatch(workgroups.div_ceil(rows), rows, 1)
    }

    pub(super) fn pipeline_barrier(&mut self, dependency: &vk::DependencyInfo<'_>) -> Result<()> {
        let commands = self.outside_rendering()?;
        // SAFETY: the commands are recording outside rendering; images are kept by the caller.
        unsafe { self.context.device().cmd_pipeline_barrier2(commands, dependency) };
        Ok(())
    }

    fn execution_barrier(&mut self) -> Result<()> {
        let (all, none) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::NONE);
        self.memory_barrier(all, none, all, none)
    }

    fn push_resources(&self, commands: vk::CommandBuffer, pipeline: &RawPipeline, matched: &[(u32, &Resource<'_>)]) {
        if matched.is_empty() {
            return;
        }
        let infos: Vec<_> = matched.iter().map(|(_, resource)| Info::new(resource)).collect();
        let writes: Vec<_> = matched.iter().zip(&infos).map(|((number, _), info)| info.write(*number)).collect();
        let (point, layout) = (pipeline.point, pipeline.layout);
        let functions = self.context.push_descriptor();
        // SAFETY: the commands are recording; layout and resources are alive and of the right kinds.
        unsafe { functions.cmd_push_descriptor_set(commands, point, layout, 0, &writes) };
    }

    pub(crate) fn check_bound(&self, point: vk::PipelineBindPoint) -> Result<()> {
        match &self.bound {
            Some(pipeline) if pipeline.point == point => Ok(()),
            _ => Err(self.misuse(&format!("no pipeline of the kind {point:?} is bound"))),
        }
    }

    pub(crate) fn outside_rendering(&self) -> Result<vk::CommandBuffer> {
        if self.rendering {
            return Err(self.misuse("this cannot be recorded while rendering"));
        }
        self.recorder()
    }

    fn begin_label(&self, commands: vk::CommandBuffer, name: &str) {
        let (Some(debug), Ok(name)) = (self.context.debug(), CString::new(name)) else {
            return;
        };
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: the commands are recording.
        unsafe { debug.cmd_begin_debug_utils_label(commands, &label) };
    }

    fn end_label(&self, commands: vk::CommandBuffer) {
        if let Some(debug) = self.context.debug() {
            // SAFETY: the commands are recording, and `zone` began a label.
            unsafe { debug.cmd_end_debug_utils_label(commands) };
        }
    }
}

/// Descriptor contents, in memory while they are pushed.
enum Info {
    Buffer(vk::DescriptorType, [vk::DescriptorBufferInfo; 1]),
    Image(vk::DescriptorType, [vk::DescriptorImageInfo; 1]),
}

impl Info {
    fn new(resource: &Resource<'_>) -> Self {
        let whole = |buffer: &Buffer| [vk::DescriptorBufferInfo::default().buffer(buffer.raw.handle).range(vk::WHOLE_SIZE)];
        let image = |view: &ImageView, access: Access| {
            let (_, _, layout) = access.parts();
            vk::DescriptorImageInfo::default().image_view(view.raw.handle).image_layout(layout)
        };
        match resource {
            Resource::Storage(buffer) => Self::Buffer(vk::DescriptorType::STORAGE_BUFFER, whole(buffer)),
            Resource::Uniform(buffer) => Self::Buffer(vk::DescriptorType::UNIFORM_BUFFER, whole(buffer)),
            Resource::Sampled(view, sampler) => {
                let info = image(view, Access::Sampled).sampler(sampler.raw.handle);
                Self::Image(vk::DescriptorType::COMBINED_IMAGE_SAMPLER, [info])
            }
            Resource::StorageImage(view) => {
                let info = image(view, Access::ComputeWrite);
                Self::Image(vk::DescriptorType::STORAGE_IMAGE, [info])
            }
        }
    }

    fn write(&self, number: u32) -> vk::WriteDescriptorSet<'_> {
        let write = vk::WriteDescriptorSet::default().dst_binding(number);
        match self {
            Self::Buffer(kind, info) => write.descriptor_type(*kind).buffer_info(info),
            Self::Image(kind, info) => write.descriptor_type(*kind).image_info(info),
        }
    }
}
