//! Maps for the GLB of a coarse mesh, so that it looks like the ground that it stands for: a normal map from the heights, and on a planet the
//! albedo.
//!
//! In: a heightfield or patches of a planet, and how many texels a side. Out: PNG pictures, and where vertices lie in them. Normals
//! are in tangent space, as glTF has them: red along the tangent, green along the bitangent (up in the picture), blue along the
//! vertex normal. The vertex normals of such a mesh point straight up, away from the ground and not from its slopes, so that what a texel says
//! does not depend on the triangles.

pub(super) mod atlas;
pub(super) mod heightfield;
pub(super) mod planet;

use super::{ExportError, Picture};
use glam::DVec3;

/// Texels of the longer side of a map: powers of two, which every device can filter; more than most viewers take are refused.
pub const MAP_SIDES: std::ops::RangeInclusive<u32> = 64..=8192;

/// Texels of 8 bits a channel, rows from the top.
pub(crate) struct Bitmap {
    /// Texels from left to right and from top to bottom.
    pub(crate) size: [u32; 2],
    /// Red, green and blue of each.
    pub(crate) texels: Vec<[u8; 3]>,
}

impl Bitmap {
    /// A map of one colour.
    pub(crate) fn filled(size: [u32; 2], colour: [u8; 3]) -> Bitmap {
        Bitmap { size, texels: vec![colour; size[0] as usize * size[1] as usize] }
    }

    /// Puts a square of texels with its upper left corner at a place.
    pub(crate) fn put(&mut self, [left, top]: [u32; 2], side: u32, texels: &[[u8; 3]]) {
        for (row, texels) in texels.chunks(side as usize).enumerate() {
            let first = (top as usize + row) * self.size[0] as usize + left as usize;
            self.texels[first..first + texels.len()].copy_from_slice(texels);
        }
    }

    /// The same as a PNG.
    pub(crate) fn png(&self) -> Result<Picture, ExportError> {
        let failed = |problem: png::EncodingError| ExportError::Map { problem: problem.to_string() };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(self.texels.as_flattened()).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(Picture { mime: "image/png", bytes })
    }
}

/// The texel of a normal that leans by slopes: how much the ground rises a metre along the tangent and along the bitangent.
pub(crate) fn encode_normal([along, across]: [f64; 2]) -> [u8; 3] {
    DVec3::new(-along, -across, 1.0).normalize_or(DVec3::Z).to_array().map(|c| (127.5 * c + 127.5).round() as u8)
}

/// Fails for a side that a map cannot have.
///
/// # Errors
/// For any but a power of two within [`MAP_SIDES`].
pub fn check_map_side(side: u32) -> Result<(), ExportError> {
    if side.is_power_of_two() && MAP_SIDES.contains(&side) {
        Ok(())
    } else {
        Err(ExportError::MapSide { side })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_come_back_from_their_texels() {
        for slopes in [[0.0, 0.0], [0.5, -0.25], [-3.0, 2.0], [0.01, 0.0]] {
            let wanted = DVec3::new(-slopes[0], -slopes[1], 1.0).normalize();
            let found = DVec3::from_array(encode_normal(slopes).map(|c| f64::from(c) / 127.5 - 1.0)).normalize();
            assert!(found.angle_between(wanted).to_degrees() < 0.4, "{slopes:?}: {found}, expected {wanted}");
        }
    }

    #[test]
    fn sides_are_powers_of_two() {
        assert!([64, 1024, 8192].into_iter().all(|side| check_map_side(side).is_ok()));
        assert!([0, 1, 32, 1000, 16_384].into_iter().all(|side| check_map_side(side).is_err()));
    }
}
