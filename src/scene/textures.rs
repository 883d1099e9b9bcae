//! Textures of all resident patches: slopes and albedo, and horizon angles and ambient occlusion. Each patch has a *slot*, a tile of a
//! layer of three image arrays. The arrays grow with what is resident.

use crate::vulkan::{
    vk, Context, Image, ImageDescription, ImageRegion, Result, Sampler, SamplerDescription, Upload, VulkanError,
};
use std::sync::Arc;
use terrane_planet::draw::layout::TILES_PER_SIDE;
use terrane_planet::ground::horizon::HorizonMap;
use terrane_planet::ground::texture::{decode_slope, texture_side, PatchTexture, MIP_LEVELS};
use terrane_planet::maps::mip::halved;

/// Slots of an image layer.
pub(super) const SLOTS_PER_LAYER: u32 = TILES_PER_SIDE * TILES_PER_SIDE;

/// Slopes: half floats, since 16-bit normalised formats need not be filterable.
const SLOPE_FORMAT: vk::Format = vk::Format::R16G16_SFLOAT;
/// Horizon and sky.
const RELIEF_FORMAT: vk::Format = vk::Format::R16G16_SFLOAT;
/// Albedo, decoded from sRGB by the sampler.
const ALBEDO_FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// Bytes that the textures of one patch of `cells` cells a side take of a layer, mip levels included.
pub(super) fn bytes_of_tile(cells: u32) -> u64 {
    let texels: u64 = (0..MIP_LEVELS).map(|mip| u64::from(layer_side(texture_side(cells)) >> mip).pow(2)).sum();
    let relief = u64::from(layer_side(cells + 1)).pow(2) * size_of::<[u16; 2]>() as u64;
    let layer = texels * (size_of::<[u16; 2]>() + size_of::<[u8; 4]>()) as u64 + relief;
    layer.div_ceil(SLOTS_PER_LAYER.into())
}

/// Texels along a side of a layer whose tiles have `side`: a power of two, so that coordinates divided by it stay exact.
fn layer_side(side: u32) -> u32 {
    (TILES_PER_SIDE * side).next_power_of_two()
}

/// The texture arrays and their free slots.
pub struct TexturePool {
    /// Slopes along the patch's two tangents.
    pub slopes: Image,
    /// Albedo, and the height above the sea in alpha (see [`terrane_planet::ground::texture::encode_shore`]).
    pub albedo: Image,
    /// At the grid's vertices: sine of the horizon's elevation towards the sun, and the share of the sky's light.
    pub relief: Image,
    /// Trilinear, clamped.
    pub sampler: Sampler,
    context: Arc<Context>,
    cells: u32,
    most_layers: u32,
    free: Vec<u32>,
}

impl TexturePool {
    /// Arrays of one layer, that may grow until they have `capacity` slots or as many as the device has layers for, for patches of
    /// `cells` cells a side.
    pub(super) fn new(context: &Arc<Context>, cells: u32, capacity: u32) -> Result<TexturePool> {
        let [slopes, albedo, relief] = arrays(context, cells, 1)?;
        let mut upload = Upload::new(context, 0);
        [&slopes, &albedo, &relief].into_iter().for_each(|array| upload.begin_image(array, None));
        upload.finish()?;
        let sampler = Sampler::new(context, "ground", &SamplerDescription::default())?;
        let most_layers = capacity.div_ceil(SLOTS_PER_LAYER).clamp(1, context.limits().max_image_array_layers);
        let context = context.clone();
        Ok(TexturePool { slopes, albedo, relief, sampler, context, cells, most_layers, free: slots_of(0, 1) })
    }

    /// Bytes of the arrays, and the most that they may grow to.
    pub(super) fn bytes(&self) -> (u64, u64) {
        let bytes: u64 = [&self.slopes, &self.albedo, &self.relief].map(Image::allocated_bytes).iter().sum();
        let layers = u64::from(self.slopes.layers());
        (bytes, bytes.div_ceil(layers) * u64::from(self.most_layers).max(layers))
    }

    /// A free slot. If there is none, the arrays are replaced by larger ones, to which `upload` copies what they hold. `None` at the
    /// largest size, or where the device has no memory for the next.
    pub(super) fn claim(&mut self, upload: &mut Upload) -> Result<Option<u32>> {
        if self.free.is_empty() {
            let (context, cells) = (self.context.clone(), self.cells);
            self.grow(upload, |layers| arrays(&context, cells, layers))?;
        }
        Ok(self.free.pop())
    }

    /// Frees a slot that was claimed.
    pub(super) fn release(&mut self, slot: u32) {
        self.free.push(slot);
    }

    /// Stages slopes and albedo of a slot.
    pub(super) fn upload(&self, upload: &mut Upload, slot: u32, mips: &TextureMips) -> Result<()> {
        for (mip, level) in mips.levels.iter().enumerate() {
            let region = region(slot, mip as u32, texture_side(self.cells) >> mip);
            upload.image_region(&self.slopes, &region, &level.slopes)?;
            upload.image_region(&self.albedo, &region, &level.albedo)?;
        }
        Ok(())
    }

    /// Stages horizon angles and ambient occlusion of a slot.
    pub(super) fn upload_relief(&self, upload: &mut Upload, slot: u32, relief: &Relief) -> Result<()> {
        upload.image_region(&self.relief, &region(slot, 0, self.cells + 1), &relief.texels)
    }

    /// Makes the layers half as many again, as far as that is allowed and `create` finds memory for them. Frames under way keep the old arrays.
    fn grow(&mut self, upload: &mut Upload, create: impl FnOnce(u32) -> Result<[Image; 3]>) -> Result<()> {
        let layers = self.slopes.layers();
        let wanted = (layers + (layers / 2).max(1)).min(self.most_layers);
        if wanted <= layers {
            return Ok(());
        }
        let grown = match create(wanted) {
            Err(VulkanError::OutOfMemory { what, bytes }) => {
                let slots = layers * SLOTS_PER_LAYER;
                tracing::warn!(what, bytes, slots, "no memory for the textures of more patches: the picture stays coarser");
                self.most_layers = layers;
                return Ok(());
            }
            arrays => arrays?,
        };
        for (array, grown) in [&mut self.slopes, &mut self.albedo, &mut self.relief].into_iter().zip(grown) {
            upload.begin_image(&grown, Some(array));
            *array = grown;
        }
        self.free.extend(slots_of(layers, wanted));
        Ok(())
    }
}

/// Slopes, albedo and relief of so many layers.
fn arrays(context: &Arc<Context>, cells: u32, layers: u32) -> Result<[Image; 3]> {
    let array = |name, format, side, mips| {
        let (side, usage) = (layer_side(side), vk::ImageUsageFlags::SAMPLED);
        let description =
            ImageDescription { layers, array: true, mips, ..ImageDescription::new(name, (side, side), format, usage) };
        Image::new(context, &description)
    };
    let side = texture_side(cells);
    Ok([
        array("slopes", SLOPE_FORMAT, side, MIP_LEVELS)?,
        array("albedo", ALBEDO_FORMAT, side, MIP_LEVELS)?,
        array("relief", RELIEF_FORMAT, cells + 1, 1)?,
    ])
}

/// The slots of some layers, the first last.
fn slots_of(first: u32, end: u32) -> Vec<u32> {
    (first * SLOTS_PER_LAYER..end * SLOTS_PER_LAYER).rev().collect()
}

/// Where a slot's tile of `side` texels a side lies. Twin: `in_layer` of `draw.frag`.
fn region(slot: u32, mip: u32, side: u32) -> ImageRegion {
    let tile = slot % SLOTS_PER_LAYER;
    let origin = (side * (tile % TILES_PER_SIDE), side * (tile / TILES_PER_SIDE));
    ImageRegion { layer: slot / SLOTS_PER_LAYER, mip, origin, size: (side, side) }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vulkan::tests::checked::device;
    use crate::vulkan::{capture, Access};

    const CELLS: u32 = 8;

    /// Textures that differ from slot to slot and texel to texel.
    fn mips(slot: u32) -> TextureMips {
        let level = |mip: u32| {
            let count = (texture_side(CELLS) >> mip).pow(2);
            // Small halves: none is a NaN, which copies might quieten.
            let slopes = (0..count).map(|i| [(slot * 7 + i) as u16 % 997, (mip * 100 + i) as u16 % 499]).collect();
            let albedo = (0..count).map(|i| [slot, i, i / 7, mip].map(|n| n as u8)).collect();
            MipLevel { slopes, albedo }
        };
        TextureMips { levels: (0..MIP_LEVELS).map(level).collect() }
    }

    fn relief(slot: u32) -> Relief {
        Relief { texels: (0..(CELLS + 1).pow(2)).map(|i| [slot as u16, i as u16]).collect(), sun: 0 }
    }

    /// What a slot's tile of an array holds.
    fn tile(context: &Arc<Context>, array: &Image, slot: u32, mip: u32) -> Vec<u8> {
        let side = if array.mips() == 1 { CELLS + 1 } else { texture_side(CELLS) >> mip };
        let ImageRegion { layer, origin: (x, y), .. } = region(slot, mip, side);
        let captured = capture(context, array, (layer, mip), Access::Sampled).unwrap();
        let row = |row: u32| captured.bytes[4 * (row * captured.width + x) as usize..][..4 * side as usize].to_vec();
        (y..y + side).flat_map(row).collect()
    }

    /// The first slot that does not hold its textures.
    fn first_wrong(context: &Arc<Context>, pool: &TexturePool, slots: &[u32]) -> Option<u32> {
        let holds = |&slot: &u32| {
            let levels = mips(slot).levels;
            let right = |(mip, level): (usize, &MipLevel)| {
                tile(context, &pool.slopes, slot, mip as u32) == bytemuck::cast_slice::<_, u8>(&level.slopes)
                    && tile(context, &pool.albedo, slot, mip as u32) == bytemuck::cast_slice::<_, u8>(&level.albedo)
            };
            levels.iter().enumerate().all(right)
                && tile(context, &pool.relief, slot, 0) == bytemuck::cast_slice::<_, u8>(&relief(slot).texels)
        };
        slots.iter().copied().find(|slot| !holds(slot))
    }

    fn fill(pool: &mut TexturePool, upload: &mut Upload, count: u32) -> Vec<u32> {
        let claim = |_| {
            let slot = pool.claim(upload).unwrap()?;
            pool.upload(upload, slot, &mips(slot)).unwrap();
            pool.upload_relief(upload, slot, &relief(slot)).unwrap();
            Some(slot)
        };
        (0..count).map_while(claim).collect()
    }

    #[test]
    fn slots_are_tiles_of_layers_row_by_row() {
        let place = |slot| (region(slot, 0, 10).layer, region(slot, 0, 10).origin);
        assert_eq!([0, 3, 7, 24].map(place), [(0, (0, 0)), (0, (30, 0)), (0, (0, 10)), (0, (30, 30))]);
        assert_eq!([49, 57, 6].map(place), [(1, (0, 0)), (1, (10, 10)), (0, (60, 0))]);
        let every: Vec<ImageRegion> = (0..40).map(|slot| region(slot, 0, 10)).collect();
        let apart = |(i, a): (usize, &ImageRegion)| every[..i].iter().all(|b| !a.overlaps(b));
        assert!(every.iter().enumerate().all(apart));
        assert!(region(5, 0, 10).overlaps(&ImageRegion { size: (1, 1), ..region(5, 0, 10) }));
    }

    #[test]
    fn tiles_are_whole_texels_at_every_mip_level() {
        for cells in [8, 16, 32, 64, 128] {
            let (side, mip) = (texture_side(cells), MIP_LEVELS - 1);
            assert_eq!(side >> mip << mip, side);
        }
    }

    #[test]
    fn without_memory_to_grow_a_pool_keeps_what_it_holds() {
        let Some(context) = device() else { return };
        let mut pool = TexturePool::new(&context, CELLS, 100).unwrap();
        let mut upload = Upload::new(&context, 1 << 16);
        let slots = fill(&mut pool, &mut upload, SLOTS_PER_LAYER);
        let lost = || Err(VulkanError::DeviceLost { zone: String::new() });
        assert!(pool.grow(&mut upload, |_| lost()).is_err(), "other errors are told");
        let none = |layers| {
            assert_eq!(layers, 2);
            Err(VulkanError::OutOfMemory { what: "slopes".to_owned(), bytes: 0 })
        };
        pool.grow(&mut upload, none).unwrap();
        // Nor is it tried again.
        assert_eq!((pool.claim(&mut upload).unwrap(), pool.slopes.layers()), (None, 1));
        upload.finish().unwrap();
        assert_eq!(first_wrong(&context, &pool, &slots), None);
        pool.release(3);
        assert_eq!(pool.claim(&mut upload).unwrap(), Some(3));
    }

    #[test]
    fn growth_keeps_every_tile() {
        let Some(context) = device() else { return };
        let mut pool = TexturePool::new(&context, CELLS, 7 * SLOTS_PER_LAYER - 5).unwrap();
        let (first, most) = pool.bytes();
        assert!(first >= u64::from(SLOTS_PER_LAYER) * (bytes_of_tile(CELLS) - 1) && most >= 7 * first, "{first} of {most}");
        // Four growths, to 2, 3, 4 and 6 layers: all but the first within one batch, over what the first left.
        let mut upload = Upload::new(&context, 1 << 16);
        let mut slots = fill(&mut pool, &mut upload, SLOTS_PER_LAYER + 4);
        assert_eq!(pool.slopes.layers(), 2);
        upload.finish().unwrap();
        slots.extend(fill(&mut pool, &mut upload, 4 * SLOTS_PER_LAYER - 4));
        upload.finish().unwrap();
        assert_eq!((slots.len(), pool.slopes.layers()), (5 * SLOTS_PER_LAYER as usize, 6));
        assert_eq!(first_wrong(&context, &pool, &slots), None);
        // Slots that nothing was written to are 0, not what memory held before: not-a-number times a weight of 0 is no 0.
        assert!(tile(&context, &pool.relief, 5 * SLOTS_PER_LAYER + 10, 0).iter().all(|&byte| byte == 0));
        // Full: whole layers are used up, then there is none, until one is released.
        slots.extend(fill(&mut pool, &mut upload, 1000));
        upload.finish().unwrap();
        assert_eq!((slots.len(), pool.slopes.layers()), (7 * SLOTS_PER_LAYER as usize, 7));
        let (bytes, most) = pool.bytes();
        assert!(bytes <= most);
        pool.release(9);
        assert_eq!((pool.claim(&mut upload).unwrap(), pool.claim(&mut upload).unwrap()), (Some(9), None));
        // A slot written twice in one batch holds what came last; its neighbours stay.
        pool.upload_relief(&mut upload, 9, &relief(77)).unwrap();
        pool.upload_relief(&mut upload, 9, &relief(9)).unwrap();
        upload.finish().unwrap();
        assert_eq!(first_wrong(&context, &pool, &slots), None);
        // The control: a tile that is not as it was uploaded is found.
        pool.upload_relief(&mut upload, 21, &relief(22)).unwrap();
        upload.finish().unwrap();
        assert_eq!(first_wrong(&context, &pool, &slots), Some(21));
    }
}
