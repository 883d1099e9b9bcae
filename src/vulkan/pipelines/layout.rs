//! Pipeline layouts made from reflection, and the resources that are pushed into them by name.

use std::any::Any;
use std::sync::Arc;

use ash::vk;

use super::reflection::{Binding, BindingKind, Reflection};
use crate::vulkan::error::{api, Result, VulkanError};
use crate::vulkan::resources::buffer::{Buffer, Usage};
use crate::vulkan::resources::image::ImageView;
use crate::vulkan::resources::sampler::Sampler;
use crate::vulkan::Context;

/// A resource for a binding.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// A whole buffer, for a `buffer` block.
    Storage(&'a Buffer),
    /// A whole buffer, for a `uniform` block.
    Uniform(&'a Buffer),
    /// An image that is in the layout of [`Access::Sampled`](crate::vulkan::Access::Sampled), and how to filter it.
    Sampled(&'a ImageView, &'a Sampler),
    /// An image that is in the layout of [`Access::ComputeWrite`](crate::vulkan::Access::ComputeWrite).
    StorageImage(&'a ImageView),
}

impl Resource<'_> {
    fn kind(&self) -> BindingKind {
        match self {
            Self::Storage(_) => BindingKind::Storage,
            Self::Uniform(_) => BindingKind::Uniform,
            Self::Sampled(..) => BindingKind::Sampled,
            Self::StorageImage(_) => BindingKind::StorageImage,
        }
    }

    /// What commands that use the resource must keep alive.
    pub(crate) fn keep(&self, kept: &mut Vec<Arc<dyn Any + Send + Sync>>) {
        match self {
            Self::Storage(buffer) | Self::Uniform(buffer) => kept.push(buffer.raw.clone()),
            Self::StorageImage(view) => kept.push(view.raw.clone()),
            Self::Sampled(view, sampler) => {
                kept.push(view.raw.clone());
                kept.push(sampler.raw.clone());
            }
        }
    }

    /// Why the resource does not fit a binding, if it does not.
    fn misfit(&self, binding: &Binding) -> Option<String> {
        if self.kind() != binding.kind {
            return Some(format!("it takes {:?}, not {:?}", binding.kind, self.kind()));
        }
        let (buffer, usage) = match self {
            Self::Storage(buffer) => (buffer, Usage::STORAGE_BUFFER),
            Self::Uniform(buffer) => (buffer, Usage::UNIFORM_BUFFER),
            _ => return None,
        };
        let fits = buffer.raw.usage.contains(usage);
        (!fits).then(|| format!("buffer `{}` was not created for {usage:?}", buffer.name()))
    }
}

/// A pipeline with its layout, shared with the commands that use it.
pub(crate) struct RawPipeline {
    pub(crate) context: Arc<Context>,
    pub(crate) name: String,
    pub(crate) handle: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    pub(crate) point: vk::PipelineBindPoint,
    pub(crate) bindings: Vec<Binding>,
    pub(crate) stages: vk::ShaderStageFlags,
    pub(crate) push_constant_bytes: u32,
}

/// A compute or graphics pipeline, for [`Commands::bind`](crate::vulkan::Commands::bind).
pub trait Bindable {
    #[doc(hidden)]
    fn raw(&self) -> RawPipelineRef<'_>;
}

/// Opaque outside this layer.
pub struct RawPipelineRef<'a>(pub(crate) &'a Arc<RawPipeline>);

impl RawPipeline {
    /// Creates the layouts for shaders that work together; the caller then sets `handle`.
    pub(crate) fn new(context: &Arc<Context>, name: &str, point: vk::PipelineBindPoint, shaders: &[Reflection]) -> Result<Self> {
        let mut raw = Self {
            context: context.clone(),
            name: name.to_owned(),
            handle: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            point,
            bindings: merge(name, shaders)?,
            stages: shaders.iter().fold(vk::ShaderStageFlags::empty(), |all, s| all | s.stage),
            push_constant_bytes: shaders.iter().map(|s| s.push_constant_bytes).max().unwrap_or(0),
        };
        let limit = context.limits().max_push_constants_size;
        if raw.push_constant_bytes > limit {
            let problem = format!("{} bytes of push constants; the limit is {limit}", raw.push_constant_bytes);
            return Err(VulkanError::Shader { shader: name.to_owned(), problem });
        }
        raw.create_layouts()?;
        Ok(raw)
    }

    fn create_layouts(&mut self) -> Result<()> {
        let bindings: Vec<_> = self.bindings.iter().map(layout_binding).collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default()
            .flags(vk::DescriptorSetLayoutCreateFlags::PUSH_DESCRIPTOR_KHR)
            .bindings(&bindings);
        let device = self.context.device();
        // SAFETY: the device is alive and has push descriptors.
        self.set_layout =
            unsafe { device.create_descriptor_set_layout(&info, None) }.map_err(api("vkCreateDescriptorSetLayout"))?;
        let sets = [self.set_layout];
        let ranges =
            [vk::PushConstantRange::default().stage_flags(self.stages).size(self.push_constant_bytes.next_multiple_of(4))];
        let used = usize::from(self.push_constant_bytes > 0);
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(&ranges[..used]);
        // SAFETY: the set layout is alive.
        self.layout = unsafe { device.create_pipeline_layout(&info, None) }.map_err(api("vkCreatePipelineLayout"))?;
        Ok(())
    }

    /// Pairs every binding with its resource.
    pub(crate) fn match_resources<'r, 'a>(&self, resources: &'r [(&str, Resource<'a>)]) -> Result<Vec<(u32, &'r Resource<'a>)>> {
        for (name, _) in resources {
            if !self.bindings.iter().any(|binding| binding.name == *name) {
                return Err(self.wrong(name, format!("there is none; there are {}", self.names())));
            }
        }
        let matched = self.bindings.iter().map(|binding| {
            let mut found = resources.iter().filter(|(name, _)| *name == binding.name);
            match (found.next(), found.next()) {
                (None, _) => Err(self.wrong(&binding.name, "no resource was given".to_owned())),
                (_, Some(_)) => Err(self.wrong(&binding.name, "it was given twice".to_owned())),
                (Some((_, resource)), None) => match resource.misfit(binding) {
                    Some(problem) => Err(self.wrong(&binding.name, problem)),
                    None => Ok((binding.number, resource)),
                },
            }
        });
        matched.collect()
    }

    fn names(&self) -> String {
        let names: Vec<&str> = self.bindings.iter().map(|b| b.name.as_str()).collect();
        names.join(", ")
    }

    fn wrong(&self, binding: &str, problem: String) -> VulkanError {
        VulkanError::Binding { pipeline: self.name.clone(), binding: binding.to_owned(), problem }
    }
}

impl Drop for RawPipeline {
    fn drop(&mut self) {
        let device = self.context.device();
        // SAFETY: commands hold an `Arc` of this until they are done; null handles are ignored.
        unsafe {
            device.destroy_pipeline(self.handle, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// Specialization constants in the form of Vulkan.
pub(crate) struct Specialization {
    entries: Vec<vk::SpecializationMapEntry>,
    data: Vec<u8>,
}

impl Specialization {
    pub(crate) fn new(constants: &[(u32, u32)]) -> Self {
        let entry =
            |(offset, (id, _)): (u32, &(u32, u32))| vk::SpecializationMapEntry { constant_id: *id, offset: offset * 4, size: 4 };
        let entries = (0u32..).zip(constants).map(entry).collect();
        let data = constants.iter().flat_map(|(_, value)| value.to_ne_bytes()).collect();
        Self { entries, data }
    }

    pub(crate) fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(&self.data)
    }
}

fn layout_binding(binding: &Binding) -> vk::DescriptorSetLayoutBinding<'static> {
    vk::DescriptorSetLayoutBinding::default()
        .binding(binding.number)
        .descriptor_type(binding.kind.descriptor_type())
        .descriptor_count(binding.count)
        .stage_flags(binding.stages)
}

/// The bindings of all shaders; one that several declare must be the same in all.
fn merge(pipeline: &str, shaders: &[Reflection]) -> Result<Vec<Binding>> {
    let mut merged: Vec<Binding> = Vec::new();
    for binding in shaders.iter().flat_map(|shader| &shader.bindings) {
        let wrong =
            |problem: String| VulkanError::Binding { pipeline: pipeline.to_owned(), binding: binding.name.clone(), problem };
        if binding.count != 1 {
            return Err(wrong("arrays of resources are not supported".to_owned()));
        }
        match merged.iter_mut().find(|other| other.number == binding.number) {
            Some(other) if other.name == binding.name && other.kind == binding.kind => {
                other.stages |= binding.stages;
            }
            Some(other) => {
                let (number, other) = (binding.number, &other.name);
                return Err(wrong(format!("its number {number} is also that of `{other}`")));
            }
            None => merged.push(binding.clone()),
        }
    }
    merged.sort_by_key(|binding| binding.number);
    Ok(merged)
}
