//! A compiled shader and its Vulkan module.

use ash::vk;

use crate::vulkan::error::{api, Result};
use crate::vulkan::Context;

/// SPIR-V with the name of the file that it came from.
#[derive(Debug, Clone, Copy)]
pub struct Shader<'a> {
    /// File name, such as `select.comp`.
    pub name: &'a str,
    /// The SPIR-V words.
    pub words: &'a [u32],
}

/// A shader module that lives as long as it takes to build a pipeline.
pub(crate) struct Module<'a> {
    context: &'a Context,
    pub(crate) handle: vk::ShaderModule,
}

impl<'a> Module<'a> {
    pub(crate) fn new(context: &'a Context, shader: &Shader<'_>) -> Result<Self> {
        let info = vk::ShaderModuleCreateInfo::default().code(shader.words);
        // SAFETY: the words outlive the call; reflection has already checked that they are SPIR-V.
        let handle = unsafe { context.device().create_shader_module(&info, None) }.map_err(api("vkCreateShaderModule"))?;
        context.set_name(handle, shader.name);
        Ok(Self { context, handle })
    }
}

impl Drop for Module<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once built.
        unsafe { self.context.device().destroy_shader_module(self.handle, None) };
    }
}
