//! Reads an image back to the host.

use std::sync::Arc;

use ash::vk;

use crate::vulkan::commands::synchronization::Access;
use crate::vulkan::commands::Commands;
use crate::vulkan::device::memory::Memory;
use crate::vulkan::error::{Result, VulkanError};
use crate::vulkan::resources::buffer::{Buffer, Usage};
use crate::vulkan::resources::image::Image;
use crate::vulkan::Context;

/// The texels of one layer and level, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Captured {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Format of the texels.
    pub format: vk::Format,
    /// Tightly packed texels.
    pub bytes: Vec<u8>,
}

/// Reads one layer and level of an image that was last used as `access`, and leaves it ready for that again.
///
/// # Errors
/// A layer or level that does not exist, a format of unknown size, or device loss.
pub fn capture(context: &Arc<Context>, image: &Image, (layer, mip): (u32, u32), access: Access) -> Result<Captured> {
    let bytes = image.layer_bytes(mip)?;
    let view = image.layer_view(layer, mip)?;
    let usage = Usage::TRANSFER_DST;
    let target = Buffer::new(context, "capture", bytes, usage, Memory::Readback)?;
    Commands::once(context, "capture", |commands| {
        commands.found(&view, access);
        commands.ready(&[view.to(Access::TransferRead)])?;
        commands.copy_image_to_buffer(image, &image.whole(layer, mip)?, (&target, 0))?;
        commands.ready(&[view.to(access)])
    })?;
    let (width, height) = image.mip_size(mip);
    let bytes = target.read(0, bytes as usize)?;
    Ok(Captured { width, height, format: image.format(), bytes })
}

impl Captured {
    /// The channels of all texels as numbers: UNORM as 0 to 1, floats and 32-bit integers as they are.
    ///
    /// # Errors
    /// A format without a conversion.
    pub fn to_f32(&self) -> Result<Vec<f32>> {
        let words = || self.bytes.chunks_exact(4).map(|b| [b[0], b[1], b[2], b[3]]);
        let halves = || self.bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]]));
        match self.format {
            vk::Format::R8_UNORM | vk::Format::R8G8_UNORM | vk::Format::R8G8B8A8_UNORM | vk::Format::B8G8R8A8_UNORM => {
                Ok(self.bytes.iter().map(|byte| f32::from(*byte) / 255.0).collect())
            }
            vk::Format::R16_SFLOAT | vk::Format::R16G16_SFLOAT | vk::Format::R16G16B16A16_SFLOAT => {
                Ok(halves().map(half_to_f32).collect())
            }
            vk::Format::D32_SFLOAT | vk::Format::R32_SFLOAT | vk::Format::R32G32_SFLOAT | vk::Format::R32G32B32A32_SFLOAT => {
                Ok(words().map(f32::from_le_bytes).collect())
            }
            vk::Format::R32_UINT | vk::Format::R32G32_UINT => Ok(words().map(|word| u32::from_le_bytes(word) as f32).collect()),
            format => Err(unknown(format)),
        }
    }

    /// Red, green, blue and alpha bytes, for a picture file.
    ///
    /// # Errors
    /// A format other than 8-bit RGBA and BGRA.
    pub fn to_rgba8(&self) -> Result<Vec<u8>> {
        match self.format {
            vk::Format::R8G8B8A8_UNORM => Ok(self.bytes.clone()),
            vk::Format::B8G8R8A8_UNORM => {
                let mut bytes = self.bytes.clone();
                bytes.chunks_exact_mut(4).for_each(|texel| texel.swap(0, 2));
                Ok(bytes)
            }
            format => Err(unknown(format)),
        }
    }
}

fn unknown(format: vk::Format) -> VulkanError {
    let problem = format!("format {format:?} is not supported here");
    VulkanError::Access { what: "capture".to_owned(), problem }
}

/// IEEE 754 half precision, exactly.
fn half_to_f32(half: u16) -> f32 {
    let sign = if half & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(half >> 10 & 0x1f), f32::from(half & 0x3ff) / 1024.0);
    sign * match exponent {
        0 => fraction * 2f32.powi(-14),
        31 if fraction == 0.0 => f32::INFINITY,
        31 => f32::NAN,
        _ => (1.0 + fraction) * 2f32.powi(exponent - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::half_to_f32;

    #[test]
    fn halves_convert_exactly() {
        let cases = [(0x3c00, 1.0), (0xc000, -2.0), (0x0001, 2f32.powi(-24)), (0x7bff, 65504.0)];
        for (half, value) in cases {
            assert_eq!(half_to_f32(half), value, "{half:#x}");
        }
        assert_eq!(half_to_f32(0x7c00), f32::INFINITY);
        assert!(half_to_f32(0x7e00).is_nan());
    }
}
