//! Per-patch textures: slope and albedo at twice the grid's resolution, from the terrain function alone, so that shading never
//! depends on the mesh (docs/design.md, "Shading").
//!
//! A texture has one texel per half cell and [`GUTTER`] more on every side. The gutters hold the same function values as the
//! neighbours' texels, so filtering shows no seam, down to mip level 2.

use super::{strips, Ground, GroundColour, GroundPoint, HeightGrid, GUTTER};
use crate::globe::patch::PatchId;
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
        let frame =
            Frame { datum: ground.lattice.radius * ground.lattice.unit, axis: DVec3::AXES[id.face.grid_axes().0].to_array() };
        let mut slopes = vec![[0; 2]; side * side];
        let spacing = 0.5 * ground.lattice.sample_spacing(ground.cells, id.level) * ground.lattice.unit;
        let mut points = vec![GroundPoint { direction: DVec3::ZERO, height: 0.0, slope: 0.0, north: 0.0, spacing }; side * side];
        for (row, (slopes, points)) in slopes.chunks_exact_mut(side).zip(points.chunks_exact_mut(side)).enumerate() {
            for first in (0..side).step_by(RUN) {
                let run = first..(first + RUN).min(side);
                shape_run(grid, &frame, [first, row], &mut slopes[run.clone()], &mut points[run]);
            }
        }
        let albedo = albedo(colour, &points, side);
        let shore = match colour.above_sea(&points) {
            Some(above) => above.into_iter().map(encode_shore).collect(),
            None => vec![u8::MAX; points.len()],
        };
        PatchTexture { slopes, albedo, shore }
    }
}

/// Albedo of a square of points, asked for in an order that suits the terrain.
pub(crate) fn albedo(colour: &dyn GroundColour, points: &[GroundPoint], side: usize) -> Vec<[u8; 3]> {
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

/// Texels shaped together.
const RUN: usize = 32;

/// What the slopes of a patch refer to.
struct Frame {
    /// Radius in metres that heights are added to.
    datum: f64,
    /// The face's first grid axis.
    axis: Vector,
}

type Vector = [f64; 3];

/// One value for each axis, sure to be inlined.
#[inline(always)]
fn axes(of: impl Fn(usize) -> f64) -> Vector {
    [of(0), of(1), of(2)]
}

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

/// Direction and slopes of the texel between four points (left and right on the lower row, then on the upper): along both
/// tangents and towards the north.
#[inline(always)]
pub(crate) fn shape([p00, p10, p01, p11]: [Vector; 4], axis: Vector) -> (Vector, [f64; 3]) {
    let up = unit(axes(|k| p00[k] + p10[k] + p01[k] + p11[k]));
    let share = dot(axis, up);
    let first = unit(axes(|k| axis[k] - up[k] * share));
    let second = cross(up, first);
    let normal = cross(axes(|k| p11[k] - p00[k]), axes(|k| p01[k] - p10[k]));
    let rise = dot(normal, up);
    let [along, across] = [-dot(normal, first) / rise, -dot(normal, second) / rise];
    let north = (along * first[2] + across * second[2]) / (1.0 - up[2] * up[2]).max(1e-12).sqrt();
    (up, [along, across, north])
}

/// Shapes up to [`RUN`] texels of a row, the first of which lies at `[column, row]`: encoded slopes, and the points whose albedo is
/// then asked for. Local arrays of constant length, so that the middle loop vectorises; see [`crate::terrain`] for why that
/// changes no bit.
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn shape_run(grid: &HeightGrid, frame: &Frame, [column, row]: [usize; 2], slopes: &mut [[i8; 2]], points: &mut [GroundPoint]) {
    let mut corners = [[[0.0; RUN + 1]; 3]; 2];
    for (r, [x, y, z]) in corners.iter_mut().enumerate() {
        let first = (row + r) * grid.side + column;
        let samples = first..=first + slopes.len();
        for (i, (d, h)) in grid.directions[samples.clone()].iter().zip(&grid.sampled.metres[samples]).enumerate() {
            let radius = frame.datum + h;
            (x[i], y[i], z[i]) = (d.x * radius, d.y * radius, d.z * radius);
        }
    }
    let (mut ups, mut tangents) = ([[0.0; RUN]; 3], [[0.0; RUN]; 3]);
    for i in 0..RUN {
        let corner = |r: usize, i: usize| axes(|k| corners[r][k][i]);
        let (up, slope) = shape([corner(0, i), corner(0, i + 1), corner(1, i), corner(1, i + 1)], frame.axis);
        (ups[0][i], ups[1][i], ups[2][i]) = (up[0], up[1], up[2]);
        (tangents[0][i], tangents[1][i], tangents[2][i]) = (slope[0], slope[1], slope[2]);
    }
    let lower = &grid.sampled.metres[row * grid.side + column..];
    let upper = &grid.sampled.metres[(row + 1) * grid.side + column..];
    for (i, (slopes, point)) in slopes.iter_mut().zip(points).enumerate() {
        let slope = [tangents[0][i], tangents[1][i]];
        *slopes = [encode_slope(slope[0]), encode_slope(slope[1])];
        point.direction = DVec3::new(ups[0][i], ups[1][i], ups[2][i]);
        point.height = (lower[i] + lower[i + 1] + upper[i] + upper[i + 1]) * 0.25;
        point.slope = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        point.north = tangents[2][i];
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
