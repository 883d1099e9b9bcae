//! Gradient noise (Perlin 1985, 2002) on chunks of points, exact to the bit on every machine: only + - * on floats and integer
//! hashing. In: points in metres. Out: one value in -1 to 1 for each point.
//!
//! Where a point lies in its cell is worked out in f64, the rest in f32: a tenth of a millimetre of a kilometre. A chunk that
//! lies in one cell looks its eight gradients up once. Cells are 32-bit: recipes keep radius / wavelength below 2^30.

use super::points::{axes, Lane, Points, LANES, ROTATIONS, TURNS};
use std::array;

/// One step of the splitmix64 generator (Steele, Lea, Flood 2014).
pub(crate) fn mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A number in 0 to 1 from the top 53 bits.
pub(crate) fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

/// A shifted lattice of cubic cells in one of the shared orientations. The cell of number n is centred at n.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Which of the shared orientations.
    pub(crate) turn: usize,
    /// Cells a metre.
    pub(crate) per_metre: f64,
    /// Shift in cells.
    pub(crate) shift: [f64; 3],
    /// Seed of the cell hash.
    pub(crate) seed: u32,
}

impl Lattice {
    /// A lattice with cells of `cell_m` metres; lattices of successive numbers `turn` differ in orientation.
    pub(crate) fn new(seed: u64, turn: usize, cell_m: f64) -> Self {
        let shift = array::from_fn(|i| unit(mix(seed ^ mix(i as u64))) * 1000.0);
        Self { turn: turn % TURNS, per_metre: 1.0 / cell_m, shift, seed: mix(seed) as u32 }
    }

    /// Lattice coordinate `axis` of a turned one in metres.
    #[inline(always)]
    pub(crate) fn coordinate(&self, axis: usize, metres: f64) -> f64 {
        metres * self.per_metre + self.shift[axis]
    }

    /// The nearest whole coordinates below and above which no point of the chunk comes. Rounding is monotone, so that all
    /// points lie in one cell where both agree.
    #[inline(always)]
    pub(crate) fn span(&self, p: &Points) -> [[f64; 3]; 2] {
        let turned = &p.turned[self.turn];
        let cell = |k: usize, metres: f64| nearest(self.coordinate(k, metres)).1;
        [axes(|k| cell(k, turned.low[k])), axes(|k| cell(k, turned.high[k]))]
    }

    /// Calls `visit` with every lane and its noise.
    #[inline(always)]
    pub(crate) fn noise(&self, p: &Points, mut visit: impl FnMut(usize, f32)) {
        let mut noise = [0.0; LANES];
        chunk_noise(self, p, &mut noise);
        for i in 0..LANES {
            visit(i, noise[i]);
        }
    }

    /// Calls `visit` with every lane, its noise, and how much that grows in one cell along each of the planet's axes.
    #[inline(always)]
    pub(crate) fn noise_and_slope(&self, p: &Points, mut visit: impl FnMut(usize, f32, [f32; 3])) {
        let (mut noise, mut slope) = ([0.0; LANES], [[0.0; LANES]; 3]);
        chunk_noise_and_slope(self, p, &mut noise, &mut slope);
        for i in 0..LANES {
            visit(i, noise[i], axes(|k| slope[k][i]));
        }
    }

    /// Calls `visit` with every lane and the cosine and sine of waves that differ from cell to cell, blended. `waves` says for each
    /// lane how many crests there are in one cell along each of the planet's axes.
    #[inline(always)]
    pub(crate) fn waves(&self, p: &Points, waves: &[Lane; 3], mut visit: impl FnMut(usize, f32, f32)) {
        let [mut cosine, mut sine] = [[0.0; LANES]; 2];
        chunk_waves(self, p, waves, [&mut cosine, &mut sine]);
        for i in 0..LANES {
            visit(i, cosine[i], sine[i]);
        }
    }

    /// Rows of the orientation's rotation matrix.
    #[inline(always)]
    fn rows(&self) -> [[f32; 3]; 3] {
        axes(|row| axes(|k| ROTATIONS[self.turn][row][k] as f32))
    }

    /// Shows a visitor the cell of every lane.
    #[inline(always)]
    fn visit(&self, p: &Points, mut visitor: impl Visitor) {
        let points = &p.turned[self.turn].axes;
        let mut fractions = [[0.0; LANES]; 3];
        let [low, high] = self.span(p);
        if low == high {
            for k in 0..3 {
                for i in 0..LANES {
                    fractions[k][i] = (self.coordinate(k, points[k][i]) - low[k]) as f32;
                }
            }
            let gradients = Corners::new(self.seed, axes(|k| nearest(low[k]).0)).gradients();
            for i in 0..LANES {
                visitor.see(i, axes(|k| fractions[k][i]), |corner| axes(|k| gradients[k][corner]));
            }
        } else {
            let mut cells = [[0; LANES]; 3];
            for k in 0..3 {
                for i in 0..LANES {
                    let coordinate = self.coordinate(k, points[k][i]);
                    let (cell, rounded) = nearest(coordinate);
                    (cells[k][i], fractions[k][i]) = (cell, (coordinate - rounded) as f32);
                }
            }
            for i in 0..LANES {
                let corners = Corners::new(self.seed, axes(|k| cells[k][i]));
                visitor.see(i, axes(|k| fractions[k][i]), |corner| corners.gradient(corner));
            }
        }
    }
}

// Noise of a chunk, out of line: a copy in each of the many places that sum noise, for each set of instructions, takes longer to
// compile than all the rest. A call for all lanes costs nothing.

#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn chunk_noise(lattice: &Lattice, p: &Points, out: &mut Lane) {
    lattice.visit(p, Noise(|i, noise| out[i] = noise));
}

#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn chunk_noise_and_slope(lattice: &Lattice, p: &Points, out: &mut Lane, slope: &mut [Lane; 3]) {
    let visit = |i: usize, noise, own: [f32; 3]| {
        out[i] = noise;
        (slope[0][i], slope[1][i], slope[2][i]) = (own[0], own[1], own[2]);
    };
    lattice.visit(p, NoiseAndSlope { rows: lattice.rows(), visit });
}

#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn chunk_waves(lattice: &Lattice, p: &Points, waves: &[Lane; 3], [cosine, sine]: [&mut Lane; 2]) {
    let visit = |i: usize, c, s| (cosine[i], sine[i]) = (c, s);
    lattice.visit(p, Waves { rows: lattice.rows(), waves, visit });
}

/// 1.5 * 2^52: adding it rounds to a whole number that then stands in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// The same for f32: 1.5 * 2^23.
const ROUND_F32: f32 = 12_582_912.0;

/// The nearest whole number, as the low 32 bits of an integer and as a float. Half-way it may be either: noise is continuous
/// there, so both give the same value. Branch-free and without `round`, so that it vectorises everywhere.
#[inline(always)]
pub(crate) fn nearest(v: f64) -> (u32, f64) {
    let rounded = v + ROUND;
    (rounded.to_bits() as u32, rounded - ROUND)
}

/// Odd factors that spread the cells of an axis.
pub(crate) const PRIMES: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];

/// The eight corners of a cell, as hashes of their coordinates. Bit k of a corner's number says whether it is the farther one on
/// axis k.
struct Corners {
    near: [u32; 3],
    far: [u32; 3],
}

impl Corners {
    #[inline(always)]
    fn new(seed: u32, cell: [u32; 3]) -> Self {
        let [x, y, z] = axes(|k| cell[k].wrapping_mul(PRIMES[k]));
        let near = [x.wrapping_add(seed), y, z];
        Self { near, far: axes(|k| near[k].wrapping_add(PRIMES[k])) }
    }

    /// The gradient of a corner.
    #[inline(always)]
    fn gradient(&self, corner: usize) -> [f32; 3] {
        let axis = |k: usize| if corner >> k & 1 == 0 { self.near[k] } else { self.far[k] };
        gradient(axis(0) ^ axis(1) ^ axis(2))
    }

    /// The gradients of all corners, one array a component.
    #[inline(always)]
    fn gradients(&self) -> [[f32; 8]; 3] {
        /// All bits where a corner is the farther one on an axis.
        const FAR: [[u32; 8]; 3] = [[0, !0, 0, !0, 0, !0, 0, !0], [0, 0, !0, !0, 0, 0, !0, !0], [0, 0, 0, 0, !0, !0, !0, !0]];
        let mut gradients = [[0.0; 8]; 3];
        for corner in 0..8 {
            let axis = |k: usize| self.near[k].wrapping_add(PRIMES[k] & FAR[k][corner]);
            let g = gradient(axis(0) ^ axis(1) ^ axis(2));
            (gradients[0][corner], gradients[1][corner], gradients[2][corner]) = (g[0], g[1], g[2]);
        }
        gradients
    }
}

/// The gradient of a hash, each component even over ± 2^31: one multiplication spreads the sum of a corner's axes into the upper
/// bits, which is where conversion to f32 looks.
#[inline(always)]
fn gradient(hash: u32) -> [f32; 3] {
    let h = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    [h as i32 as f32, (h << 11) as i32 as f32, h.wrapping_mul(0x297a_2d39) as i32 as f32]
}

/// Brings the noise to a standard deviation of about 1/3.
const SCALE: f32 = 1.45 / 2_147_483_648.0;

/// Noise at an offset between -1/2 and 1/2 in a cell, from the gradients at its corners.
#[inline(always)]
fn blend(at: [f32; 3], gradient: impl Fn(usize) -> [f32; 3]) -> f32 {
    let near = axes(|k| at[k] + 0.5);
    let far = axes(|k| at[k] - 0.5);
    let [u, v, w] = axes(|k| fade(at[k]));
    let slope = |corner: usize| {
        let offset = |k: usize| if corner >> k & 1 == 0 { near[k] } else { far[k] };
        let g = gradient(corner);
        g[0] * offset(0) + g[1] * offset(1) + g[2] * offset(2)
    };
    let edge = |corner: usize| lerp(slope(corner), slope(corner + 1), u);
    let side = |corner: usize| lerp(edge(corner), edge(corner + 2), v);
    (lerp(side(0), side(4), w) * SCALE).clamp(-1.0, 1.0)
}

/// What is worked out for a lane from its offset in its cell, each coordinate between -1/2 and 1/2, and from the gradients of the
/// cell's corners.
trait Visitor {
    fn see(&mut self, lane: usize, at: [f32; 3], gradient: impl Fn(usize) -> [f32; 3]);
}

struct Noise<V>(V);

impl<V: FnMut(usize, f32)> Visitor for Noise<V> {
    #[inline(always)]
    fn see(&mut self, lane: usize, at: [f32; 3], gradient: impl Fn(usize) -> [f32; 3]) {
        (self.0)(lane, blend(at, gradient));
    }
}

struct NoiseAndSlope<V> {
    rows: [[f32; 3]; 3],
    visit: V,
}

impl<V: FnMut(usize, f32, [f32; 3])> Visitor for NoiseAndSlope<V> {
    #[inline(always)]
    fn see(&mut self, lane: usize, at: [f32; 3], gradient: impl Fn(usize) -> [f32; 3]) {
        let (share, rise) = (axes(|k| fade(at[k])), axes(|k| fade_slope(at[k])));
        // A closure that is called eight times would stay out of line, and then is not compiled for wide instructions.
        let planes = [
            plane(at, 0, &gradient),
            plane(at, 1, &gradient),
            plane(at, 2, &gradient),
            plane(at, 3, &gradient),
            plane(at, 4, &gradient),
            plane(at, 5, &gradient),
            plane(at, 6, &gradient),
            plane(at, 7, &gradient),
        ];
        let edge = |corner: usize| joined(planes[corner], planes[corner + 1], [share[0], rise[0]], 1);
        let side = |corner: usize| joined(edge(corner), edge(corner + 2), [share[1], rise[1]], 2);
        let [noise, x, y, z] = joined(side(0), side(4), [share[2], rise[2]], 3);
        let rows = &self.rows;
        let slope = axes(|k| (rows[0][k] * x + rows[1][k] * y + rows[2][k] * z) * SCALE);
        (self.visit)(lane, (noise * SCALE).clamp(-1.0, 1.0), slope);
    }
}

struct Waves<'a, V> {
    rows: [[f32; 3]; 3],
    waves: &'a [Lane; 3],
    visit: V,
}

impl<V: FnMut(usize, f32, f32)> Visitor for Waves<'_, V> {
    #[inline(always)]
    fn see(&mut self, lane: usize, at: [f32; 3], gradient: impl Fn(usize) -> [f32; 3]) {
        /// How far the middle of a corner's waves is moved, at most, in cells.
        const MOVED: f32 = 0.3 / 2_147_483_648.0;
        let along = axes(|k| self.waves[k][lane]);
        let own = axes(|row| self.rows[row][0] * along[0] + self.rows[row][1] * along[1] + self.rows[row][2] * along[2]);
        let share = axes(|k| fade(at[k]));
        let (mut cosine, mut sine) = (0.0, 0.0);
        for corner in 0..8 {
            let (g, [x, y, z]) = (gradient(corner), offset(at, corner));
            let turns = own[0] * (x + g[0] * MOVED) + own[1] * (y + g[1] * MOVED) + own[2] * (z + g[2] * MOVED);
            let part = |k: usize| if corner >> k & 1 == 0 { 1.0 - share[k] } else { share[k] };
            let weight = part(0) * part(1) * part(2);
            cosine += weight * sine_of_turns(turns + 0.25);
            sine += weight * sine_of_turns(turns);
        }
        (self.visit)(lane, cosine, sine);
    }
}

/// The plane of a corner: its value at a point in its cell, and its gradient.
#[inline(always)]
fn plane(at: [f32; 3], corner: usize, gradient: impl Fn(usize) -> [f32; 3]) -> [f32; 4] {
    let (g, [x, y, z]) = (gradient(corner), offset(at, corner));
    [g[0] * x + g[1] * y + g[2] * z, g[0], g[1], g[2]]
}

/// From a corner to a point in its cell.
#[inline(always)]
fn offset(at: [f32; 3], corner: usize) -> [f32; 3] {
    axes(|k| if corner >> k & 1 == 0 { at[k] + 0.5 } else { at[k] - 0.5 })
}

/// The sine of so many whole turns, to 0.001: two parabolas, bent once more.
#[inline(always)]
fn sine_of_turns(turns: f32) -> f32 {
    let t = turns - ((turns + ROUND_F32) - ROUND_F32);
    let rough = 8.0 * t - 16.0 * t * t.abs();
    rough + 0.224 * (rough * rough.abs() - rough)
}

/// Between two values with derivatives, by a share that grows by `rise` along the axis whose derivative stands at `axis`.
#[inline(always)]
fn joined(a: [f32; 4], b: [f32; 4], [share, rise]: [f32; 2], axis: usize) -> [f32; 4] {
    let mut out = [lerp(a[0], b[0], share), lerp(a[1], b[1], share), lerp(a[2], b[2], share), lerp(a[3], b[3], share)];
    out[axis] += (b[0] - a[0]) * rise;
    out
}

/// Perlin's quintic, 0 to 1 over -1/2 to 1/2.
#[inline(always)]
fn fade(t: f32) -> f32 {
    let t2 = t * t;
    t * (t2 * (t2 * 6.0 - 5.0) + 1.875) + 0.5
}

/// Its derivative.
#[inline(always)]
fn fade_slope(t: f32) -> f32 {
    let t2 = t * t;
    t2 * (t2 * 30.0 - 15.0) + 1.875
}

#[inline(always)]
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// The noise of a lattice of unit cells at one position within 2^20 of the origin.
#[inline(always)]
pub(crate) fn noise_at(seed: u32, at: [f32; 3]) -> f32 {
    let rounded = axes(|k| at[k] + ROUND_F32);
    let corners = Corners::new(seed, axes(|k| rounded[k].to_bits()));
    blend(axes(|k| at[k] - (rounded[k] - ROUND_F32)), |corner| corners.gradient(corner))
}

/// Noise of every lane, for those who do not sum octaves.
#[cfg(test)]
fn lanes(lattice: &Lattice, p: &Points) -> super::points::Lane {
    let mut out = [0.0; LANES];
    lattice.noise(p, |i, n| out[i] = n);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points anywhere in a cube of `spread` metres, far from the origin.
    fn points(spread: f64) -> Points {
        let axis = |salt: u64| array::from_fn(|i| 6.1e6 + (unit(mix(i as u64 ^ salt)) - 0.5) * spread);
        Points::at([axis(1 << 40), axis(2 << 40), axis(3 << 40)])
    }

    /// All noises of a chunk with instructions that few machines lack.
    #[multiversion::multiversion(targets("x86_64+avx2"))]
    fn narrower(lattice: &Lattice, p: &Points, waves: &[Lane; 3]) -> [Lane; 7] {
        all(lattice, p, waves)
    }

    #[inline(always)]
    fn all(lattice: &Lattice, p: &Points, waves: &[Lane; 3]) -> [Lane; 7] {
        let mut out = [[0.0; LANES]; 7];
        lattice.visit(p, Noise(|i, noise| out[0][i] = noise));
        let visit = |i: usize, noise, slope: [f32; 3]| {
            (out[1][i], out[2][i], out[3][i], out[4][i]) = (noise, slope[0], slope[1], slope[2])
        };
        lattice.visit(p, NoiseAndSlope { rows: lattice.rows(), visit });
        let visit = |i: usize, cosine, sine| (out[5][i], out[6][i]) = (cosine, sine);
        lattice.visit(p, Waves { rows: lattice.rows(), waves, visit });
        out
    }

    #[test]
    fn wide_instructions_change_noise() {
        for (cell_m, spread) in [(0.7, 10.0), (30.0, 10.0), (30.0, 500.0), (4e5, 10.0), (4e5, 3e6)] {
            let (lattice, p) = (Lattice::new(7, 1, cell_m), points(spread));
            let waves = [[0.3; LANES], [-1.7; LANES], [2.1; LANES]];
            let mut widest = [[0.0; LANES]; 7];
            let [a, b, c, d, e, f, g] = &mut widest;
            lattice.noise(&p, |i, noise| a[i] = noise);
            lattice.noise_and_slope(&p, |i, noise, slope| (b[i], c[i], d[i], e[i]) = (noise, slope[0], slope[1], slope[2]));
            lattice.waves(&p, &waves, |i, cosine, sine| (f[i], g[i]) = (cosine, sine));
            let bits = |lanes: [Lane; 7]| lanes.map(|lane| lane.map(f32::to_bits));
            let portable = bits(all(&lattice, &p, &waves));
            assert!(bits(widest) == portable && bits(narrower(&lattice, &p, &waves)) == portable, "cells of {cell_m} m");
        }
    }

    #[test]
    fn one_cell_for_all_equals_a_cell_for_each() {
        let p = points(10.0);
        for cell_m in [0.7, 30.0, 4e5] {
            let lattice = Lattice::new(7, 1, cell_m);
            let together = lanes(&lattice, &p);
            let [low, high] = lattice.span(&p);
            assert_eq!(low == high, cell_m > 1e3, "{cell_m} m no longer tests what it should");
            for i in 0..LANES {
                let alone = Points::at([0, 1, 2].map(|k| [p.position[k][i]; LANES]));
                assert_eq!(together[i].to_bits(), lanes(&lattice, &alone)[0].to_bits(), "{cell_m} m");
            }
        }
    }

    #[test]
    fn slope_is_the_derivative() {
        let (lattice, metres) = (Lattice::new(7, 1, 300.0), 0.5);
        let p = points(5e3);
        let mut slopes = [[0.0; 3]; LANES];
        let mut values = [0.0; LANES];
        lattice.noise_and_slope(&p, |i, value, slope| (values[i], slopes[i]) = (value, slope));
        assert_eq!(values, lanes(&lattice, &p));
        for k in 0..3 {
            let moved = |by: f64| {
                let mut position = p.position;
                position[k].iter_mut().for_each(|x| *x += by);
                lanes(&lattice, &Points::at(position))
            };
            let (back, ahead) = (moved(-metres), moved(metres));
            for i in 0..LANES {
                let found = (ahead[i] - back[i]) * 300.0 / (2.0 * metres as f32);
                assert!((found - slopes[i][k]).abs() < 0.01, "axis {k}: {found} and {}", slopes[i][k]);
            }
        }
    }

    #[test]
    fn waves_are_sines_and_cosines() {
        for i in -300..300 {
            let turns = i as f32 * 0.01;
            assert!((sine_of_turns(turns) - (turns * std::f32::consts::TAU).sin()).abs() < 2e-3, "{turns}");
        }
        // Waves with one crest a cell along x: over many cells crests and troughs cancel, and the waves have amplitude.
        let (lattice, p) = (Lattice::new(7, 1, 300.0), points(5e3));
        let mut still = [0.0; LANES];
        lattice.waves(&p, &[[0.0; LANES]; 3], |i, cosine, sine| still[i] = (cosine - 1.0).abs() + sine.abs());
        assert!(still.iter().all(|x| *x < 2e-3), "{still:?}");
        let mut sums = [0.0; 2];
        lattice.waves(&p, &[[1.0; LANES], [0.0; LANES], [0.0; LANES]], |_, cosine, sine| {
            sums = [sums[0] + cosine, sums[1] + cosine * cosine + sine * sine];
        });
        assert!(sums[0].abs() < 0.3 * LANES as f32 && sums[1] > 0.1 * LANES as f32, "{sums:?}");
    }

    #[test]
    fn noise_is_continuous_across_cell_borders() {
        for i in -20..20 {
            let x = i as f32 + 0.5;
            let step = noise_at(5, [x - 1e-6, 0.3, 0.2]) - noise_at(5, [x + 1e-6, 0.3, 0.2]);
            assert!(step.abs() < 1e-5, "jump of {step} at {x}");
        }
    }

    #[test]
    fn noise_has_no_bias_and_the_expected_strength() {
        let values: Vec<f32> =
            [3.0, 5.0, 11.0].into_iter().flat_map(|m| lanes(&Lattice::new(m as u64, 2, m), &points(1e5))).collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let deviation = (values.iter().map(|v| v * v).sum::<f32>() / values.len() as f32).sqrt();
        assert!(mean.abs() < 0.1 && (0.25..0.45).contains(&deviation), "mean {mean}, deviation {deviation}");
    }

    #[test]
    fn gradients_are_uncorrelated() {
        // Correlation of every component with every component of the same and of the next cell on each axis.
        let at = |c: [u32; 3]| Corners::new(9, c).gradient(0);
        let cells = 40_000u32;
        for step in [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]] {
            let mut sums = [[0.0f64; 3]; 3];
            for n in 0..cells {
                let cell = [n % 200, n / 200, n % 7];
                let (a, b) = (at(cell), at([0, 1, 2].map(|k| cell[k] + step[k])));
                for (row, a) in sums.iter_mut().zip(a) {
                    for (sum, b) in row.iter_mut().zip(b) {
                        *sum += f64::from(a) * f64::from(b) / (f64::from(cells) * 2.0f64.powi(62) / 3.0);
                    }
                }
            }
            for (j, row) in sums.iter().enumerate() {
                for (k, sum) in row.iter().enumerate() {
                    let same = step == [0, 0, 0] && j == k;
                    assert!((sum - f64::from(u8::from(same))).abs() < 0.03, "step {step:?}, components {j}, {k}: {sum}");
                }
            }
        }
    }
}
