//! Textures of all resident patches, one layer a patch: slopes and albedo, and horizon angles and ambient occlusion.

use crate::vulkan::{vk, Access, Commands, Context, Image, ImageDescription, Result, Sampler, SamplerDescription, Upload};
use std::sync::Arc;
use terrane_planet::ground::horizon::HorizonMap;
use terrane_planet::ground::texture::{decode_slope, texture_side, PatchTexture, MIP_LEVELS};
use terrane_planet::maps::mip::halved;

/// Slopes: half floats, since 16-bit normalised formats need not be filterable.
const SLOPE_FORMAT: vk::Format = vk::Format::R16G16_SFLOAT;
/// Horizon and sky.
const RELIEF_FORMAT: vk::Format = vk::Format::R16G16_SFLOAT;
/// Albedo, decoded from sRGB by the sampler.
const ALBEDO_FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// Bytes of the textures of one patch of `cells` cells a side, mip levels included.
pub(super) fn bytes_of_layer(cells: u32) -> u64 {
    let texels: u64 = (0..MIP_LEVELS).map(|mip| u64::from(texture_side(cells) >> mip).pow(2)).sum();
    texels * (size_of::<[u16; 2]>() + size_of::<[u8; 4]>()) as u64 + u64::from(cells + 1).pow(2) * size_of::<[u16; 2]>() as u64
}

/// The texture arrays and their free layers.
pub struct TexturePool {
    /// Slopes along the patch's two tangents.
    pub slopes: Image,
    /// Albedo, and the height above the sea in alpha (see [`terrane_planet::ground::texture::encode_shore`]).
    pub albedo: Image,
    /// At the grid's vertices: sine of the horizon's elevation towards the sun, and the share of the sky's light.
    pub relief: Image,
    /// Trilinear, clamped.
    pub sampler: Sampler,
    free: Vec<u32>,
}

impl TexturePool {
    /// Arrays of `layers` layers for patches of `cells` cells a side.
    pub(super) fn new(context: &Arc<Context>, cells: u32, layers: u32) -> Result<TexturePool> {
        let side = texture_side(cells);
        let array = |name, format, side, mips| {
            let usage = vk::ImageUsageFlags::SAMPLED;
            let description =
                ImageDescription { layers, array: true, mips, ..ImageDescription::new(name, (side, side), format, usage) };
            Image::new(context, &description)
        };
        let slopes = array("slopes", SLOPE_FORMAT, side, MIP_LEVELS)?;
        let albedo = array("albedo", ALBEDO_FORMAT, side, MIP_LEVELS)?;
        let relief = array("relief", RELIEF_FORMAT, cells + 1, 1)?;
        Commands::once(context, "texture layouts", |commands| {
            commands.ready(&[&slopes, &albedo, &relief].map(|array| array.view().anew(Access::Sampled)))
        })?;
        let sampler = Sampler::new(context, "ground", &SamplerDescription::default())?;
        Ok(TexturePool { slopes, albedo, relief, sampler, free: (0..layers).rev().collect() })
    }

    pub(super) fn claim(&mut self) -> Option<u32> {
        self.free.pop()
    }

    pub(super) fn release(&mut self, layer: u32) {
        self.free.push(layer);
    }

    pub(super) fn upload(&self, upload: &mut Upload, layer: u32, mips: &TextureMips) -> Result<()> {
        for (mip, level) in mips.levels.iter().enumerate() {
            upload.image(&self.slopes, layer, mip as u32, &level.slopes)?;
            upload.image(&self.albedo, layer, mip as u32, &level.albedo)?;
        }
        Ok(())
    }

    pub(super) fn upload_relief(&self, upload: &mut Upload, layer: u32, relief: &Relief) -> Result<()> {
        upload.image(&self.relief, layer, 0, &relief.texels)
    }
}

/// Horizon angles and ambient occlusion of a patch, as half floats, and the number of the sun that they are towards.
pub(super) struct Relief {
    texels: Vec<[u16; 2]>,
    /// Number of the sun.
    pub(super) sun: u64,
}

impl Relief {
    pub(super) fn new(map: &HorizonMap, sun: u64) -> Relief {
        let half = |x: f32| half::f16::from_f32(x).to_bits();
        Relief { texels: map.horizon.iter().zip(&map.sky).map(|(&h, &s)| [half(h), half(s)]).collect(), sun }
    }
}

/// The textures of a patch with their mip levels, in the formats of the arrays.
pub(super) struct TextureMips {
    levels: Vec<MipLevel>,
}

struct MipLevel {
    slopes: Vec<[u16; 2]>,
    albedo: Vec<[u8; 4]>,
}

/// A level before it is encoded: linear values.
struct LinearLevel {
    side: usize,
    texels: Vec<[f32; 6]>,
}

impl TextureMips {
    /// Filters a stored texture down (2 × 2 box; gutters halve with the texels, so patches still meet).
    pub(super) fn new(texture: &PatchTexture, cells: u32) -> TextureMips {
        let to_linear: Vec<f32> = (0..=255u8).map(decode_srgb).collect();
        let texel = |((slope, albedo), shore): ((&[i8; 2], &[u8; 3]), &u8)| {
            let [x, y] = slope.map(|s| decode_slope(s) as f32);
            let [r, g, b] = albedo.map(|c| to_linear[usize::from(c)]);
            [x, y, r, g, b, f32::from(*shore)]
        };
        let texels = texture.slopes.iter().zip(&texture.albedo).zip(&texture.shore).map(texel).collect();
        let mut level = LinearLevel { side: texture_side(cells) as usize, texels };
        let slopes = level.half_slopes();
        let albedo = texture.albedo.iter().zip(&texture.shore).map(|(&[r, g, b], &shore)| [r, g, b, shore]).collect();
        let mut levels = vec![MipLevel { slopes, albedo }];
        while levels.len() < MIP_LEVELS as usize {
            level = level.halved();
            levels.push(MipLevel { slopes: level.half_slopes(), albedo: level.encoded_albedo() });
        }
        TextureMips { levels }
    }
}

impl LinearLevel {
    fn halved(&self) -> LinearLevel {
        LinearLevel { side: self.side / 2, texels: halved(&self.texels, self.side) }
    }

    fn half_slopes(&self) -> Vec<[u16; 2]> {
        self.texels.iter().map(|t| [t[0], t[1]].map(|s| half::f16::from_f32(s).to_bits())).collect()
    }

    fn encoded_albedo(&self) -> Vec<[u8; 4]> {
        self.texels.iter().map(|t| [encode_srgb(t[2]), encode_srgb(t[3]), encode_srgb(t[4]), (t[5] + 0.5) as u8]).collect()
    }
}

fn decode_srgb(code: u8) -> f32 {
    let x = f32::from(code) / 255.0;
    if x <= 0.04045 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

fn encode_srgb(x: f32) -> u8 {
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}
