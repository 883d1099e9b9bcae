//! Impact craters, from basins to what a footstep would fill. In: a chunk of points in metres and the base elevation. Out: metres of the
//! layer's own at each point, or ray brightness.
//!
//! Each size class has one or more sets of sites (`sites`) and a shape (`profile`); sizes within a class follow a power law, so that
//! all classes together do. A point's rank among the young and the old decides how much of a crater is left, and whether lava or
//! a larger, younger crater has buried it. A noise of each class's own size bends its rims, roughens what they threw out and
//! rolls the ground between them: craters saturate old ground, and there is no plain (Gault 1970; Melosh 1989, chapter X).

mod profile;
mod rays;
mod sites;

use super::layer::{Evaluate, Past};
use super::noise::{mix, Lattice};
use super::octaves::{any_above_zero, Ramp, Warp};
use super::points::{Lane, Points, LANES};
use crate::recipe::{self, Recipe, RecipeError};
use profile::Shape;
pub(super) use profile::{bowl, RIM};
use sites::{Seen, Sites, Visitor, REACH};

/// Farthest that ejecta have relief, in rim radii; rays go on.
const EJECTA: f64 = 2.0;
/// Over this share of the ranks by age craters come out of the lava that buried them.
const EMERGE: f32 = 0.12;

/// Share of the ranks by age that ground renewed by ice or a volcano has lost.
const RENEWED: f32 = 0.97;

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
    sets: Vec<Sites>,
    shape: Shape,
    /// Noise about as long as the smallest craters are wide, if anything asks for it.
    noise: Option<Lattice>,
    /// One over the largest rim radius in cells, squared.
    per_rim2: f32,
    /// Metres from floor to rim of the largest.
    depth_m: f64,
    /// Height of the rolling ground between the craters, in metres.
    rolling_m: f32,
    /// Squared distance where rays end, in rim radii.
    reach2: f32,
    /// Changes along rays, a cell.
    per_break: f32,
    /// Seed of the noise along rays.
    streaks: u32,
}

/// What one class does to a chunk.
struct Sum {
    height: Lane,
    /// How much of the ground young craters have renewed: older, smaller ones are gone from there.
    renewed: Lane,
}

/// One over the squared size of a site's crater relative to its class's largest: N(>r) ~ r^-2 between half of that and all of it.
#[inline(always)]
fn size(site: u32) -> f32 {
    1.0 + ((site >> 16) & 255) as i32 as f32 * (3.0 / 255.0)
}

/// A site's rank by age, 0 for the oldest and 1 for the youngest.
#[inline(always)]
fn young(site: u32) -> f32 {
    (site >> 24) as i32 as f32 * (1.0 / 255.0)
}

impl Class {
    fn new(seed: u64, turn: usize, recipe: &recipe::Craters, planet_m: f64, diameter_m: f64, density: f64) -> Self {
        let cell_m = 0.5 * diameter_m * recipe.reach / REACH;
        let ratio = diameter_m / recipe.complex_m;
        // Depth grows as D up to the transition, then as D^(1/4).
        let shallow = (1.0 + ratio).sqrt() * (1.0 + ratio).sqrt().sqrt();
        let sets = density.ceil().max(1.0);
        let set = |i: usize| Sites::new(mix(seed ^ mix(i as u64)), turn + i, cell_m, density / sets, planet_m);
        let shaken = recipe.ragged > 0.0 || recipe.rough > 0.0;
        let rim = recipe.reach / REACH;
        Self {
            sets: (0..sets as usize).map(set).collect(),
            shape: Shape::new((ratio - 0.7).clamp(0.0, 1.0) as f32, recipe.ragged as f32, recipe.reach.min(EJECTA)),
            noise: shaken.then(|| Lattice::new(mix(seed ^ 31), turn + 3, diameter_m * 0.42)),
            per_rim2: (rim * rim) as f32,
            depth_m: recipe.depth * diameter_m / shallow,
            rolling_m: (recipe.rough * diameter_m) as f32,
            reach2: (recipe.reach * recipe.reach) as f32,
            per_break: (recipe.reach * 1.2) as f32,
            streaks: mix(seed ^ 77) as u32,
        }
    }

    /// Adds this class to `own`, and takes what its young craters renew from `left`: the share of ranks by age that still show.
    #[inline(always)]
    fn add(&self, p: &Points, mask: &Lane, left: &mut Lane, own: &mut Lane) {
        let mut noise = [0.0; LANES];
        if let Some(lattice) = &self.noise {
            lattice.noise(p, |i, n| noise[i] = n);
        }
        let sum = self.sum(p, &noise, left);
        for i in 0..LANES {
            let rolling = noise[i] * self.rolling_m * (0.25 + 0.75 * mask[i]);
            own[i] += sum.height[i].clamp(-1.3, 0.7) * self.depth_m as f32 + rolling;
            left[i] *= 1.0 - sum.renewed[i].min(1.0);
        }
    }

    #[inline(always)]
    fn sum(&self, p: &Points, noise: &Lane, left: &Lane) -> Sum {
        let mut digger = Digger { class: self, noise, left, sum: Sum { height: [0.0; LANES], renewed: [0.0; LANES] } };
        for sites in &self.sets {
            sites.visit(p, &mut digger);
        }
        digger.sum
    }
}

/// Sums the relief of craters.
struct Digger<'a> {
    class: &'a Class,
    noise: &'a Lane,
    left: &'a Lane,
    sum: Sum,
}

impl Visitor for Digger<'_> {
    const WAY: bool = false;

    #[inline(always)]
    fn visit(&mut self, seen: &Seen) {
        let class = self.class;
        for i in 0..LANES {
            let (size, young) = (size(seen.hashes[i]), young(seen.hashes[i]));
            let relief = class.shape.relief(seen.length2[i] * class.per_rim2 * size, young, self.noise[i]);
            let shown = ((young - 1.0 + self.left[i] * (1.0 + EMERGE)) * (1.0 / EMERGE)).clamp(0.0, 1.0) * seen.here[i];
            self.sum.height[i] += relief.height * shown * (1.0 / size.sqrt());
            self.sum.renewed[i] += relief.renewed * shown;
        }
    }
}

impl Evaluate for Craters {
    type Recipe = recipe::Craters;

    fn new(seed: u64, recipe: &recipe::Craters, planet: &Recipe) -> Result<Self, RecipeError> {
        let (mut classes, mut diameter, mut density) = (Vec::new(), recipe.largest_m, recipe.density);
        while diameter >= recipe.smallest_m {
            let turn = classes.len();
            classes.push(Class::new(mix(seed ^ mix(turn as u64)), turn, recipe, planet.radius, diameter, density));
            diameter *= 0.5;
            density *= recipe.growth;
        }
        let warp = Warp::new(mix(seed ^ 55), recipe.largest_m * 0.6, recipe.warp_m, 2).map(|w| w.along_sphere(planet.radius));
        Ok(Self { classes, warp, above: Ramp::new(recipe.above_m), recipe: recipe.clone() })
    }

    fn is_base(&self) -> bool {
        self.recipe.basins
    }

    /// Where the ground is `renewed` only the youngest show.
    #[inline(always)]
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane> {
        let below = self.recipe.below as f32;
        let mut mask = self.above.lanes(&past.base);
        for i in 0..LANES {
            mask[i] = (below + (1.0 - below) * mask[i]) * (1.0 - RENEWED * past.renewed[i]);
        }
        if !any_above_zero(&mask) {
            return None;
        }
        let (mut room, mut own, mut left) = (None, [0.0; LANES], mask);
        let p = Warp::moved(self.warp.as_ref(), p, &mut room);
        for class in &self.classes {
            class.add(p, &mask, &mut left, &mut own);
        }
        Some(own)
    }

    fn range(&self, _: f64) -> (f64, f64) {
        let depth: f64 = self.classes.iter().map(|c| c.depth_m).sum();
        let rolling: f64 = self.classes.iter().map(|c| f64::from(c.rolling_m)).sum();
        (-1.3 * depth - rolling, 0.7 * depth + rolling)
    }
}

impl Craters {
    /// Adds the brightness of this layer's rays.
    #[inline(always)]
    pub(crate) fn add_rays(&self, p: &Points, bright: &mut Lane) {
        if self.recipe.rays <= 0.0 {
            return;
        }
        let mut room = None;
        let p = Warp::moved(self.warp.as_ref(), p, &mut room);
        for class in &self.classes {
            class.add_rays(p, self.recipe.rays as f32, bright);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise::unit;
    use super::super::points::WideLane;
    use super::*;
    use std::array;

    fn class(seed: u64, diameter_m: f64) -> Class {
        let recipe = recipe::Craters {
            largest_m: diameter_m,
            smallest_m: diameter_m,
            density: 1.7,
            growth: 1.0,
            depth: 0.2,
            complex_m: 1e8,
            reach: 2.0,
            rays: 0.0,
            ragged: 0.5,
            rough: 0.01,
            warp_m: 0.0,
            basins: false,
            above_m: [-3e5, -2e5],
            below: 0.0,
        };
        Class::new(seed, 1, &recipe, 1000.0, diameter_m, 1.7)
    }

    /// Points on a sphere of 1000 m within `spread` of a pole.
    fn points(spread: f64) -> [WideLane; 3] {
        let draw = |i: usize, salt: u64| (unit(mix(i as u64 ^ salt)) - 0.5) * spread;
        let x: WideLane = array::from_fn(|i| draw(i, 1 << 40));
        let y: WideLane = array::from_fn(|i| draw(i, 2 << 40));
        [x, y, array::from_fn(|i| (1e6 - x[i] * x[i] - y[i] * y[i]).sqrt())]
    }

    /// One point in every lane but the last, which is far away, so that lanes share no lookup of sites.
    fn alone(positions: &[WideLane; 3], i: usize) -> Points {
        let mut far = [0, 1, 2].map(|k| [positions[k][i]; LANES]);
        for (k, axis) in far.iter_mut().enumerate() {
            axis[LANES - 1] = -positions[k][i];
        }
        Points::at(far)
    }

    fn metres(class: &Class, p: &Points) -> Lane {
        let (mut own, mut left) = ([0.0; LANES], [1.0; LANES]);
        class.add(p, &[1.0; LANES], &mut left, &mut own);
        own
    }

    #[test]
    fn shared_sites_give_the_bits_of_single_points() {
        for (diameter_m, spread) in [(300.0, 900.0), (20.0, 60.0), (20.0, 900.0), (2.0, 900.0)] {
            let mut high = 0;
            for class in (0..6).map(|seed| class(seed, diameter_m)) {
                let positions = points(spread);
                let together = metres(&class, &Points::at(positions));
                for i in 0..LANES {
                    let own = metres(&class, &alone(&positions, i))[0];
                    assert_eq!(own.to_bits(), together[i].to_bits(), "{diameter_m} m in {spread} m, point {i}");
                }
                high += together.iter().filter(|h| h.abs() > 0.02 * diameter_m as f32).count();
            }
            assert!(high > 30, "{diameter_m} m in {spread} m: only {high} points in craters");
        }
    }

    #[test]
    fn craters_cover_every_octant_alike() {
        // Every face, edge and corner of the cube around the sphere has craters.
        let class = class(3, 20.0);
        let mut counts = [0; 8];
        let position = |n: u64| array::from_fn(|k| unit(mix(n * 3 + k as u64)) * 2.0 - 1.0);
        for position in (0..40_000).map(position) {
            let length = position.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
            let octant = (0..3).map(|k| usize::from(position[k] > 0.0) << k).sum::<usize>();
            let p = Points::at(position.map(|x| [x / length * 1000.0; LANES]));
            let sum = class.sum(&p, &[0.0; LANES], &[1.0; LANES]);
            counts[octant] += usize::from(sum.height[0] < -0.05);
        }
        assert!(counts.iter().all(|&n| (300..600).contains(&n)), "{counts:?}");
    }

    #[test]
    fn lava_buries_old_craters() {
        let p = Points::at(points(900.0));
        let deep = |left: f32| {
            let low = |class: Class| class.sum(&p, &[0.0; LANES], &[left; LANES]).height.iter().filter(|&&h| h < -0.02).count();
            (0..12).map(|seed| low(class(seed, 200.0))).sum::<usize>()
        };
        assert!(deep(1.0) > 2 * deep(0.25) && deep(0.25) > 0 && deep(0.0) == 0, "{} {} {}", deep(1.0), deep(0.25), deep(0.0));
    }

    #[test]
    fn rays_of_neighbours_have_the_bits_of_single_points() {
        let positions = points(200.0);
        let mut bright = 0;
        for class in (0..6).map(|seed| class(seed, 300.0)) {
            let rays = |p: &Points| {
                let mut bright = [0.0; LANES];
                class.add_rays(p, 1.0, &mut bright);
                bright
            };
            let together = rays(&Points::at(positions));
            bright += together.iter().filter(|&&b| b > 0.0).count();
            for i in 0..LANES {
                assert_eq!(rays(&alone(&positions, i))[0].to_bits(), together[i].to_bits(), "point {i}");
            }
        }
        assert!(bright > 0, "no rays");
    }
}
