//! Impact craters: bowl, rim, ejecta, central peaks, and rays for the albedo. In: a chunk of points in metres and the
//! base elevation. Out: metres of the layer's own at each point, or ray brightness.
//!
//! Each size class has a turned lattice of cells. A cell holds at most one crater, whose centre must lie within
//! [`SHELL`] of the sphere; its reach is [`REACH`] of a cell, so a point has only the eight nearest cells to ask. Sizes
//! within a class follow a power law (Melosh 1989, chapters V and X, for shapes and distribution).

use super::noise::{mix, nearest, noise_at, Lattice, PRIMES};
use super::octaves::{any_above_zero, Ramp, Warp};
use super::points::{axes, Lane, Points, Turned, WideLane, LANES};
use crate::recipe;

/// Farthest a crater's centre may lie off the sphere, in cells.
const SHELL: f32 = 0.22;
/// Over this part of a cell within [`SHELL`] craters fade out, so that rounding never decides whether there is one.
const FADE: f32 = 0.04;
/// Farthest that a crater acts, in cells. With SHELL and the sphere's curvature within half a cell of the centre.
const REACH: f64 = 0.38;
/// Height of the rim over the depth below it.
pub(super) const RIM: f32 = 0.25;

/// Squared distance of a crater that is not there.
const NOWHERE: f32 = 1e9;
/// Cells past which a chunk's lanes each ask their own eight: about where the costs cross.
const FEW_CELLS: f64 = 36.0;

/// Cells of a box, x fastest: the order of the eight corners.
fn cells_between(from: [u32; 3], counts: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let plane = move |z: u32| (0..counts[1]).map(move |y| (y, z));
    let row = move |(y, z): (u32, u32)| (0..counts[0]).map(move |x| [x, y, z]);
    let at = move |step: [u32; 3]| axes(|k| from[k].wrapping_add(step[k]));
    (0..counts[2]).flat_map(plane).flat_map(row).map(at)
}

/// One layer of craters.
pub(crate) struct Craters {
    classes: Vec<Class>,
    /// Takes the circle out of large craters.
    warp: Option<Warp>,
    above: Ramp,
    recipe: recipe::Craters,
}

/// Craters of one size class: radii from half of the largest to the largest.
struct Class {
    lattice: Lattice,
    /// Planet radius in cells.
    radius: f64,
    /// One over the planet radius in metres.
    per_metre: f64,
    /// One over the largest rim radius in cells, squared.
    per_rim2: f32,
    /// Site hashes below this hold a crater.
    threshold: u32,
    /// Metres from floor to rim.
    depth_m: f64,
    /// How complex the craters are: 0 bowls, 1 flat floors with central peaks.
    complex: f32,
    /// Height of the shield that the crater tops, over its depth; 0 for none.
    shield: f32,
    /// One over the shield's radius, in rim radii.
    per_foot: f32,
    /// Seed of the noise along rays.
    streaks: u32,
}

/// What a cell holds: its crater's centre from the cell's own, in cells, the site's hash, and whether it holds one at all.
#[derive(Clone, Copy)]
struct Site {
    offset: [f32; 3],
    hash: u32,
    here: bool,
}

/// Craters as seen from each lane, in cells: what f64 is needed for.
struct Sight {
    /// Squared distance.
    length2: Lane,
    /// Squared distance along the ground.
    lateral2: Lane,
    /// How far the centre lies off the sphere.
    off: Lane,
}

impl Class {
    fn new(seed: u64, turn: usize, recipe: &recipe::Craters, planet_m: f64, diameter_m: f64, density: f64) -> Self {
        let cell_m = 0.5 * diameter_m * recipe.reach / REACH;
        let ratio = diameter_m / recipe.complex_m;
        // Depth grows as D up to the transition, then as D^(1/4).
        let shallow = (1.0 + ratio).sqrt() * (1.0 + ratio).sqrt().sqrt();
        let depth_m = recipe.depth * diameter_m / shallow;
        let shield_m = recipe.shield_m * diameter_m / recipe.largest_m;
        Self {
            lattice: Lattice::new(seed, turn, cell_m),
            radius: planet_m / cell_m,
            per_metre: 1.0 / planet_m,
            per_rim2: ((recipe.reach / REACH) * (recipe.reach / REACH)) as f32,
            threshold: (density.clamp(0.0, 1.0) * 65536.0) as u32,
            depth_m,
            shield: if shield_m > 0.0 { (shield_m / depth_m.max(1.0)) as f32 } else { 0.0 },
            per_foot: (1.0 / recipe.reach) as f32,
            complex: (ratio - 0.7).clamp(0.0, 1.0) as f32,
            streaks: mix(seed ^ 77) as u32,
        }
    }

    #[inline(always)]
    fn site(&self, cell: [u32; 3]) -> Site {
        let axis = |k: usize| cell[k].wrapping_mul(PRIMES[k]);
        let hash = scramble(axis(0) ^ axis(1) ^ axis(2) ^ self.lattice.seed);
        let offset = |shift: u32| ((hash >> shift) & 1023) as i32 as f32 * (1.0 / 1024.0) - 1.0;
        let site = scramble(hash ^ 0x5bd1_e995);
        Site { offset: [offset(22), offset(12), offset(2)], hash: site, here: (site & 0xffff) < self.threshold }
    }

    /// Sees lane `i`'s crater from `v` off its centre, in cells; `point` is where the viewer stands, in turned metres.
    #[inline(always)]
    fn see(&self, sight: &mut Sight, i: usize, v: [f64; 3], point: [f64; 3]) {
        let along = (v[0] * point[0] + v[1] * point[1] + v[2] * point[2]) * self.per_metre;
        let length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        sight.length2[i] = length2 as f32;
        sight.lateral2[i] = (length2 - along * along) as f32;
        sight.off[i] = (length2 * (0.5 / self.radius) - along) as f32;
    }

    /// Squared distance along the ground over the squared rim radius, and how much of the crater there is, 0 to 1.
    #[inline(always)]
    fn reach(&self, sight: &Sight, i: usize, site: u32) -> (f32, f32) {
        // N(>r) ~ r^-2 between half the class's radius and all of it.
        let size = 1.0 + ((site >> 16) & 255) as i32 as f32 * (3.0 / 255.0);
        let t = sight.lateral2[i].max(0.0) * size * self.per_rim2;
        let presence = ((SHELL - sight.off[i].abs()) * (1.0 / FADE)).clamp(0.0, 1.0);
        // Past half a cell nothing acts; far round the sphere the lateral distance would shrink again.
        (if sight.length2[i] < 0.25 { t } else { NOWHERE }, presence)
    }

    /// Height of one crater relative to its depth: `t` is the squared distance over the squared rim radius.
    #[inline(always)]
    fn profile(&self, t: f32) -> f32 {
        let bowl = bowl(t, self.complex);
        let far = (4.0 - t).max(0.0) * (1.0 / 3.0);
        let ejecta = RIM * far * far * far;
        let foot = (1.0 - t * 30.0).max(0.0);
        let peak = self.complex * 0.45 * foot * foot;
        let crater = if t < 1.0 { bowl + peak } else { ejecta };
        if self.shield > 0.0 {
            crater + self.shield * self.flank(t)
        } else {
            crater
        }
    }

    /// Height of a shield volcano, 1 at the top: slopes that steepen upwards a little, and a scarp at their foot.
    #[inline(always)]
    fn flank(&self, t: f32) -> f32 {
        const SCARP: f32 = 0.16;
        let top = 1.0 - self.per_foot;
        let up = (1.0 - t.max(1.0).sqrt() * self.per_foot).max(0.0) * (1.0 / top);
        let scarp = (up * 14.0).min(1.0);
        SCARP * scarp * scarp * (3.0 - 2.0 * scarp) + (1.0 - SCARP) * up * (0.8 + 0.2 * up)
    }

    /// Sums craters over all lanes. Where the chunk spans few cells their sites are drawn once for all lanes; else each
    /// lane asks its own eight. Both add the same craters in the same order, and zeros: the bits agree.
    #[inline(always)]
    fn add(&self, p: &Points, mask: &Lane, out: &mut Lane) {
        let turned = &p.turned[self.lattice.turn];
        let mut sum = [0.0; LANES];
        if let Some((from, counts)) = self.few_cells(p) {
            self.add_shared(turned, from, counts, &mut sum);
        } else {
            self.add_each(turned, &mut sum);
        }
        for i in 0..LANES {
            out[i] += sum[i].clamp(-1.3, 0.7 + self.shield) * (self.depth_m as f32 * mask[i]);
        }
    }

    #[inline(always)]
    fn add_shared(&self, turned: &Turned, from: [f64; 3], counts: [u32; 3], sum: &mut Lane) {
        for cell in cells_between(axes(|k| nearest(from[k]).0), counts) {
            let Some((centre, site)) = self.crater_near(turned, cell) else { continue };
            let sight = self.sight(turned, centre);
            for i in 0..LANES {
                let (t, presence) = self.reach(&sight, i, site);
                sum[i] += self.profile(t) * freshness(site) * presence;
            }
        }
    }

    /// One crater as seen from every lane.
    #[inline(always)]
    fn sight(&self, turned: &Turned, centre: [f64; 3]) -> Sight {
        let mut sight = Sight::default();
        for i in 0..LANES {
            let point = axes(|k| turned.axes[k][i]);
            self.see(&mut sight, i, axes(|k| self.lattice.place(k, point[k]) - centre[k]), point);
        }
        sight
    }

    /// The centre (in lattice coordinates) and hash of a cell's crater, unless no lane can be in its reach.
    #[inline(always)]
    fn crater_near(&self, turned: &Turned, cell: [u32; 3]) -> Option<([f64; 3], u32)> {
        let site = self.site(cell);
        let centre = axes(|k| f64::from(cell[k] as i32) + f64::from(site.offset[k]));
        let c = axes(|k| centre[k] - self.lattice.shift[k]);
        let off = (c[0] * c[0] + c[1] * c[1] + c[2] * c[2] - self.radius * self.radius) * (0.5 / self.radius);
        // From the nearest point of the box about all lanes.
        let gap = |k: usize| {
            let (low, high) = (self.lattice.place(k, turned.low[k]), self.lattice.place(k, turned.high[k]));
            (low - centre[k]).max(centre[k] - high).max(0.0)
        };
        let [x, y, z] = axes(gap);
        let near = x * x + y * y + z * z <= 0.25 && off.abs() < f64::from(SHELL) + 1e-3;
        (site.here && near).then_some((centre, site.hash))
    }

    /// One corner at a time, and first what is integer, then what is f64, then what is f32, so that each vectorises.
    #[inline(always)]
    fn add_each(&self, turned: &Turned, sum: &mut Lane) {
        let (mut cells, mut fractions) = ([[0; LANES]; 3], [[0.0; LANES]; 3]);
        for k in 0..3 {
            for i in 0..LANES {
                let place = self.lattice.place(k, turned.axes[k][i]);
                let (cell, rounded) = nearest(place);
                (cells[k][i], fractions[k][i]) = (cell, place - rounded);
            }
        }
        for corner in 0..8 {
            self.add_corner(turned, corner, &cells, &fractions, sum);
        }
    }

    #[inline(always)]
    fn add_corner(&self, turned: &Turned, corner: u32, cells: &[[u32; LANES]; 3], fractions: &[WideLane; 3], sum: &mut Lane) {
        let step = [corner & 1, (corner >> 1) & 1, corner >> 2];
        let (mut offsets, mut hashes, mut strength) = ([[0.0; LANES]; 3], [0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let site = self.site(axes(|k| cells[k][i].wrapping_add(step[k])));
            for k in 0..3 {
                offsets[k][i] = site.offset[k] + step[k] as f32;
            }
            hashes[i] = site.hash;
            strength[i] = if site.here { freshness(site.hash) } else { 0.0 };
        }
        let mut sight = Sight::default();
        for i in 0..LANES {
            let v = axes(|k| fractions[k][i] - f64::from(offsets[k][i]));
            self.see(&mut sight, i, v, axes(|k| turned.axes[k][i]));
        }
        for i in 0..LANES {
            let (t, presence) = self.reach(&sight, i, hashes[i]);
            sum[i] += self.profile(t) * strength[i] * presence;
        }
    }

    /// First cell that the chunk can be touched from and how many there are on each axis, if they are few.
    #[inline(always)]
    fn few_cells(&self, p: &Points) -> Option<([f64; 3], [u32; 3])> {
        let [from, to] = self.lattice.span(p);
        let counts = axes(|k| to[k] - from[k] + 2.0);
        (counts[0] * counts[1] * counts[2] <= FEW_CELLS).then(|| (from, axes(|k| counts[k] as u32)))
    }

    /// Brightness of the rays of one crater, seen from `v` off its centre.
    #[inline(always)]
    fn rays(&self, sight: &Sight, i: usize, v: [f32; 3], site: u32, reach2: f32) -> f32 {
        let (t, presence) = self.reach(sight, i, site);
        let t = t.min(reach2);
        let fade = 1.0 - (t / reach2).sqrt();
        let halo = 1.0 / (1.0 + t * 0.3);
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt().max(1e-6);
        // Noise of the offset's direction is constant along rays from the centre.
        let streak = (noise_at(self.streaks ^ site, axes(|k| v[k] / length * 6.0)) * 3.2 - 0.2).clamp(0.0, 1.0);
        let fresh = (site >> 24) as i32 as f32 * (1.0 / 255.0);
        // Rays fade long before the relief does: few craters have bright ones.
        let fresh = fresh * fresh;
        fade * (halo + streak * (0.35 + 0.65 * fade)) * fresh * 1.3 * presence
    }

    /// Adds the brightness of this class's rays, up to 1 a class, times `strength`.
    #[inline(always)]
    fn add_rays(&self, p: &Points, reach2: f32, strength: f32, bright: &mut Lane) {
        let turned = &p.turned[self.lattice.turn];
        let mut sum = [0.0; LANES];
        if let Some((from, counts)) = self.few_cells(p) {
            for cell in cells_between(axes(|k| nearest(from[k]).0), counts) {
                let Some((centre, site)) = self.crater_near(turned, cell) else { continue };
                let sight = self.sight(turned, centre);
                let mut v = [[0.0; LANES]; 3];
                for k in 0..3 {
                    for i in 0..LANES {
                        v[k][i] = (self.lattice.place(k, turned.axes[k][i]) - centre[k]) as f32;
                    }
                }
                for i in 0..LANES {
                    sum[i] += self.rays(&sight, i, axes(|k| v[k][i]), site, reach2);
                }
            }
        } else {
            self.add_rays_each(turned, reach2, &mut sum);
        }
        for i in 0..LANES {
            bright[i] += strength * sum[i].min(1.0);
        }
    }

    /// Lane by lane: only views of a whole planet come here.
    fn add_rays_each(&self, turned: &Turned, reach2: f32, sum: &mut Lane) {
        let mut sight = Sight::default();
        for (i, sum) in sum.iter_mut().enumerate() {
            let point = axes(|k| turned.axes[k][i]);
            let place = axes(|k| self.lattice.place(k, point[k]));
            for cell in cells_between(axes(|k| nearest(place[k]).0), [2; 3]) {
                let site = self.site(cell);
                if site.here {
                    let v = axes(|k| place[k] - (f64::from(cell[k] as i32) + f64::from(site.offset[k])));
                    self.see(&mut sight, i, v, point);
                    *sum += self.rays(&sight, i, axes(|k| v[k] as f32), site.hash, reach2);
                }
            }
        }
    }
}

impl Default for Sight {
    #[inline(always)]
    fn default() -> Self {
        Self { length2: [0.0; LANES], lateral2: [0.0; LANES], off: [0.0; LANES] }
    }
}

/// Height within the rim relative to the depth: `t` is the squared distance over the squared rim radius, `complex` from 0 (a bowl) to 1
/// (a flat floor). [`RIM`] at the rim.
#[inline(always)]
pub(super) fn bowl(t: f32, complex: f32) -> f32 {
    ((1.0 + RIM) * (1.0 + 0.9 * complex) * (t - 1.0)).max(-1.0 - RIM) + RIM
}

/// Scrambles the sum of a cell's axis hashes.
#[inline(always)]
fn scramble(h: u32) -> u32 {
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    let h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

/// How much of its first relief a crater still has.
#[inline(always)]
fn freshness(site: u32) -> f32 {
    let young = (site >> 24) as i32 as f32 * (1.0 / 255.0);
    0.15 + young * (0.25 + 0.6 * young)
}

impl Craters {
    pub(crate) fn new(seed: u64, recipe: &recipe::Craters, planet_m: f64) -> Self {
        let (mut classes, mut diameter, mut density) = (Vec::new(), recipe.largest_m, recipe.density);
        while diameter >= recipe.smallest_m {
            let turn = classes.len();
            classes.push(Class::new(mix(seed ^ mix(turn as u64)), turn, recipe, planet_m, diameter, density));
            diameter *= 0.5;
            density *= recipe.growth;
        }
        let warp = Warp::new(mix(seed ^ 55), recipe.largest_m * 0.6, recipe.warp_m, 2).map(|w| w.along_sphere(planet_m));
        Self { classes, warp, above: Ramp::new(recipe.above_m), recipe: recipe.clone() }
    }

    #[inline(always)]
    pub(crate) fn metres(&self, p: &Points, base: &Lane) -> Option<Lane> {
        let below = self.recipe.below as f32;
        let mut mask = self.above.lanes(base);
        for m in &mut mask {
            *m = below + (1.0 - below) * *m;
        }
        if !any_above_zero(&mask) {
            return None;
        }
        let (mut room, mut own) = (None, [0.0; LANES]);
        let p = Warp::moved(self.warp.as_ref(), p, &mut room);
        for class in &self.classes {
            class.add(p, &mask, &mut own);
        }
        Some(own)
    }

    /// Whether these craters belong to the base elevation.
    pub(crate) fn basins(&self) -> bool {
        self.recipe.basins
    }

    /// Adds the brightness of this layer's rays.
    #[inline(always)]
    pub(crate) fn add_rays(&self, p: &Points, bright: &mut Lane) {
        if self.recipe.rays <= 0.0 {
            return;
        }
        let reach2 = (self.recipe.reach * self.recipe.reach) as f32;
        let mut room = None;
        let p = Warp::moved(self.warp.as_ref(), p, &mut room);
        for class in &self.classes {
            class.add_rays(p, reach2, self.recipe.rays as f32, bright);
        }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        let depth: f64 = self.classes.iter().map(|c| c.depth_m).sum();
        let shields: f64 = self.classes.iter().map(|c| f64::from(c.shield) * c.depth_m).sum();
        (-1.3 * depth, 0.7 * depth + shields)
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise::unit;
    use super::*;
    use std::array;

    fn class(seed: u64, diameter_m: f64) -> Class {
        let recipe = recipe::Craters {
            largest_m: diameter_m,
            smallest_m: diameter_m,
            density: 1.0,
            growth: 1.0,
            depth: 0.2,
            complex_m: 1e8,
            reach: 2.0,
            rays: 0.0,
            shield_m: 0.0,
            warp_m: 0.0,
            basins: false,
            above_m: [-3e5, -2e5],
            below: 0.0,
        };
        Class::new(seed, 1, &recipe, 1000.0, diameter_m, 1.0)
    }

    /// Points on a sphere of 1000 m within `spread` of a pole.
    fn points(spread: f64) -> [WideLane; 3] {
        let draw = |i: usize, salt: u64| (unit(mix(i as u64 ^ salt)) - 0.5) * spread;
        let x: WideLane = array::from_fn(|i| draw(i, 1 << 40));
        let y: WideLane = array::from_fn(|i| draw(i, 2 << 40));
        [x, y, array::from_fn(|i| (1e6 - x[i] * x[i] - y[i] * y[i]).sqrt())]
    }

    #[test]
    fn shared_sites_differ_from_each_lane_its_own() {
        for (diameter_m, spread, few) in [(300.0, 900.0, true), (20.0, 60.0, true), (20.0, 900.0, false), (2.0, 900.0, false)] {
            let mut craters = 0;
            for seed in 0..6 {
                let (class, p) = (class(seed, diameter_m), Points::at(points(spread)));
                assert_eq!(class.few_cells(&p).is_some(), few, "{diameter_m} m in {spread} m no longer tests what it should");
                let (mut chosen, mut each) = ([0.0; LANES], [0.0; LANES]);
                class.add(&p, &[1.0; LANES], &mut chosen);
                class.add_each(&p.turned[class.lattice.turn], &mut each);
                let each = each.map(|sum| sum.clamp(-1.3, 0.7) * class.depth_m as f32);
                assert_eq!(chosen, each, "{diameter_m} m in {spread} m");
                craters += usize::from(chosen.iter().any(|&h| h != 0.0));
            }
            assert!(craters > 0, "no crater of {diameter_m} m in {spread} m");
        }
    }

    #[test]
    fn rays_of_neighbours_differ_from_rays_of_points() {
        let places = points(200.0);
        let mut bright = 0;
        for class in (0..6).map(|seed| class(seed, 300.0)) {
            let rays = |p: &Points| {
                let mut bright = [0.0; LANES];
                class.add_rays(p, 4.0, 1.0, &mut bright);
                bright
            };
            let together = rays(&Points::at(places));
            bright += together.iter().filter(|&&b| b > 0.0).count();
            for i in 0..LANES {
                let mut far = places.map(|axis| [axis[i]; LANES]);
                far[2][LANES - 1] = -1e5;
                assert!(class.few_cells(&Points::at(far)).is_none());
                assert_eq!(rays(&Points::at(far))[0].to_bits(), together[i].to_bits(), "point {i}");
            }
        }
        assert!(bright > 0, "no rays");
    }
}
