//! A compiled shader and its Vulkan module.

use std::borrow::Cow;

use ash::vk;

#[cfg(feature = "hot-reload")]
use super::reflection::Reflection;
#[cfg(feature = "hot-reload")]
use crate::vulkan::error::VulkanError;
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

/// The words to create pipelines of a shader with: its own, or those that were put in their place while the program runs.
///
/// # Errors
/// A replacement that asks for other resources than the program gives.
#[cfg(feature = "hot-reload")]
pub(crate) fn current_words<'a>(context: &Context, shader: &Shader<'a>, constants: &[(u32, u32)]) -> Result<Cow<'a, [u32]>> {
    let Some(words) = context.replacement(shader.name) else {
        return Ok(Cow::Borrowed(shader.words));
    };
    let replacement = Reflection::new(&Shader { name: shader.name, words: &words }, constants)?;
    if replacement != Reflection::new(shader, constants)? {
        let problem =
            "its bindings, push constants or workgroups are not those that the program was built with; build it again".to_owned();
        return Err(VulkanError::Shader { shader: shader.name.to_owned(), problem });
    }
    Ok(Cow::Owned(words.to_vec()))
}

/// The words to create pipelines of a shader with.
#[cfg(not(feature = "hot-reload"))]
pub(crate) fn current_words<'a>(_: &Context, shader: &Shader<'a>, _: &[(u32, u32)]) -> Result<Cow<'a, [u32]>> {
    Ok(Cow::Borrowed(shader.words))
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
