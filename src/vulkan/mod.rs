//! A thin Vulkan layer: the only place with `unsafe`.
//!
//! In: SPIR-V, host data and a window. Out: commands run on the GPU and pictures read back. It knows nothing of planets.
//! Start with [`Context`], then [`Buffer`], [`Image`], [`ComputePipeline`], [`GraphicsPipeline`] and [`Commands`].

mod buffer;
mod capture;
mod commands;
mod compute;
mod context;
mod copies;
mod download;
mod error;
mod features;
mod gpu;
mod graphics;
mod image;
mod instance;
mod layout;
mod memory;
mod messages;
mod recording;
mod reflection;
mod rendering;
mod sampler;
mod shader;
mod surface;
mod swapchain;
mod synchronization;
mod timestamps;
mod types;
mod upload;

#[cfg(test)]
mod tests;

pub use ash::vk;

pub use buffer::{Buffer, Usage};
pub use capture::{capture, Captured};
pub use commands::{Commands, Submission};
pub use compute::ComputePipeline;
pub use context::{Context, ContextOptions};
pub use download::download;
pub use error::{Result, VulkanError};
pub use features::Extras;
pub use gpu::{list_gpus, GpuChoice, GpuInfo, GpuKind};
pub use graphics::{Blend, DepthTest, GraphicsDescription, GraphicsPipeline};
pub use image::{Image, ImageDescription, ImageView};
pub use layout::{Bindable, Resource};
pub use memory::Memory;
pub use messages::{MessageLog, Severity, ValidationMessage, MAX_MESSAGES};
pub use reflection::{Binding, BindingKind, Reflection};
pub use rendering::{ColorTarget, DepthTarget};
pub use sampler::{Sampler, SamplerDescription};
pub use shader::Shader;
pub use surface::{Surface, Window};
pub use swapchain::{Frame, Swapchain, FRAMES_IN_FLIGHT};
pub use synchronization::Access;
pub use timestamps::{Timestamps, Zone, MAX_ZONES};
pub use upload::Upload;
