//! Gradient noise (Perlin 1985, 2002) on slices of points, exact to the bit on every machine: only + - * on f64 and
//! integer hashing. In: points in metres. Out: one value in -1 to 1 for each point and octave.
//!
//! Each octave turns and shifts its domain by its own random rotation, so that no two lattices line up and the grid does
//! not show (Quilez, "fBM", 2019). Cells are 32-bit: recipes keep radius / wavelength below 2^30.

use std::array;

/// Points evaluated together. 128 keeps a chunk's arrays within the first-level cache.
pub(crate) const LANES: usize = 128;

/// One value for each point of a chunk.
pub(crate) type Lane = [f64; LANES];

/// A chunk of up to [`LANES`] points, in metres from the planet's centre.
#[derive(Clone)]
pub(crate) struct Points {
    pub(crate) x: Lane,
    pub(crate) y: Lane,
    pub(crate) z: Lane,
    pub(crate) count: usize,
}

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

/// A randomly turned and shifted lattice with cells of `cell_m` metres.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Rotation divided by the cell size: rows give the lattice coordinates.
    pub(crate) rows: [[f64; 3]; 3],
    /// Shift in cells.
    pub(crate) shift: [f64; 3],
    /// Seed of the cell hash.
    pub(crate) seed: u32,
}

impl Lattice {
    pub(crate) fn new(seed: u64, cell_m: f64) -> Self {
        let draws: [f64; 7] = array::from_fn(|i| unit(mix(seed ^ mix(i as u64))));
        let rotation = rotation([draws[0], draws[1], draws[2], draws[3]]);
        Self {
            rows: rotation.map(|row| row.map(|c| c / cell_m)),
            shift: [draws[4], draws[5], draws[6]].map(|d| d * 1000.0),
            seed: mix(seed) as u32,
        }
    }

    #[inline(always)]
    pub(crate) fn place(&self, x: f64, y: f64, z: f64) -> [f64; 3] {
        let row = |i: usize| self.rows[i][0] * x + self.rows[i][1] * y + self.rows[i][2] * z + self.shift[i];
        [row(0), row(1), row(2)]
    }
}

/// Rotation matrix of a random quaternion (never near zero: the first component is at least 0.25).
fn rotation(draws: [f64; 4]) -> [[f64; 3]; 3] {
    let q = [draws[0] * 0.75 + 0.25, draws[1] * 2.0 - 1.0, draws[2] * 2.0 - 1.0, draws[3] * 2.0 - 1.0];
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    let [w, x, y, z] = q.map(|c| c / length);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// 1.5 * 2^52: adding it rounds to a whole number that then stands in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Splits into cell and fraction. At whole numbers the cell may be the one below with fraction 1: noise is continuous
/// there, so both give the same value. Branch-free and without `floor`, so that it vectorises everywhere.
#[inline(always)]
pub(crate) fn split(v: f64) -> (u32, f64) {
    let rounded = (v - 0.5) + ROUND;
    (rounded.to_bits() as u32, v - (rounded - ROUND))
}

pub(crate) const PRIMES: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];

/// Scrambles the sum of a cell's axis hashes.
#[inline(always)]
pub(crate) fn scramble(h: u32) -> u32 {
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    let h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

#[inline(always)]
fn slope(hash: u32, dx: f64, dy: f64, dz: f64) -> f64 {
    let h = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    let h = h ^ (h >> 14);
    let part = |shift: u32| f64::from(((h >> shift) & 1023) as i32 - 512);
    part(22) * dx + part(12) * dy + part(2) * dz
}

#[inline(always)]
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline(always)]
fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Brings the noise to a standard deviation of about 1/3 (512 is a gradient component's largest value).
const SCALE: f64 = 1.45 / 512.0;

/// Gradient noise at one point, -1 to 1.
#[inline(always)]
pub(crate) fn noise(lattice: &Lattice, x: f64, y: f64, z: f64) -> f64 {
    let [px, py, pz] = lattice.place(x, y, z);
    let ((ix, fx), (iy, fy), (iz, fz)) = (split(px), split(py), split(pz));
    let x0 = ix.wrapping_mul(PRIMES[0]).wrapping_add(lattice.seed);
    let y0 = iy.wrapping_mul(PRIMES[1]);
    let z0 = iz.wrapping_mul(PRIMES[2]);
    let (x1, y1, z1) = (x0.wrapping_add(PRIMES[0]), y0.wrapping_add(PRIMES[1]), z0.wrapping_add(PRIMES[2]));
    let (gx, gy, gz) = (fx - 1.0, fy - 1.0, fz - 1.0);
    let (u, v, w) = (fade(fx), fade(fy), fade(fz));
    let at = |hx: u32, hy: u32, hz: u32, dx: f64, dy: f64, dz: f64| slope(hx ^ hy ^ hz, dx, dy, dz);
    let near = lerp(
        lerp(at(x0, y0, z0, fx, fy, fz), at(x1, y0, z0, gx, fy, fz), u),
        lerp(at(x0, y1, z0, fx, gy, fz), at(x1, y1, z0, gx, gy, fz), u),
        v,
    );
    let far = lerp(
        lerp(at(x0, y0, z1, fx, fy, gz), at(x1, y0, z1, gx, fy, gz), u),
        lerp(at(x0, y1, z1, fx, gy, gz), at(x1, y1, z1, gx, gy, gz), u),
        v,
    );
    (lerp(near, far, w) * SCALE).clamp(-1.0, 1.0)
}

#[inline(always)]
fn noise_lanes(lattice: &Lattice, p: &Points, out: &mut Lane) {
    let n = p.count.min(LANES);
    let (xs, ys, zs, out) = (&p.x[..n], &p.y[..n], &p.z[..n], &mut out[..n]);
    for i in 0..n {
        out[i] = noise(lattice, xs[i], ys[i], zs[i]);
    }
}

/// Gradient noise at every point of the chunk. The wider instructions give the same bits: the compiler never contracts
/// or reorders float operations, and fused multiply-add is not enabled.
#[multiversion::multiversion(targets("x86_64+avx2"))]
pub(crate) fn noise_at(lattice: &Lattice, p: &Points, out: &mut Lane) {
    noise_lanes(lattice, p, out);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Points {
        let lane = |salt: u64| array::from_fn(|i| (unit(mix(i as u64 ^ salt)) - 0.5) * 1.2e7);
        Points { x: lane(1 << 40), y: lane(2 << 40), z: lane(3 << 40), count: LANES }
    }

    #[test]
    fn wide_lanes_differ_from_single_points() {
        let (lattice, p) = (Lattice::new(7, 3.0), points());
        let mut wide = [0.0; LANES];
        noise_at(&lattice, &p, &mut wide);
        for (i, w) in wide.iter().enumerate() {
            assert_eq!(w.to_bits(), noise(&lattice, p.x[i], p.y[i], p.z[i]).to_bits());
        }
    }

    #[test]
    fn whole_coordinates_break_continuity() {
        let lattice = Lattice { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3], seed: 5 };
        for i in -20..20 {
            let x = f64::from(i);
            let step = noise(&lattice, x, 0.3, 0.7) - noise(&lattice, x + 1e-9, 0.3, 0.7);
            assert!(step.abs() < 1e-7, "jump of {step} at {x}");
        }
    }

    #[test]
    fn rotations_are_not_orthonormal() {
        for seed in 0..50 {
            let rows = Lattice::new(seed, 1.0).rows;
            for a in 0..3 {
                for b in 0..3 {
                    let dot: f64 = (0..3).map(|k| rows[a][k] * rows[b][k]).sum();
                    assert!((dot - f64::from(u8::from(a == b))).abs() < 1e-14);
                }
            }
        }
    }
}
