//! A small analytic terrain for tests: a few octaves of value noise over the sphere, ridged or not.

use glam::{DVec3, IVec3};
use terrane_planet::globe::lattice::Lattice;
use terrane_planet::ground::{Elevation, Ground};

/// Fractal test terrain. Amplitudes are in proportion to wavelengths, so that every level adds relief.
pub(crate) struct TestField {
    pub(crate) radius: f64,
    pub(crate) roughness: f64,
    pub(crate) ridged: bool,
    pub(crate) seed: u32,
}

fn hash(cell: IVec3, seed: u32) -> f64 {
    let mut h = (cell.x as u32).wrapping_mul(0x8da6_b343)
        ^ (cell.y as u32).wrapping_mul(0xd816_3841)
        ^ (cell.z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed;
    h ^= h >> 13;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 16;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^= h >> 15;
    f64::from(h & 0xff_ffff) / 8_388_608.0 - 1.0
}

fn noise(p: DVec3, seed: u32) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let s = f * f * (DVec3::splat(3.0) - 2.0 * f);
    let cell = cell.as_ivec3();
    let corner = |x: i32, y: i32, z: i32| hash(cell + IVec3::new(x, y, z), seed);
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let plane = |z| {
        let row = |y| lerp(corner(0, y, z), corner(1, y, z), s.x);
        lerp(row(0), row(1), s.y)
    };
    lerp(plane(0), plane(1), s.z)
}

impl TestField {
    pub(crate) fn at(&self, direction: DVec3) -> f64 {
        let mut wavelength = self.radius;
        let mut sum = 0.0;
        for octave in 0..14 {
            let v = noise(direction * (self.radius / wavelength) + DVec3::splat(17.3 * f64::from(octave)), self.seed + octave);
            let v = if self.ridged { 0.5 - v.abs() } else { v };
            sum += v * wavelength * self.roughness;
            wavelength *= 0.5;
        }
        sum
    }

    pub(crate) fn ground(&self, cells: u32) -> Ground<'_> {
        Ground { elevation: self, lattice: Lattice::new(self.radius, 2.0 * self.roughness * self.radius), cells, kept: None }
    }
}

impl Elevation for TestField {
    fn heights(&self, directions: &[DVec3], heights: &mut [f64]) {
        for (h, &d) in heights.iter_mut().zip(directions) {
            *h = self.at(d);
        }
    }
}
