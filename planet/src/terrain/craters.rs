//! Impact craters: bowl, rim, ejecta, central peaks, and rays for the albedo. In: a chunk of points in metres and the
//! base elevation. Out: metres added to the height, or ray brightness.
//!
//! Each size class has a turned lattice of cells. A cell holds at most one crater, whose centre must lie within
//! [`SHELL`] of the sphere; its reach is [`REACH`] of a cell, so a point has only the eight nearest cells to ask. Sizes
//! within a class follow a power law (Melosh 1989, chapters V and X, for shapes and distribution).

use super::noise::{mix, noise, scramble, split, Lane, Lattice, Points, LANES, PRIMES};
use super::relief::above;
use crate::recipe;

/// Farthest a crater's centre may lie off the sphere, in cells.
const SHELL: f64 = 0.22;
/// Farthest that a crater acts, in cells. With SHELL and the sphere's curvature within half a cell of the centre.
const REACH: f64 = 0.38;
/// Height of the rim over the depth below it.
const RIM: f64 = 0.25;

/// One layer of craters.
pub(crate) struct Craters {
    classes: Vec<Class>,
    recipe: recipe::Craters,
}

/// Craters of one size class: radii from half of `radius` to `radius`.
struct Class {
    lattice: Lattice,
    /// Planet radius in cells, squared, and the tolerance on that square.
    shell: [f64; 2],
    /// Largest rim radius in cells, squared.
    radius2: f64,
    /// Site hashes below this hold a crater.
    threshold: u32,
    /// Metres from floor to rim.
    depth_m: f64,
    /// How complex the craters are: 0 bowls, 1 flat floors with central peaks.
    complex: f64,
    streaks: Lattice,
}

impl Class {
    fn new(seed: u64, recipe: &recipe::Craters, planet_m: f64, diameter_m: f64, density: f64) -> Self {
        let cell_m = 0.5 * diameter_m * recipe.reach / REACH;
        let radius = planet_m / cell_m;
        let ratio = diameter_m / recipe.complex_m;
        // Depth grows as D up to the transition, then as D^(1/4).
        let shallow = (1.0 + ratio).sqrt() * (1.0 + ratio).sqrt().sqrt();
        Self {
            lattice: Lattice::new(seed, cell_m),
            shell: [radius * radius, 2.0 * radius * SHELL],
            radius2: (REACH / recipe.reach) * (REACH / recipe.reach),
            threshold: (density.clamp(0.0, 1.0) * 65536.0) as u32,
            depth_m: recipe.depth * diameter_m / shallow,
            complex: (ratio - 0.7).clamp(0.0, 1.0),
            streaks: Lattice::new(mix(seed ^ 77), 1.0),
        }
    }

    /// Calls `found(squared distance over squared radius, offset in cells, site hash)` for each of the eight sites.
    #[inline(always)]
    fn sites(&self, x: f64, y: f64, z: f64, mut found: impl FnMut(f64, [f64; 3], u32)) {
        let place = self.lattice.place(x, y, z);
        let shifted = place.map(|c| c - 0.5);
        let cells = shifted.map(|c| split(c));
        let out = [0, 1, 2].map(|k| place[k] - self.lattice.shift[k]);
        let up2 = out[0] * out[0] + out[1] * out[1] + out[2] * out[2];
        for corner in 0..8_u32 {
            let step = [corner & 1, (corner >> 1) & 1, corner >> 2];
            let axis = |k: usize| cells[k].0.wrapping_add(step[k]).wrapping_mul(PRIMES[k]);
            let hash = scramble(axis(0) ^ axis(1) ^ axis(2) ^ self.lattice.seed);
            let jitter = |shift: u32| f64::from(((hash >> shift) & 1023) as i32) * (1.0 / 1024.0);
            let jitters = [jitter(22), jitter(12), jitter(2)];
            // The centre's place depends on the cell alone, so every point takes or leaves it alike.
            let from = |k: usize| f64::from(cells[k].0 as i32) + (f64::from(step[k] as i32) + jitters[k]);
            let centre = [0, 1, 2].map(|k| from(k) - self.lattice.shift[k]);
            let off = centre[0] * centre[0] + centre[1] * centre[1] + centre[2] * centre[2] - self.shell[0];
            let v = [0, 1, 2].map(|k| place[k] - from(k));
            let along = v[0] * out[0] + v[1] * out[1] + v[2] * out[2];
            let lateral2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2] - along * along / up2;
            let site = scramble(hash ^ 0x5bd1_e995);
            // N(>r) ~ r^-2 between half the class's radius and all of it.
            let size = 1.0 + f64::from(((site >> 16) & 255) as i32) * (3.0 / 255.0);
            let t = lateral2.max(0.0) * size / self.radius2;
            let here = (off.abs() < self.shell[1]) & ((site & 0xffff) < self.threshold);
            found(if here { t } else { 1e9 }, v, site);
        }
    }

    /// Height of one crater relative to its depth: `t` is the squared distance over the squared rim radius.
    #[inline(always)]
    fn profile(&self, t: f64) -> f64 {
        let bowl = ((1.0 + RIM) * (1.0 + 0.9 * self.complex) * (t - 1.0)).max(-1.0 - RIM) + RIM;
        let far = (4.0 - t).max(0.0) * (1.0 / 3.0);
        let ejecta = RIM * far * far * far;
        let foot = (1.0 - t * 30.0).max(0.0);
        let peak = self.complex * 0.45 * foot * foot;
        if t < 1.0 {
            bowl + peak
        } else {
            ejecta
        }
    }

    #[inline(always)]
    fn height(&self, x: f64, y: f64, z: f64) -> f64 {
        let mut sum = 0.0;
        self.sites(x, y, z, |t, _, site| {
            let fresh = 0.25 + f64::from((site >> 24) as i32) * (0.75 / 255.0);
            sum += self.profile(t) * fresh;
        });
        sum.clamp(-1.3, 0.7) * self.depth_m
    }

    #[inline(always)]
    fn add_lanes(&self, p: &Points, mask: &Lane, out: &mut Lane) {
        let n = p.count.min(LANES);
        let (xs, ys, zs, mask, out) = (&p.x[..n], &p.y[..n], &p.z[..n], &mask[..n], &mut out[..n]);
        for i in 0..n {
            out[i] += self.height(xs[i], ys[i], zs[i]) * mask[i];
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn add_lanes_avx2(&self, p: &Points, mask: &Lane, out: &mut Lane) {
        self.add_lanes(p, mask, out);
    }

    /// The same bits with or without wide instructions: see [`super::noise::noise_at`].
    fn add(&self, p: &Points, mask: &Lane, out: &mut Lane) {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2, as just detected.
            return unsafe { self.add_lanes_avx2(p, mask, out) };
        }
        self.add_lanes(p, mask, out);
    }

    /// Brightness of rays at a point, 0 to 1.
    fn rays(&self, x: f64, y: f64, z: f64, reach2: f64) -> f64 {
        let mut bright: f64 = 0.0;
        self.sites(x, y, z, |t, v, site| {
            if t >= reach2 {
                return;
            }
            let fade = 1.0 - (t / reach2).sqrt();
            let halo = 1.0 / (1.0 + t * t * 0.2);
            let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().max(1e-12);
            // Noise of the offset's direction is constant along rays from the centre.
            let [a, b, c] = v.map(|k| k / length * 5.0 + f64::from((site >> 20) as i32));
            let streak = (noise(&self.streaks, a, b, c) * 3.0 - 0.1).clamp(0.0, 1.0);
            let fresh = f64::from((site >> 24) as i32) * (1.0 / 255.0);
            bright += fade * fade * (halo + streak * 0.8) * fresh * fresh;
        });
        bright.min(1.0)
    }
}

impl Craters {
    pub(crate) fn new(seed: u64, recipe: &recipe::Craters, planet_m: f64) -> Self {
        let (mut classes, mut diameter, mut density) = (Vec::new(), recipe.largest_m, recipe.density);
        while diameter >= recipe.smallest_m {
            let seed = mix(seed ^ mix(classes.len() as u64));
            classes.push(Class::new(seed, recipe, planet_m, diameter, density));
            diameter *= 0.5;
            density *= recipe.growth;
        }
        Self { classes, recipe: recipe.clone() }
    }

    pub(crate) fn add(&self, p: &Points, base: &Lane, out: &mut Lane) {
        let mut mask = [0.0; LANES];
        if !above(base, p.count, self.recipe.above_m, &mut mask) && self.recipe.below <= 0.0 {
            return;
        }
        for m in &mut mask[..p.count] {
            *m = self.recipe.below + (1.0 - self.recipe.below) * *m;
        }
        for class in &self.classes {
            class.add(p, &mask, out);
        }
    }

    /// Adds the brightness of this layer's rays.
    pub(crate) fn add_rays(&self, p: &Points, bright: &mut Lane) {
        if self.recipe.rays <= 0.0 {
            return;
        }
        let reach2 = self.recipe.reach * self.recipe.reach;
        for class in &self.classes {
            for (i, b) in bright[..p.count].iter_mut().enumerate() {
                *b += self.recipe.rays * class.rays(p.x[i], p.y[i], p.z[i], reach2);
            }
        }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        let depth: f64 = self.classes.iter().map(|c| c.depth_m).sum();
        (-1.3 * depth, 0.7 * depth)
    }
}
