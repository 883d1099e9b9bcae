//! The air by brute force, in f64: twin of the tables of stage `air` (`shaders/transmittance.comp` and on). In: the shading block, a ray.
//! Out: the light that the air scatters towards the eye, and the share that passes.
//!
//! Every ray is marched in hundreds of steps, from each of which the sunlight is marched again; no table is looked up but that of
//! multiple scattering, which is part of the model (Hillaire 2020, section 5.5).

use crate::draw::layout::{Shading, GLARE, MULTIPLE_LAYERS, MULTIPLE_ROUND, MULTIPLE_STEPS, NIGHT, SUN, SUN_RADIUS};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Steps of a view ray, and of the sunlight's ray from each.
const STEPS: (usize, usize) = (240, 80);
/// Elevations of the sun and heights of the table of multiple scattering.
pub const MULTIPLE_TABLE: (u32, u32) = (64, 16);
const MULTIPLE: (usize, usize) = (MULTIPLE_TABLE.0 as usize, MULTIPLE_TABLE.1 as usize);
/// Steps of the sunlight's ray from each step of that table's rays.
const MULTIPLE_SUN_STEPS: usize = 20;

/// A planet's air.
pub struct Air {
    bottom: f64,
    top: f64,
    datum: f64,
    rayleigh: DVec3,
    mie: DVec3,
    mie_extinction: DVec3,
    ozone: DVec3,
    scale_heights: [f64; 2],
    ozone_layer: [f64; 2],
    g: f64,
    albedo: f64,
    multiple: Vec<DVec3>,
}

/// What the air is at a height, per metre.
struct Medium {
    rayleigh: DVec3,
    mie: DVec3,
    extinction: DVec3,
}

fn colour(c: [f32; 3]) -> DVec3 {
    glam::Vec3::from(c).as_dvec3()
}

fn exp(x: DVec3) -> DVec3 {
    DVec3::new(x.x.exp(), x.y.exp(), x.z.exp())
}

/// Shares finest at both ends of a ray.
fn unspread(x: f64) -> f64 {
    if x < 0.5 {
        2.0 * x * x
    } else {
        1.0 - 2.0 * (1.0 - x) * (1.0 - x)
    }
}

impl Air {
    /// The air of a frame; none on planets without.
    pub fn new(s: &Shading) -> Option<Air> {
        let datum = f64::from(s.radius);
        let mut air = Air {
            bottom: datum + f64::from(s.air_bottom),
            top: datum + f64::from(s.air_top),
            datum,
            rayleigh: colour(s.rayleigh),
            mie: colour(s.mie),
            mie_extinction: colour(s.mie_extinction),
            ozone: colour(s.ozone),
            scale_heights: [s.scale_height, s.mie_scale_height].map(f64::from),
            ozone_layer: [s.ozone_height, s.ozone_reach].map(f64::from),
            g: f64::from(s.mie_g),
            albedo: f64::from(s.ground_albedo),
            multiple: Vec::new(),
        };
        if s.scale_height <= 0.0 {
            return None;
        }
        air.multiple = air.multiple_table();
        Some(air)
    }

    fn medium(&self, r: f64) -> Medium {
        let h = r.max(self.bottom) - self.datum;
        let [molecules, haze] = self.scale_heights.map(|scale| (-h / scale).exp());
        let ozone = (1.0 - (h - self.ozone_layer[0]).abs() / self.ozone_layer[1]).max(0.0);
        let rayleigh = self.rayleigh * molecules;
        Medium { rayleigh, mie: self.mie * haze, extinction: rayleigh + self.mie_extinction * haze + self.ozone * ozone }
    }

    /// Share of the sunlight that arrives at a position.
    fn sunlight(&self, position: DVec3, sun: DVec3, steps: usize) -> DVec3 {
        let r = position.length();
        let c = position.dot(sun) / r;
        let visible = self.sun_visibility(r, c);
        if visible <= 0.0 {
            return DVec3::ZERO;
        }
        let along = r * c;
        let whole = ((along * along - (r - self.top) * (r + self.top)).max(0.0).sqrt() - along).max(0.0);
        // Finest at the lowest point of the ray.
        let lowest = (-along).clamp(0.0, whole);
        let mut depth = DVec3::ZERO;
        for (from, to) in [(lowest, whole), (lowest, 0.0)] {
            for k in 0..if from == to { 0 } else { steps } {
                let (a, b) = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
                let t = from + (to - from) * (0.5 * (a + b)).powi(2);
                depth += self.medium((position + sun * t).length()).extinction * ((to - from).abs() * (b * b - a * a));
            }
        }
        exp(-depth) * visible
    }

    /// Share of the sun's disc above the lowest ground's horizon at radius `r`, where its elevation has sine `c`.
    fn sun_visibility(&self, r: f64, c: f64) -> f64 {
        let horizon = -(1.0 - (self.bottom / r).min(1.0).powi(2)).sqrt();
        let x = ((c - horizon) / (2.0 * SUN_RADIUS) + 0.5).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// The sun's glare in a direction of the sky, before the air.
    pub fn glare(&self, eye: DVec3, ray: DVec3, sun: DVec3) -> DVec3 {
        let away = (ray - sun).length_squared() + SUN_RADIUS * SUN_RADIUS;
        let r = eye.length();
        DVec3::splat(SUN * self.sun_visibility(r, eye.dot(sun) / r) * GLARE / away.powf(1.5))
    }

    /// Where a ray enters the air, and where it leaves it or meets the lowest ground; whether it does that. None if it passes.
    fn span(&self, eye: DVec3, ray: DVec3) -> Option<(f64, f64, bool)> {
        let along = eye.dot(ray);
        let aside = eye.cross(ray).length();
        let root = |radius: f64| ((radius - aside) * (radius + aside)).sqrt();
        if aside >= self.top {
            return None;
        }
        let (enter, leave) = (-along - root(self.top), -along + root(self.top));
        let ground = -along - root(self.bottom);
        let meets = aside < self.bottom && along < 0.0 && ground >= -1.0;
        let end = if meets { ground.max(0.0) } else { leave };
        (end > 0.0 || meets).then_some((enter.max(0.0), end, meets))
    }

    /// Light scattered towards the eye over the first `distance` metres of a ray, and the share of light that passes them.
    pub fn before(&self, eye: DVec3, ray: DVec3, distance: f64, sun: DVec3) -> (DVec3, DVec3) {
        let Some((start, end, _)) = self.span(eye, ray) else { return (DVec3::ZERO, DVec3::ONE) };
        let whole = end.min(distance) - start;
        let (mut scattered, mut passed) = (DVec3::ZERO, DVec3::ONE);
        if whole <= 0.0 {
            return (scattered, passed);
        }
        let cosine = ray.dot(sun);
        let (rayleigh_phase, mie_phase) = (3.0 / (16.0 * PI) * (1.0 + cosine * cosine), self.mie_phase(cosine));
        for k in 0..STEPS.0 {
            let share = |k: usize| unspread(k as f64 / STEPS.0 as f64);
            let (from, to) = (start + whole * share(k), start + whole * share(k + 1));
            let position = eye + ray * (0.5 * (from + to));
            let medium = self.medium(position.length());
            let here = exp(-medium.extinction * (to - from));
            let single = self.sunlight(position, sun, STEPS.1) * (medium.rayleigh * rayleigh_phase + medium.mie * mie_phase);
            let scattering = medium.rayleigh + medium.mie;
            let source =
                SUN * (single + scattering * self.multiple_at(position, sun)) + DVec3::from_array(NIGHT) / PI * scattering;
            scattered += passed * (DVec3::ONE - here) * source / medium.extinction.max(DVec3::splat(1e-30));
            passed *= here;
        }
        (scattered, passed)
    }

    fn mie_phase(&self, c: f64) -> f64 {
        let g = self.g;
        3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + c * c) / (1.0 + g * g - 2.0 * g * c).powf(1.5)
    }

    fn multiple_table(&self) -> Vec<DVec3> {
        let (elevations, heights) = MULTIPLE;
        let entry = |k: usize| {
            let (x, y) = (k % elevations, k / elevations);
            let x = 2.0 * x as f64 / (elevations - 1) as f64 - 1.0;
            let y = y as f64 / (heights - 1) as f64;
            self.multiple_entry(x * x.abs(), self.bottom + y * y * (self.top - self.bottom))
        };
        (0..elevations * heights).into_par_iter().map(entry).collect()
    }

    /// All orders but the first from the first two, for a sun of irradiance 1.
    fn multiple_entry(&self, c: f64, r: f64) -> DVec3 {
        let sun = DVec3::new((1.0 - c * c).sqrt(), 0.0, c);
        let (round, layers) = (MULTIPLE_ROUND as usize, MULTIPLE_LAYERS as usize);
        let (mut second, mut share) = (DVec3::ZERO, DVec3::ZERO);
        for k in 0..round * layers {
            let z = 2.0 * ((k / round) as f64 + 0.5) / layers as f64 - 1.0;
            let azimuth = PI * ((k % round) as f64 + 0.5) / round as f64;
            let flat = (1.0 - z * z).sqrt();
            let ray = DVec3::new(flat * azimuth.cos(), flat * azimuth.sin(), z);
            let (one, part) = self.look(DVec3::Z * r, ray, sun);
            second += one;
            share += part;
        }
        let count = (round * layers) as f64;
        second / count / (DVec3::ONE - share / count)
    }

    fn look(&self, eye: DVec3, ray: DVec3, sun: DVec3) -> (DVec3, DVec3) {
        let (mut second, mut share, mut passed) = (DVec3::ZERO, DVec3::ZERO, DVec3::ONE);
        let Some((start, end, meets)) = self.span(eye, ray) else { return (second, share) };
        for k in 0..MULTIPLE_STEPS {
            let at = |k: i32| start + (end - start) * unspread(f64::from(k) / f64::from(MULTIPLE_STEPS));
            let position = eye + ray * (0.5 * (at(k) + at(k + 1)));
            let medium = self.medium(position.length());
            let here = exp(-medium.extinction * (at(k + 1) - at(k)));
            let weight =
                passed * (DVec3::ONE - here) * (medium.rayleigh + medium.mie) / medium.extinction.max(DVec3::splat(1e-30));
            second += weight * self.sunlight(position, sun, MULTIPLE_SUN_STEPS) / (4.0 * PI);
            share += weight;
            passed *= here;
        }
        if meets {
            let ground = (eye + ray * end).normalize();
            let facing = ground.dot(sun).max(0.0);
            second += passed * self.albedo / PI * facing * self.sunlight(ground * self.bottom, sun, MULTIPLE_SUN_STEPS);
        }
        (second, share)
    }

    fn multiple_at(&self, position: DVec3, sun: DVec3) -> DVec3 {
        let (elevations, heights) = MULTIPLE;
        let r = position.length();
        let c = position.dot(sun) / r;
        let x = (0.5 + 0.5 * c.signum() * c.abs().sqrt()) * (elevations - 1) as f64;
        let y = ((r - self.bottom).max(0.0) / (self.top - self.bottom)).sqrt().min(1.0) * (heights - 1) as f64;
        let (i, j) = ((x as usize).min(elevations - 2), (y as usize).min(heights - 2));
        let (u, v) = (x - i as f64, y - j as f64);
        let at = |i: usize, j: usize| self.multiple[j * elevations + i];
        at(i, j).lerp(at(i + 1, j), u).lerp(at(i, j + 1).lerp(at(i + 1, j + 1), u), v)
    }
}
