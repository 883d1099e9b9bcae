//! Per-patch textures: slope and albedo at twice the grid's resolution, from the terrain function alone, so that shading never
//! depends on the mesh (DESIGN section 7).
//!
//! A texture has one texel per half cell and [`GUTTER`] more on every side. The gutters hold the same function values as the
//! neighbours' texels, so filtering shows no seam, down to mip level 2.

use crate::ground::{Ground, GroundColour, GroundPoint, HeightGrid, GUTTER};
use crate::patch::PatchId;
use glam::DVec3;

/// Mip levels whose gutters still hold a whole texel.
pub const MIP_LEVELS: u32 = 3;

/// Steepest slope (tangent) that the 8-bit encoding holds; steeper ones are clamped.
pub const STEEPEST: f64 = 4.0;

/// Metres above and below the sea that [`encode_shore`] tells apart.
pub const SHORE_RANGE: f64 = 400.0;

/// Slope and colour of a patch's ground, row by row, [`texture_side`] texels a side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PatchTexture {
    /// Encoded slopes along the two tangents of [`tangents`], see [`encode_slope`].
    pub slopes: Vec<[i8; 2]>,
    /// sRGB-encoded albedo.
    pub albedo: Vec<[u8; 3]>,
    /// Height above the sea, see [`encode_shore`].
    pub shore: Vec<u8>,
}

/// Texels along a side of the texture of a patch of `cells` cells.
pub fn texture_side(cells: u32) -> u32 {
    2 * cells + 2 * GUTTER as u32
}

/// Tangents of the sphere at `up` on a face: the first follows the face's first grid axis, the second is perpendicular.
pub fn tangents(id: PatchId, up: DVec3) -> (DVec3, DVec3) {
    let axis = DVec3::AXES[id.face.grid_axes().0];
    let along = axis - up * axis.dot(up);
    let first = along / along.dot(along).sqrt();
    (first, up.cross(first))
}

/// Height above the sea to 8 bits, by square root so that the shore line keeps its precision (2.5 cm): 0 is [`SHORE_RANGE`] below
/// the sea or deeper, 255 that much above it or higher. Shading needs it because the mesh may be coarser than the water is deep.
pub fn encode_shore(above_sea: f64) -> u8 {
    let share = (above_sea.abs() / SHORE_RANGE).min(1.0).sqrt();
    (127.5 + 127.5 * share * above_sea.signum()).round() as u8
}

/// Slope in [-STEEPEST, STEEPEST] to 8 bits, by square root so that gentle slopes keep their precision.
pub fn encode_slope(slope: f64) -> i8 {
    let clamped = (slope.abs() / STEEPEST).min(1.0);
    let code = (clamped.sqrt() * 127.0).round();
    (if slope < 0.0 { -code } else { code }) as i8
}

/// The slope that [`encode_slope`] stored.
pub fn decode_slope(code: i8) -> f64 {
    let x = f64::from(code.max(-127)) / 127.0;
    x * x.abs() * STEEPEST
}

impl PatchTexture {
    /// Textures of a sampled patch.
    pub fn new(ground: &Ground, colour: &dyn GroundColour, id: PatchId, grid: &HeightGrid) -> PatchTexture {
        let side = texture_side(ground.cells) as usize;
        let radius = ground.lattice.radius * ground.lattice.unit;
        let mut slopes = Vec::with_capacity(side * side);
        let mut points = Vec::with_capacity(side * side);
        let positions: Vec<DVec3> = grid.directions.iter().zip(&grid.metres).map(|(&d, &h)| d * (radius + h)).collect();
        for row in 0..side {
            for column in 0..side {
                let corners = [0, 1, grid.side, grid.side + 1].map(|k| row * grid.side + column + k);
                let [p00, p10, p01, p11] = corners.map(|k| positions[k]);
                let sum = p00 + p10 + p01 + p11;
                let up = sum / sum.dot(sum).sqrt();
                let (first, second) = tangents(id, up);
                let normal = (p11 - p00).cross(p01 - p10);
                let rise = normal.dot(up);
                let slope = [-normal.dot(first) / rise, -normal.dot(second) / rise];
                let height = corners.iter().map(|&k| grid.metres[k]).sum::<f64>() / 4.0;
                slopes.push(slope.map(encode_slope));
                points.push(GroundPoint { direction: up, height, slope: (slope[0] * slope[0] + slope[1] * slope[1]).sqrt() });
            }
        }
        let mut albedo = vec![[0; 3]; points.len()];
        colour.albedo(&points, &mut albedo);
        let above_sea = |p: &GroundPoint| colour.sea_level().map_or(u8::MAX, |level| encode_shore(p.height - level));
        let shore = points.iter().map(above_sea).collect();
        PatchTexture { slopes, albedo, shore }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_survive_the_encoding() {
        for slope in [0.0, 0.001, -0.02, 0.3, -1.0, 3.9] {
            let error = (decode_slope(encode_slope(slope)) - slope).abs();
            assert!(error <= 2.0 * (slope.abs() * STEEPEST).sqrt() / 127.0 + 1e-4, "{slope}: {error}");
        }
        assert_eq!(decode_slope(encode_slope(99.0)), STEEPEST);
        assert_eq!(decode_slope(i8::MIN), -STEEPEST);
    }

    #[test]
    fn the_shore_line_is_in_the_middle_of_its_code() {
        assert_eq!([encode_shore(-1e4), encode_shore(-0.1), encode_shore(0.1), encode_shore(1e4)], [0, 125, 130, 255]);
    }
}
