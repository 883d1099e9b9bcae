//! Per-patch textures: slope and albedo at twice the grid's resolution, from the terrain function alone, so that shading never
//! depends on the mesh (DESIGN section 7).
//!
//! A texture has one texel per half cell and [`GUTTER`] more on every side. The gutters hold the same function values as the
//! neighbours' texels, so filtering shows no seam, down to mip level 2.

use crate::ground::{strips, Ground, GroundColour, GroundPoint, HeightGrid, GUTTER};
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
    (127.5 + 127.5 * share * above_sea.signum() + 0.5) as u8
}

/// Slope in [-STEEPEST, STEEPEST] to 8 bits, by square root so that gentle slopes keep their precision.
#[inline(always)]
pub fn encode_slope(slope: f64) -> i8 {
    let clamped = (slope.abs() / STEEPEST).min(1.0);
    let code = (clamped.sqrt() * 127.0 + 0.5) as i32;
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
        let datum = ground.lattice.radius * ground.lattice.unit;
        let axis = DVec3::AXES[id.face.grid_axes().0].to_array();
        let (mut lower, mut upper) = (GridRow::new(grid.side), GridRow::new(grid.side));
        let mut texels = TexelRow::new(side);
        let mut slopes = vec![[0; 2]; side * side];
        let mut points = Vec::with_capacity(side * side);
        upper.fill(grid, 0, datum);
        for (row, slopes) in slopes.chunks_exact_mut(side).enumerate() {
            std::mem::swap(&mut lower, &mut upper);
            upper.fill(grid, row + 1, datum);
            shape_texels([&lower, &upper], axis, &mut texels, slopes);
            points.extend((0..side).map(|column| texels.point(column)));
        }
        let albedo = albedo(colour, &points, side);
        let above_sea = |p: &GroundPoint| colour.sea_level().map_or(u8::MAX, |level| encode_shore(p.height - level));
        let shore = points.iter().map(above_sea).collect();
        PatchTexture { slopes, albedo, shore }
    }
}

/// Albedo of a square of points, asked for in an order that suits the terrain.
fn albedo(colour: &dyn GroundColour, points: &[GroundPoint], side: usize) -> Vec<[u8; 3]> {
    let order = strips(side);
    let ordered: Vec<GroundPoint> = order.iter().map(|&k| points[k]).collect();
    let mut found = vec![[0; 3]; points.len()];
    colour.albedo(&ordered, &mut found);
    let mut albedo = vec![[0; 3]; points.len()];
    for (&k, found) in order.iter().zip(found) {
        albedo[k] = found;
    }
    albedo
}

/// A row of height samples: their places in metres from the planet's centre, one array an axis, and their heights.
struct GridRow {
    place: [Vec<f64>; 3],
    metres: Vec<f64>,
}

impl GridRow {
    fn new(samples: usize) -> GridRow {
        GridRow { place: [vec![0.0; samples], vec![0.0; samples], vec![0.0; samples]], metres: vec![0.0; samples] }
    }

    fn fill(&mut self, grid: &HeightGrid, row: usize, datum: f64) {
        let samples = row * grid.side..(row + 1) * grid.side;
        self.metres.copy_from_slice(&grid.metres[samples.clone()]);
        let [x, y, z] = &mut self.place;
        let places = x.iter_mut().zip(y).zip(z);
        for (((x, y), z), (d, h)) in places.zip(grid.directions[samples.clone()].iter().zip(&grid.metres[samples])) {
            let radius = datum + h;
            (*x, *y, *z) = (d.x * radius, d.y * radius, d.z * radius);
        }
    }
}

/// A row of texels: directions, heights in metres and tangents of the slope angle.
struct TexelRow {
    up: [Vec<f64>; 3],
    metres: Vec<f64>,
    steepness: Vec<f64>,
}

impl TexelRow {
    fn new(texels: usize) -> TexelRow {
        let zeros = || vec![0.0; texels];
        TexelRow { up: [zeros(), zeros(), zeros()], metres: zeros(), steepness: zeros() }
    }

    fn point(&self, k: usize) -> GroundPoint {
        let direction = DVec3::new(self.up[0][k], self.up[1][k], self.up[2][k]);
        GroundPoint { direction, height: self.metres[k], slope: self.steepness[k] }
    }
}

type Vector = [f64; 3];

#[inline(always)]
fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    [a[0] / length, a[1] / length, a[2] / length]
}

/// Direction and slopes of the texel between four places (left and right on the lower row, then on the upper).
#[inline(always)]
fn shape([p00, p10, p01, p11]: [Vector; 4], axis: Vector) -> (Vector, [f64; 2]) {
    let up = unit([0, 1, 2].map(|k| p00[k] + p10[k] + p01[k] + p11[k]));
    let share = dot(axis, up);
    let first = unit([0, 1, 2].map(|k| axis[k] - up[k] * share));
    let second = cross(up, first);
    let normal = cross([0, 1, 2].map(|k| p11[k] - p00[k]), [0, 1, 2].map(|k| p01[k] - p10[k]));
    let rise = dot(normal, up);
    (up, [-dot(normal, first) / rise, -dot(normal, second) / rise])
}

/// Fills a row of texels from the rows of samples below and above it. `axis` is the face's first grid axis.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn shape_texels(rows: [&GridRow; 2], axis: Vector, texels: &mut TexelRow, slopes: &mut [[i8; 2]]) {
    let count = slopes.len();
    let samples = |row: &GridRow, k: usize| -> Vector { [row.place[0][k], row.place[1][k], row.place[2][k]] };
    let [x, y, z] = &mut texels.up;
    let (x, y, z) = (&mut x[..count], &mut y[..count], &mut z[..count]);
    for (k, slopes) in slopes.iter_mut().enumerate() {
        let [lower, upper] = rows;
        let corners = [samples(lower, k), samples(lower, k + 1), samples(upper, k), samples(upper, k + 1)];
        let (up, slope) = shape(corners, axis);
        (x[k], y[k], z[k]) = (up[0], up[1], up[2]);
        texels.metres[k] = (lower.metres[k] + lower.metres[k + 1] + upper.metres[k] + upper.metres[k + 1]) * 0.25;
        texels.steepness[k] = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        *slopes = [encode_slope(slope[0]), encode_slope(slope[1])];
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
