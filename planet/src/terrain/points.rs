//! Chunks of points that are evaluated together, as one array a coordinate. In: unit directions. Out: metres from the planet's
//! centre, as seen from each of the few orientations that noise lattices share.
//!
//! Everything below a chunk runs once for each of [`LANES`] lanes in loops of constant length, which the compiler turns into
//! wide instructions; see [`super`] for why that cannot change a bit.

use glam::DVec3;

/// Points evaluated together. Neighbours should share a chunk: what they have in common is then worked out once.
pub(crate) const LANES: usize = 128;

/// One value for each point of a chunk.
pub(crate) type Lane = [f32; LANES];

/// One value for each point of a chunk where f32 would not resolve a millimetre on a planet.
pub(crate) type WideLane = [f64; LANES];

/// One value for each axis. Unlike the array methods of the standard library it is sure to be inlined: a call in a loop over lanes
/// would keep it from being vectorised.
#[inline(always)]
pub(crate) fn axes<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

/// Orientations of noise lattices, as quaternions. Successive octaves take them in turn, so that lattices of like size do not
/// line up and the grid does not show (Quilez, "fBM", 2019). Axes of any two are at least 26 degrees apart, and those of each
/// 36 degrees from the planet's own.
const QUATERNIONS: [[f64; 4]; TURNS] =
    [[3.0, -6.0, 0.0, 4.0], [6.0, 3.0, 4.0, 0.0], [5.0, -2.0, 3.0, 0.0], [3.0, -2.0, 0.0, 5.0]];

/// Number of orientations.
pub(crate) const TURNS: usize = 4;

/// Rows of each orientation's rotation matrix.
pub(crate) const ROTATIONS: [[[f64; 3]; 3]; TURNS] =
    [rotation(QUATERNIONS[0]), rotation(QUATERNIONS[1]), rotation(QUATERNIONS[2]), rotation(QUATERNIONS[3])];

/// Rotation matrix of a quaternion of any length but 0.
const fn rotation([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    let s = 2.0 / (w * w + x * x + y * y + z * z);
    [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]
}

/// A chunk of points, in metres from the planet's centre. Lanes past the last point repeat it.
pub(crate) struct Points {
    /// Planet-fixed coordinates.
    pub(crate) position: [WideLane; 3],
    /// The same in each orientation.
    pub(crate) turned: [Turned; TURNS],
}

/// Points in one orientation.
pub(crate) struct Turned {
    pub(crate) axes: [WideLane; 3],
    /// Smallest coordinates of all lanes.
    pub(crate) low: [f64; 3],
    /// Largest coordinates of all lanes.
    pub(crate) high: [f64; 3],
}

impl Points {
    /// Up to [`LANES`] points (at least one), given as directions from the centre of a planet of `radius` metres.
    #[inline(always)]
    pub(crate) fn new(radius: f64, count: usize, direction: impl Fn(usize) -> DVec3) -> Self {
        let mut position = [[0.0; LANES]; 3];
        for i in 0..LANES {
            let d = direction(i.min(count - 1));
            (position[0][i], position[1][i], position[2][i]) = (d.x * radius, d.y * radius, d.z * radius);
        }
        Self::at(position)
    }

    /// Points at positions in metres.
    pub(crate) fn at(position: [WideLane; 3]) -> Self {
        Self { turned: turned(&position), position }
    }
}

/// Out of line, as noise is.
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn turned(position: &[WideLane; 3]) -> [Turned; TURNS] {
    all_turned(position)
}

#[inline(always)]
fn all_turned(position: &[WideLane; 3]) -> [Turned; TURNS] {
    let turned = |turn: usize| Turned::new(position, &ROTATIONS[turn]);
    [turned(0), turned(1), turned(2), turned(3)]
}

impl Turned {
    #[inline(always)]
    fn new(position: &[WideLane; 3], rows: &[[f64; 3]; 3]) -> Self {
        let mut turned = Self { axes: [[0.0; LANES]; 3], low: [0.0; 3], high: [0.0; 3] };
        for (k, row) in rows.iter().enumerate() {
            let axis = &mut turned.axes[k];
            for i in 0..LANES {
                axis[i] = row[0] * position[0][i] + row[1] * position[1][i] + row[2] * position[2][i];
            }
            [turned.low[k], turned.high[k]] = bounds(axis);
        }
        turned
    }
}

/// Smallest and largest value. Compared as integers in the same order, because only integer reductions vectorise.
#[inline(always)]
fn bounds(lane: &WideLane) -> [f64; 2] {
    // Flips all bits of negative numbers but the sign; its own inverse.
    let order = |bits: i64| bits ^ ((bits >> 63) as u64 >> 1) as i64;
    let (mut low, mut high) = (i64::MAX, i64::MIN);
    for v in lane {
        let rank = order(v.to_bits() as i64);
        low = low.min(rank);
        high = high.max(rank);
    }
    [low, high].map(|rank| f64::from_bits(order(rank) as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_orthonormal() {
        for rows in ROTATIONS {
            for (a, b) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                let dot: f64 = (0..3).map(|k| rows[a][k] * rows[b][k]).sum();
                assert!((dot - f64::from(u8::from(a == b))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn orientations_do_not_line_up() {
        let axes: Vec<(usize, DVec3)> =
            ROTATIONS.iter().enumerate().flat_map(|(turn, rows)| rows.map(|row| (turn, DVec3::from_array(row)))).collect();
        for (turn, a) in &axes {
            let others = axes.iter().filter(|(other, _)| other != turn);
            assert!(others.map(|(_, b)| a.dot(*b).abs()).fold(0.0, f64::max) < 0.9, "{a} is nearly an axis of another");
            assert!(a.abs().max_element() < 0.81, "{a} is nearly the planet's own");
        }
    }

    #[multiversion::multiversion(targets("x86_64+avx2"))]
    fn narrower(position: &[WideLane; 3]) -> [Turned; TURNS] {
        all_turned(position)
    }

    #[test]
    fn wide_instructions_turn_points_elsewhere() {
        let axis = |k: usize| std::array::from_fn(|i| 6.1e6 * (0.3 + k as f64 + i as f64 * 1.7).sin());
        let position = [axis(0), axis(1), axis(2)];
        let bits = |turned: [Turned; TURNS]| {
            turned.map(|t| (t.axes.map(|a| a.map(f64::to_bits)), t.low.map(f64::to_bits), t.high.map(f64::to_bits)))
        };
        let portable = bits(all_turned(&position));
        assert!(bits(turned(&position)) == portable && bits(narrower(&position)) == portable);
    }

    #[test]
    fn bounds_contain_all_points() {
        let mut position = [[1.0; LANES]; 3];
        (position[1][5], position[2][LANES - 1]) = (-40.0, 70.0);
        for turned in Points::at(position).turned {
            for k in 0..3 {
                assert!(turned.axes[k].iter().all(|&v| turned.low[k] <= v && v <= turned.high[k]));
                assert!(turned.axes[k].contains(&turned.low[k]) && turned.axes[k].contains(&turned.high[k]));
            }
        }
    }
}
