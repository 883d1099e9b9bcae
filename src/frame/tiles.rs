//! Tiles: maps that repeat over the whole planet, finer than what patches hold: waves of the sea, grain of the ground,
//! crowns of trees.

use crate::vulkan::{vk, Context, Image, ImageDescription, Resource, Result, Sampler, SamplerDescription, Upload};
use std::sync::Arc;
use terrane_planet::maps::grain::{crown_map, grain_map, CROWN_LAYER, GRAIN_SIDE, GROUND_LAYER};
use terrane_planet::maps::waves::{wave_map, CASCADES, WAVE_SIDE};

/// Slopes, and a third number.
const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;

/// Bytes staged at a time.
const CHUNK: u64 = 4 << 20;

/// The maps.
pub(super) struct Tiles {
    waves: Image,
    grain: Image,
    sampler: Sampler,
}

impl Tiles {
    /// Computes and uploads the maps; the same on every machine to the rounding of sines.
    pub(super) fn new(context: &Arc<Context>) -> Result<Tiles> {
        let image = |name, side: usize, layers: usize| {
            let usage = vk::ImageUsageFlags::SAMPLED;
            let size = (side as u32, side as u32);
            let mips = side.ilog2() + 1;
            let description =
                ImageDescription { layers: layers as u32, array: true, mips, ..ImageDescription::new(name, size, FORMAT, usage) };
            Image::new(context, &description)
        };
        let (waves, grain) = (image("waves", WAVE_SIDE, CASCADES.len())?, image("grain", GRAIN_SIDE, 2)?);
        let mut upload = Upload::new(context, CHUNK);
        let mut stage = |image: &Image, layer: usize, levels: Vec<Vec<[f32; 3]>>| {
            for (mip, texels) in levels.iter().enumerate() {
                let half = |&[x, y, z]: &[f32; 3]| [x, y, z, 0.0].map(|c| half::f16::from_f32(c).to_bits());
                upload.image(image, layer as u32, mip as u32, &texels.iter().map(half).collect::<Vec<[u16; 4]>>())?;
            }
            Ok::<(), crate::vulkan::VulkanError>(())
        };
        for (layer, cascade) in CASCADES.iter().enumerate() {
            stage(&waves, layer, wave_map(cascade, layer as u64))?;
        }
        stage(&grain, GROUND_LAYER as usize, grain_map(1))?;
        stage(&grain, CROWN_LAYER as usize, crown_map(2))?;
        upload.finish()?;
        let description = SamplerDescription { address: vk::SamplerAddressMode::REPEAT, ..SamplerDescription::default() };
        Ok(Tiles { waves, grain, sampler: Sampler::new(context, "tiles", &description)? })
    }

    /// What `ocean.frag` binds.
    pub(super) fn waves(&self) -> (&'static str, Resource<'_>) {
        ("waves", Resource::Sampled(self.waves.view(), &self.sampler))
    }

    /// What `draw.frag` binds.
    pub(super) fn grain(&self) -> (&'static str, Resource<'_>) {
        ("grain_map", Resource::Sampled(self.grain.view(), &self.sampler))
    }
}
