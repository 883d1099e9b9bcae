//! Clouds of the planet on the GPU: how much cloud there is in every direction, and finer detail.

use crate::vulkan::{vk, Context, Image, ImageDescription, Resource, Result, Sampler, SamplerDescription, Upload};
use std::sync::Arc;
use terrane_planet::maps::clouds::{cloud_detail, cloud_map, CloudLevel, CLOUD_SIDE, DETAIL_SIDE};
use terrane_planet::recipe::Recipe;

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
    /// Computes and uploads the maps; none for scenes that are not `drawn`, only measured.
    pub(super) fn new(context: &Arc<Context>, recipe: &Recipe, drawn: bool) -> Result<CloudMaps> {
        let empty = || vec![vec![[0.0f32]]];
        let clouds = recipe.clouds.as_ref().filter(|_| drawn);
        let (levels, detail) = match clouds {
            Some(clouds) => (cloud_map(recipe, clouds, CLOUD_SIDE), cloud_detail(recipe.seed)),
            None => (empty(), empty()),
        };
        let (side, detail_side) = if clouds.is_some() { (CLOUD_SIDE, DETAIL_SIDE) } else { (1, 1) };
        let image = |name, side: usize, format| {
            let plain = ImageDescription::new(name, (side as u32, side as u32), format, vk::ImageUsageFlags::SAMPLED);
            Image::new(context, &ImageDescription { mips: side.ilog2() + 1, ..plain })
        };
        let map = image("clouds", side, vk::Format::R8_UNORM)?;
        let tile = image("cloud detail", detail_side, vk::Format::R16_SFLOAT)?;
        let mut upload = Upload::new(context, CHUNK);
        stage(&mut upload, &map, &levels, |&[x]| (x * 255.0).round() as u8)?;
        stage(&mut upload, &tile, &detail, |&[x]| half::f16::from_f32(x).to_bits())?;
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

fn stage<T: bytemuck::NoUninit>(
    upload: &mut Upload,
    image: &Image,
    levels: &[CloudLevel],
    encode: impl Fn(&[f32; 1]) -> T,
) -> Result<()> {
    for (mip, texels) in levels.iter().enumerate() {
        upload.image(image, 0, mip as u32, &texels.iter().map(&encode).collect::<Vec<_>>())?;
    }
    Ok(())
}
