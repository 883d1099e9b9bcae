//! Random views for verification: from orbit to just above the ground, and over the sites where things go wrong.

use crate::draw::tree::PatchTree;
use crate::draw::view::Camera;
use crate::globe::patch::PatchId;
use crate::globe::random::Random;
use crate::globe::sphere::{direction, ONE};
use glam::{DVec3, IVec3};

/// An endless stream of cameras over a planet.
pub struct RandomViews<'a> {
    random: Random,
    count: usize,
    patches: Vec<PatchId>,
    radius: f64,
    height: &'a dyn Fn(DVec3) -> f64,
}

impl<'a> RandomViews<'a> {
    /// Views over a planet. `height` gives metres above the datum.
    pub fn new(tree: &PatchTree, seed: u64, height: &'a dyn Fn(DVec3) -> f64) -> Self {
        let mut patches: Vec<PatchId> = tree.ids().collect();
        patches.sort_unstable_by_key(|id| (std::cmp::Reverse(id.level), *id));
        RandomViews { random: Random::new(seed), count: 0, patches, radius: tree.lattice.radius * tree.lattice.unit, height }
    }

    /// Sites in turn: anywhere, on a face edge, at a face corner, on the rim of one of the finest patches.
    fn site(&mut self) -> DVec3 {
        let random = &mut self.random;
        let sign = |bits: u64| if bits & 1 == 0 { ONE } else { -ONE };
        match self.count % 4 {
            1 => {
                let mut edge = IVec3::new(sign(random.bits()), sign(random.bits()), sign(random.bits()));
                edge[(random.bits() % 3) as usize] = random.range(f64::from(-ONE), f64::from(ONE)) as i32;
                direction(edge)
            }
            2 => direction(IVec3::new(sign(random.bits()), sign(random.bits()), sign(random.bits()))),
            3 => {
                let finest = self.patches.len().div_ceil(3).max(1);
                let id = self.patches[random.bits() as usize % finest.min(self.patches.len())];
                let along = (random.unit() * 16.0) as i32;
                direction(if random.bits() & 1 == 0 { id.point(along, 0, 16) } else { id.point(16, along, 16) })
            }
            _ => random.direction(),
        }
    }
}

impl Iterator for RandomViews<'_> {
    type Item = Camera;

    fn next(&mut self) -> Option<Camera> {
        let site = self.site();
        self.count += 1;
        let random = &mut self.random;
        // Altitudes spread evenly over the scales from 2 m to 3 radii.
        let altitude = 2.0 * (3.0 * self.radius / 2.0).powf(random.unit());
        let position = site * (self.radius + (self.height)(site) + altitude);
        let steepest = if altitude > 0.2 * self.radius { -60.0 } else { 5.0 };
        let (heading, pitch) = (random.range(0.0, 360.0), random.range(-90.0, steepest));
        let fov = random.range(35.0, 75.0).to_radians();
        Some(Camera::looking(position, heading, pitch, fov, [1280, 720]))
    }
}

/// Highest camera of [`ground_views`] in metres.
const NEAR_GROUND: f64 = 3000.0;

/// Sites tried for one on dry land.
const TRIES: usize = 1000;

/// Cameras from 2 m to 3 km above `sites` random sites on dry land (as far as a thousand tries find some), `count` altogether,
/// those of a site one after the other and the lowest first. `height` gives metres above the datum, and `sea` is the sea's.
pub fn ground_views(seed: u64, sites: usize, count: usize, radius: f64, sea: f64, height: &dyn Fn(DVec3) -> f64) -> Vec<Camera> {
    let mut random = Random::new(seed);
    let mut cameras = Vec::with_capacity(count);
    for nth in 0..sites {
        let mut site = random.direction();
        for _ in 0..TRIES {
            if height(site) > sea {
                break;
            }
            site = random.direction();
        }
        for k in 0..(nth + 1) * count / sites - nth * count / sites {
            // Up to 10 m aside: no two views of a site look at the same triangles.
            let beside = (site + random.direction() * (10.0 / radius)).normalize();
            let altitude = if k == 0 { 2.0 } else { 2.0 * (NEAR_GROUND / 2.0).powf(random.unit()) };
            let position = beside * (radius + height(beside) + altitude);
            let (heading, pitch) = (random.range(0.0, 360.0), random.range(-70.0, 5.0));
            let fov = random.range(35.0, 75.0).to_radians();
            cameras.push(Camera::looking(position, heading, pitch, fov, [1280, 720]));
        }
    }
    cameras
}
