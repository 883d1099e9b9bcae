//! Clouds of the planet on the GPU: how much cloud there is in every direction, and finer detail.

use crate::vulkan::{vk, Context, Image, ImageDescription, Resource, Result, Sampler, SamplerDescription, Upload};
use std::sync::Arc;
use terrane_planet::maps::clouds::{cloud_detail, cloud_levels, CloudLevel, CLOUD_SIDE, DETAIL_SIDE};

/// Bytes staged at a time.
const CHUNK: u64 = 8 << 20;

/// The maps; of one black texel where the recipe has no clouds.
pub struct CloudMaps {
    map: Image,
    detail: Image,
    clamp: Sampler,
    repeat: Sampler,
}

impl CloudMaps {
    /// Uploads the `map` of a recipe's clouds, if there is one, and computes what is finer.
    pub(super) fn new(context: &Arc<Context>, seed: u64, map: Option<CloudLevel>) -> Result<CloudMaps> {
        let (levels, detail, side, detail_side) = match map {
            Some(map) => (cloud_levels(map, CLOUD_SIDE), cloud_detail(seed), CLOUD_SIDE, DETAIL_SIDE),
            None => (vec![vec![0]], vec![vec![[0.0]]], 1, 1),
        };
        let image = |name, side: usize, format| {
            let plain = ImageDescription::new(name, (side as u32, side as u32), format, vk::ImageUsageFlags::SAMPLED);
            Image::new(context, &ImageDescription { mips: side.ilog2() + 1, ..plain })
        };
        let map = image("clouds", side, vk::Format::R8_UNORM)?;
        let tile = image("cloud detail", detail_side, vk::Format::R16_SFLOAT)?;
        let mut upload = Upload::new(context, CHUNK);
        for (mip, texels) in levels.iter().enumerate() {
            upload.image(&map, 0, mip as u32, texels)?;
        }
        for (mip, texels) in detail.iter().enumerate() {
            let halves: Vec<u16> = texels.iter().map(|&[x]| half::f16::from_f32(x).to_bits()).collect();
            upload.image(&tile, 0, mip as u32, &halves)?;
        }
        upload.finish()?;
        let repeat = SamplerDescription { address: vk::SamplerAddressMode::REPEAT, ..SamplerDescription::default() };
        let (clamp, repeat) =
            (Sampler::new(context, "clouds", &SamplerDescription::default())?, Sampler::new(context, "cloud detail", &repeat)?);
        Ok(CloudMaps { map, detail: tile, clamp, repeat })
    }

    /// What `shared/clouds.glsl` binds.
    pub(crate) fn bound(&self) -> [(&'static str, Resource<'_>); 2] {
        [
            ("cloud_map", Resource::Sampled(self.map.view(), &self.clamp)),
            ("cloud_detail", Resource::Sampled(self.detail.view(), &self.repeat)),
        ]
    }
}
