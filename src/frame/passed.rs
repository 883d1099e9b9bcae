//! What the picture stages share, and what they hand to one another: each takes the handles that it reads and gives back those that it
//! writes.

use super::air::Air;
use super::buffers::FrameBuffers;
use super::targets::Targets;
use super::tiles::Tiles;
use crate::scene::Scene;
use crate::vulkan::{ImageView, Resource};
use terrane_planet::draw::layout::{Shading, NO_SEA};

/// What all picture stages of a frame share.
pub(super) struct Shared<'a> {
    /// What the shading of the frame is, for what is decided on the CPU.
    pub(super) lit: &'a Shading,
    /// The view, the shading, and the emitted mesh.
    pub(super) buffers: &'a FrameBuffers,
    /// The ground's textures and the clouds.
    pub(super) scene: &'a Scene,
    /// What stages draw into.
    pub(super) targets: &'a Targets,
    /// The tables of the air.
    pub(super) air: &'a Air,
    /// The maps that repeat.
    pub(super) tiles: &'a Tiles,
}

impl<'a> Shared<'a> {
    /// The shading, as shaders bind it.
    pub(super) fn shading(&self) -> (&'static str, Resource<'a>) {
        ("ShadingBlock", Resource::Uniform(self.buffers.shading()))
    }

    /// Whether the planet has a sea.
    pub(super) fn has_sea(&self) -> bool {
        self.lit.sea_level > NO_SEA
    }

    /// Whether it has clouds.
    pub(super) fn has_clouds(&self) -> bool {
        self.lit.cloud_depth > 0.0
    }

    /// Whether some view rays may meet no air.
    pub(super) fn has_space(&self) -> bool {
        self.lit.scale_height <= 0.0 || self.lit.height_m > self.lit.air_top
    }

    /// What an earlier stage drew, pixel by pixel.
    pub(super) fn pixels(&self, name: &'static str, view: &'a ImageView) -> (&'static str, Resource<'a>) {
        (name, Resource::Sampled(view, &self.targets.nearest))
    }
}

/// The ground as it was drawn, with one or several samples a pixel.
#[derive(Clone, Copy)]
pub(super) struct Drawn<'a> {
    /// Lit ground; alpha is its height above the sea in metres.
    pub(super) color: &'a ImageView,
    /// Its depth.
    pub(super) depth: &'a ImageView,
}

/// The ground with one sample a pixel.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    /// As [`Drawn::color`].
    pub(super) color: &'a ImageView,
    /// As [`Drawn::depth`].
    pub(super) depth: &'a ImageView,
    /// Pixels that are part of another surface, too.
    pub(super) edges: &'a ImageView,
}
