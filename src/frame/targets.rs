//! The images that a frame is drawn into.

use super::edge_shapes::{EdgeBuffers, WORD};
use super::passed::{Drawn, Ground};
use crate::vulkan::{vk, Context, Image, ImageDescription, Result, Sampler, SamplerDescription};
use std::sync::Arc;

/// Format of radiance.
pub const RADIANCE_FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// Format of reversed-Z depth: near / distance along the view axis, 0 at infinity.
pub const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// Format of notes on edges.
pub(super) const EDGE_FORMAT: vk::Format = vk::Format::R8_UNORM;

/// What the ground is drawn into with several samples a pixel.
pub struct Samples {
    /// As [`Targets::ground`].
    pub ground: Image,
    /// As [`Targets::depth`].
    pub depth: Image,
}

/// Colour and depth targets of one picture size.
pub struct Targets {
    /// Lit ground; alpha is its height above the sea in metres.
    pub ground: Image,
    /// Depth of the ground.
    pub depth: Image,
    /// The samples of both, where there are several.
    pub samples: Option<Samples>,
    /// Pixels that are part of another surface, too; with one sample a pixel somewhat wider than the picture.
    pub edges: Image,
    /// What finds them where there is one sample a pixel.
    pub(super) edge_buffers: Option<EdgeBuffers>,
    /// What each pixel shows, as a depth.
    pub(super) classes: Image,
    /// Ground and sea.
    pub water: Image,
    /// Radiance of all that is seen: ground, sea, air, stars.
    pub radiance: Image,
    /// The picture, where it is drawn with fewer pixels than it has; of its format.
    pub(super) few: Option<Image>,
    /// Unfiltered sampling of the above.
    pub nearest: Sampler,
    /// Width and height.
    pub size: (u32, u32),
}

impl Targets {
    /// Creates the targets.
    pub fn new(context: &Arc<Context>, size: (u32, u32), samples: u32) -> Result<Targets> {
        let color = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let depth = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let image = |name, size, format, usage| Image::new(context, &ImageDescription::new(name, size, format, usage));
        let several = |name, format, usage| {
            Image::new(context, &ImageDescription { samples, ..ImageDescription::new(name, size, format, usage) })
        };
        let samples = if samples > 1 {
            let ground = several("ground samples", RADIANCE_FORMAT, color)?;
            Some(Samples { ground, depth: several("depth samples", DEPTH_FORMAT, depth)? })
        } else {
            None
        };
        let edge_size = if samples.is_some() { size } else { (size.0.next_multiple_of(WORD), size.1) };
        let edges = image("edges", edge_size, EDGE_FORMAT, color)?;
        let edge_buffers = if samples.is_some() { None } else { Some(EdgeBuffers::new(context, &edges)?) };
        let nearest = SamplerDescription { filter: vk::Filter::NEAREST, ..SamplerDescription::default() };
        Ok(Targets {
            ground: image("ground", size, RADIANCE_FORMAT, color)?,
            depth: image("depth", size, DEPTH_FORMAT, depth)?,
            samples,
            edges,
            edge_buffers,
            classes: image("classes", size, DEPTH_FORMAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT)?,
            water: image("water", size, RADIANCE_FORMAT, color)?,
            radiance: image("radiance", size, RADIANCE_FORMAT, color)?,
            few: None,
            nearest: Sampler::new(context, "nearest", &nearest)?,
            size,
        })
    }

    /// Creates the targets of a picture of `size` and `format` drawn with `density` pixels along a side for each of its own.
    pub(super) fn sparse(context: &Arc<Context>, size: (u32, u32), format: vk::Format, density: f64) -> Result<Targets> {
        let few = |pixels: u32| ((f64::from(pixels) * density) as u32).max(1);
        let size = (few(size.0), few(size.1));
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let picture = Image::new(context, &ImageDescription::new("few pixels", size, format, usage))?;
        Ok(Targets { few: Some(picture), ..Targets::new(context, size, context.samples())? })
    }

    /// What the ground is drawn into.
    pub(super) fn drawn(&self) -> Drawn<'_> {
        match &self.samples {
            Some(samples) => Drawn { color: samples.ground.view(), depth: samples.depth.view() },
            None => Drawn { color: self.ground.view(), depth: self.depth.view() },
        }
    }

    /// What holds the ground with one sample a pixel.
    pub(super) fn single(&self) -> Ground<'_> {
        Ground { color: self.ground.view(), depth: self.depth.view(), edges: self.edges.view() }
    }
}
