//! A thin Vulkan layer: the only place with `unsafe`.
//!
//! In: SPIR-V, host data and a window. Out: commands run on the GPU and pictures read back. It knows nothing of planets.
//! Each room uses those before it: `error`, `device`, `resources`, `pipelines`, `commands`, `transfers`, `swapchain`.
//! Start with [`Context`], then [`Buffer`], [`Image`], [`ComputePipeline`], [`GraphicsPipeline`] and [`Commands`].

mod commands;
mod device;
mod error;
mod pipelines;
mod resources;
mod swapchain;
mod transfers;

#[cfg(test)]
pub(crate) mod tests;

pub use ash::vk;

pub use commands::accesses::Use;
pub use commands::rendering::{ColorTarget, DepthTarget};
pub use commands::synchronization::Access;
pub use commands::timestamps::{Timestamps, Zone, MAX_ZONES};
pub use commands::{Commands, Submission};
pub use device::choice::GpuChoice;
#[cfg(feature = "hot-reload")]
pub use device::context::Replacements;
pub use device::context::{Context, ContextOptions};
pub use device::features::Extras;
pub use device::gpu::{list_gpus, GpuInfo, GpuKind};
pub use device::memory::Memory;
pub use device::messages::{MessageLog, Severity, ValidationMessage, MAX_MESSAGES};
pub use device::surface::{Surface, Window};
pub use error::{Result, VulkanError};
pub use pipelines::compute::ComputePipeline;
pub use pipelines::graphics::{Blend, DepthTest, GraphicsDescription, GraphicsPipeline};
pub use pipelines::layout::{Bindable, Resource};
pub use pipelines::reflection::{Binding, BindingKind, Reflection};
pub use pipelines::shader::Shader;
pub use resources::buffer::{Buffer, Usage};
pub use resources::image::{Image, ImageDescription, ImageRegion, ImageView};
pub use resources::sampler::{Sampler, SamplerDescription};
pub use swapchain::{Frame, Swapchain, FRAMES_IN_FLIGHT};
pub use transfers::capture::{capture, Captured};
pub use transfers::download::download;
pub use transfers::upload::Upload;
