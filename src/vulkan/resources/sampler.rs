//! Samplers: how shaders filter images.

use std::sync::Arc;

use ash::vk;

use crate::vulkan::error::{api, Result};
use crate::vulkan::Context;

/// How to filter.
#[derive(Debug, Clone, Copy)]
pub struct SamplerDescription {
    /// Within and between mip levels.
    pub filter: vk::Filter,
    /// Past the edges.
    pub address: vk::SamplerAddressMode,
    /// Largest anisotropy, 1 for none; limited to what the device can do.
    pub anisotropy: f32,
}

impl Default for SamplerDescription {
    fn default() -> Self {
        Self { filter: vk::Filter::LINEAR, address: vk::SamplerAddressMode::CLAMP_TO_EDGE, anisotropy: 1.0 }
    }
}

/// A sampler; clones share it.
#[derive(Clone)]
pub struct Sampler {
    pub(crate) raw: Arc<RawSampler>,
}

pub(crate) struct RawSampler {
    context: Arc<Context>,
    pub(crate) handle: vk::Sampler,
}

impl Sampler {
    /// Creates a sampler.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(context: &Arc<Context>, name: &str, description: &SamplerDescription) -> Result<Self> {
        let linear = description.filter == vk::Filter::LINEAR;
        let mipmap = if linear { vk::SamplerMipmapMode::LINEAR } else { vk::SamplerMipmapMode::NEAREST };
        let most = if context.extras().anisotropy { context.limits().max_sampler_anisotropy } else { 1.0 };
        let anisotropy = description.anisotropy.clamp(1.0, most);
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(description.filter)
            .min_filter(description.filter)
            .mipmap_mode(mipmap)
            .address_mode_u(description.address)
            .address_mode_v(description.address)
            .address_mode_w(description.address)
            .anisotropy_enable(anisotropy > 1.0)
            .max_anisotropy(anisotropy)
            .max_lod(vk::LOD_CLAMP_NONE);
        // SAFETY: the device is alive and the values within its limits.
        let handle = unsafe { context.device().create_sampler(&info, None) }.map_err(api("vkCreateSampler"))?;
        context.set_name(handle, name);
        Ok(Self { raw: Arc::new(RawSampler { context: context.clone(), handle }) })
    }
}

impl Drop for RawSampler {
    fn drop(&mut self) {
        // SAFETY: commands hold an `Arc` of this until they are done.
        unsafe { self.context.device().destroy_sampler(self.handle, None) };
    }
}
