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

/// Squared distance of a crater that is not there.
const NOWHERE: f64 = 1e9;
/// Cells past which a chunk's lanes each ask their own eight: about where the costs cross.
const FEW_CELLS: i64 = 36;

/// The lower of the two cells on an axis whose craters can reach a place.
#[inline(always)]
fn first_cell(place: f64) -> u32 {
    split(place - 0.5).0
}

/// Cells of a box, x fastest: the order of the eight corners.
fn cells_between(from: [i32; 3], to: [i32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let plane = move |z: i32| (from[1]..=to[1]).map(move |y| (y, z));
    let row = move |(y, z): (i32, i32)| (from[0]..=to[0]).map(move |x| [x as u32, y as u32, z as u32]);
    (from[2]..=to[2]).flat_map(plane).flat_map(row)
}

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
    /// One over the planet radius in cells, squared.
    per_shell: f64,
    /// One over the largest rim radius in cells, squared.
    per_radius2: f64,
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
            per_shell: 1.0 / (radius * radius),
            per_radius2: (recipe.reach / REACH) * (recipe.reach / REACH),
            threshold: (density.clamp(0.0, 1.0) * 65536.0) as u32,
            depth_m: recipe.depth * diameter_m / shallow,
            complex: (ratio - 0.7).clamp(0.0, 1.0),
            streaks: Lattice::new(mix(seed ^ 77), 1.0),
        }
    }

    /// What a cell holds: its crater's centre in lattice coordinates, its hash, and whether there is a crater at all.
    /// Depends on the cell alone, so every point takes or leaves a crater alike.
    #[inline(always)]
    fn cell(&self, cell: [u32; 3]) -> ([f64; 3], u32, bool) {
        let axis = |k: usize| cell[k].wrapping_mul(PRIMES[k]);
        let hash = scramble(axis(0) ^ axis(1) ^ axis(2) ^ self.lattice.seed);
        let jitter = |shift: u32| f64::from(((hash >> shift) & 1023) as i32) * (1.0 / 1024.0);
        let jitters = [jitter(22), jitter(12), jitter(2)];
        let at = [0, 1, 2].map(|k| f64::from(cell[k] as i32) + jitters[k]);
        let centre = [0, 1, 2].map(|k| at[k] - self.lattice.shift[k]);
        let off = centre[0] * centre[0] + centre[1] * centre[1] + centre[2] * centre[2] - self.shell[0];
        let site = scramble(hash ^ 0x5bd1_e995);
        (at, site, (off.abs() < self.shell[1]) & ((site & 0xffff) < self.threshold))
    }

    /// Squared distance over squared rim radius of a crater, and the offset from its centre in cells.
    #[inline(always)]
    fn distance(&self, place: [f64; 3], at: [f64; 3], site: u32) -> (f64, [f64; 3]) {
        let v = [0, 1, 2].map(|k| place[k] - at[k]);
        let up = [0, 1, 2].map(|k| place[k] - self.lattice.shift[k]);
        let along = v[0] * up[0] + v[1] * up[1] + v[2] * up[2];
        let length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let lateral2 = length2 - along * along * self.per_shell;
        // N(>r) ~ r^-2 between half the class's radius and all of it.
        let size = 1.0 + f64::from(((site >> 16) & 255) as i32) * (3.0 / 255.0);
        let t = lateral2.max(0.0) * size * self.per_radius2;
        // Past half a cell nothing acts; far round the sphere the lateral distance would shrink again.
        (if length2 < 0.25 { t } else { NOWHERE }, v)
    }

    /// One of the eight sites about a place (`corner` from 0 to 7): squared distance over squared rim radius (huge
    /// where there is no crater), offset from the centre in cells, site hash.
    #[inline(always)]
    fn site(&self, place: [f64; 3], corner: u32) -> (f64, [f64; 3], u32) {
        let step = [corner & 1, (corner >> 1) & 1, corner >> 2];
        let (at, site, here) = self.cell([0, 1, 2].map(|k| first_cell(place[k]).wrapping_add(step[k])));
        let (t, v) = self.distance(place, at, site);
        (if here { t } else { NOWHERE }, v, site)
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
    fn height(&self, t: f64, site: u32) -> f64 {
        let fresh = 0.25 + f64::from((site >> 24) as i32) * (0.75 / 255.0);
        self.profile(t) * fresh
    }

    /// Sums craters over all lanes. Where the chunk spans few cells their sites are drawn once for all lanes; else each
    /// lane asks its own eight. Both add the same craters in the same order, and zeros: the bits agree.
    #[inline(always)]
    fn add_lanes(&self, p: &Points, mask: &Lane, out: &mut Lane) {
        let n = p.count.min(LANES);
        let (xs, ys, zs, mask, out) = (&p.x[..n], &p.y[..n], &p.z[..n], &mask[..n], &mut out[..n]);
        let mut sum = [0.0; LANES];
        let sum = &mut sum[..n];
        if let Some([from, to]) = self.few_cells(p) {
            for cell in cells_between(from, to) {
                let (at, site, here) = self.cell(cell);
                if !here {
                    continue;
                }
                for i in 0..n {
                    let (t, _) = self.distance(self.lattice.place(xs[i], ys[i], zs[i]), at, site);
                    sum[i] += self.height(t, site);
                }
            }
        } else {
            // One corner at a time, so that the inner loop vectorises.
            for corner in 0..8 {
                for i in 0..n {
                    let (t, _, site) = self.site(self.lattice.place(xs[i], ys[i], zs[i]), corner);
                    sum[i] += self.height(t, site);
                }
            }
        }
        for i in 0..n {
            out[i] += sum[i].clamp(-1.3, 0.7) * self.depth_m * mask[i];
        }
    }

    /// First and last cell that the chunk can be touched from, if they are few.
    fn few_cells(&self, p: &Points) -> Option<[[i32; 3]; 2]> {
        let (mut from, mut to) = ([i32::MAX; 3], [i32::MIN; 3]);
        for i in 0..p.count.min(LANES) {
            let first = self.lattice.place(p.x[i], p.y[i], p.z[i]).map(|c| first_cell(c) as i32);
            for k in 0..3 {
                from[k] = from[k].min(first[k]);
                to[k] = to[k].max(first[k] + 1);
            }
        }
        let spans = [0, 1, 2].map(|k| i64::from(to[k]) - i64::from(from[k]) + 1);
        (spans.iter().all(|&s| s <= FEW_CELLS) && spans.iter().product::<i64>() <= FEW_CELLS).then_some([from, to])
    }

    /// Brightness of rays at a point, 0 to 1.
    fn rays(&self, x: f64, y: f64, z: f64, reach2: f64) -> f64 {
        let mut bright: f64 = 0.0;
        let place = self.lattice.place(x, y, z);
        for corner in 0..8 {
            let (t, v, site) = self.site(place, corner);
            if t >= reach2 {
                continue;
            }
            let fade = 1.0 - (t / reach2).sqrt();
            let halo = 1.0 / (1.0 + t * 0.3);
            let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().max(1e-12);
            // Noise of the offset's direction is constant along rays from the centre.
            let [a, b, c] = v.map(|k| k / length * 4.0 + f64::from((site >> 20) as i32));
            let streak = (noise(&self.streaks, a, b, c) * 3.0).clamp(0.0, 1.0);
            let fresh = f64::from((site >> 24) as i32) * (1.0 / 255.0);
            bright += fade * (halo + streak * (0.35 + 0.65 * fade)) * fresh * 1.3;
        }
        bright.min(1.0)
    }
}

/// The same bits with or without wide instructions: see [`super::noise::noise_at`].
#[multiversion::multiversion(targets("x86_64+avx2"))]
fn add_class(class: &Class, p: &Points, mask: &Lane, out: &mut Lane) {
    class.add_lanes(p, mask, out);
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
            add_class(class, p, &mask, out);
        }
    }

    /// Whether these craters belong to the base elevation.
    pub(crate) fn basins(&self) -> bool {
        self.recipe.basins
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

#[cfg(test)]
mod tests {
    use super::super::noise::unit;
    use super::*;
    use std::array;

    fn class(diameter_m: f64) -> Class {
        let recipe = recipe::Craters {
            largest_m: diameter_m,
            smallest_m: diameter_m,
            density: 1.0,
            growth: 1.0,
            depth: 0.2,
            complex_m: 1e8,
            reach: 2.0,
            rays: 0.0,
            basins: false,
            above_m: [-3e5, -2e5],
            below: 0.0,
        };
        Class::new(3, &recipe, 1000.0, diameter_m, 1.0)
    }

    /// Points on a sphere of 1000 m within `spread` of a pole.
    fn points(spread: f64) -> Points {
        let draw = |i: usize, salt: u64| (unit(mix(i as u64 ^ salt)) - 0.5) * spread;
        let x: Lane = array::from_fn(|i| draw(i, 1 << 40));
        let y: Lane = array::from_fn(|i| draw(i, 2 << 40));
        let z = array::from_fn(|i| (1e6 - x[i] * x[i] - y[i] * y[i]).sqrt());
        Points { x, y, z, count: LANES }
    }

    #[test]
    fn wide_or_shared_sites_differ_from_single_points() {
        for (diameter_m, spread) in [(300.0, 900.0), (20.0, 60.0), (20.0, 900.0), (2.0, 900.0)] {
            let (class, p) = (class(diameter_m), points(spread));
            let (mut wide, mut narrow) = ([0.0; LANES], [0.0; LANES]);
            add_class(&class, &p, &[1.0; LANES], &mut wide);
            class.add_lanes(&p, &[1.0; LANES], &mut narrow);
            assert_eq!(wide, narrow);
            assert!(wide.iter().any(|&h| h != 0.0), "no crater of {diameter_m} m in {spread} m");
            for (i, w) in wide.iter().enumerate() {
                let place = class.lattice.place(p.x[i], p.y[i], p.z[i]);
                let mut sum = 0.0;
                for corner in 0..8 {
                    let (t, _, site) = class.site(place, corner);
                    sum += class.height(t, site);
                }
                assert_eq!(*w, sum.clamp(-1.3, 0.7) * class.depth_m, "{diameter_m} m, point {i}");
            }
        }
    }
}
