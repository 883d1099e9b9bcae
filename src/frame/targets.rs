//! The images that a frame is drawn into.

use crate::vulkan::{vk, Context, Image, ImageDescription, Result, Sampler, SamplerDescription};
use std::sync::Arc;

/// Format of radiance.
pub const SCENE_FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// Format of reversed-Z depth: near / distance along the view axis, 0 at infinity.
pub const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// Colour and depth targets of one picture size.
pub struct Targets {
    /// Lit ground; alpha is its height above the sea in metres.
    pub ground: Image,
    /// Depth of the ground.
    pub depth: Image,
    /// Ground and sea.
    pub water: Image,
    /// Ground, sea and air.
    pub scene: Image,
    /// Unfiltered sampling of the above.
    pub nearest: Sampler,
    /// Width and height.
    pub size: (u32, u32),
}

impl Targets {
    /// Creates the targets.
    pub fn new(context: &Arc<Context>, size: (u32, u32)) -> Result<Targets> {
        let color = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let depth = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let image = |name, format, usage| Image::new(context, &ImageDescription::new(name, size, format, usage));
        let nearest = SamplerDescription { filter: vk::Filter::NEAREST, ..SamplerDescription::default() };
        Ok(Targets {
            ground: image("ground", SCENE_FORMAT, color)?,
            depth: image("depth", DEPTH_FORMAT, depth)?,
            water: image("water", SCENE_FORMAT, color)?,
            scene: image("scene", SCENE_FORMAT, color)?,
            nearest: Sampler::new(context, "nearest", &nearest)?,
            size,
        })
    }
}
