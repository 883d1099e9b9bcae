//! Compute pipelines.

use std::sync::Arc;

use ash::vk;

use super::layout::{Bindable, RawPipeline, RawPipelineRef, Specialization};
use super::reflection::Reflection;
use super::shader::{current_words, Module, Shader};
use crate::vulkan::error::{api, Result, VulkanError};
use crate::vulkan::Context;

/// A compute shader with its layout.
pub struct ComputePipeline {
    raw: Arc<RawPipeline>,
    workgroup_size: [u32; 3],
}

impl ComputePipeline {
    /// Creates a pipeline, named for its shader, with specialization constants (id, value).
    ///
    /// # Errors
    /// A shader that is not a compute shader, or that the device cannot run.
    pub fn new(context: &Arc<Context>, shader: &Shader<'_>, specialization: &[(u32, u32)]) -> Result<Self> {
        let words = current_words(context, shader, specialization)?;
        let shader = &Shader { name: shader.name, words: &words };
        let reflection = Reflection::new(shader, specialization)?;
        if reflection.stage != vk::ShaderStageFlags::COMPUTE {
            let problem = format!("it is for {:?}, not COMPUTE", reflection.stage);
            return Err(VulkanError::Shader { shader: shader.name.to_owned(), problem });
        }
        let workgroup_size = reflection.workgroup_size;
        check_workgroup(context, shader, workgroup_size)?;
        let point = vk::PipelineBindPoint::COMPUTE;
        let mut raw = RawPipeline::new(context, shader.name, point, &[reflection])?;
        let module = Module::new(context, shader)?;
        let specialization = Specialization::new(specialization);
        let specialization = specialization.info();
        // Unless told, devices may choose other sizes than the one they name.
        let subgroup = context.device_info().subgroup_size;
        let mut required = vk::PipelineShaderStageRequiredSubgroupSizeCreateInfo::default().required_subgroup_size(subgroup);
        let mut stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.handle)
            .name(c"main")
            .specialization_info(&specialization);
        let invocations: u32 = workgroup_size.iter().product();
        if invocations <= subgroup.saturating_mul(context.gpu().most_subgroups) {
            stage = stage.push_next(&mut required);
            if workgroup_size[0].is_multiple_of(subgroup) {
                stage = stage.flags(vk::PipelineShaderStageCreateFlags::REQUIRE_FULL_SUBGROUPS);
            }
        }
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(raw.layout);
        let cache = vk::PipelineCache::null();
        // SAFETY: module, layout and specialization outlive the call.
        let created = unsafe { context.device().create_compute_pipelines(cache, &[info], None) };
        let created = created.map_err(|(_, result)| api("vkCreateComputePipelines")(result))?;
        raw.handle = created[0];
        context.set_name(raw.handle, shader.name);
        Ok(Self { raw: Arc::new(raw), workgroup_size })
    }

    /// Invocations of a workgroup in x, y and z, after specialization.
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.workgroup_size
    }

    /// Workgroups needed for so many invocations in x.
    pub fn workgroups(&self, invocations: u32) -> u32 {
        invocations.div_ceil(self.workgroup_size[0].max(1))
    }
}

impl Bindable for ComputePipeline {
    fn raw(&self) -> RawPipelineRef<'_> {
        RawPipelineRef(&self.raw)
    }
}

fn check_workgroup(context: &Context, shader: &Shader<'_>, size: [u32; 3]) -> Result<()> {
    let most = context.limits().max_compute_work_group_size;
    let total = context.limits().max_compute_work_group_invocations;
    let fits = size.iter().zip(most).all(|(side, most)| (1..=most).contains(side));
    if fits && size.iter().product::<u32>() <= total {
        return Ok(());
    }
    let problem = format!("a workgroup of {size:?}; the limits are {most:?} and {total} in all");
    Err(VulkanError::Shader { shader: shader.name.to_owned(), problem })
}
