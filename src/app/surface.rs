//! What the viewer moves over: the ground that is drawn, or the sea above it.

use super::pose::meet_sphere;
use crate::scene::{DrawnGround, Scene};
use glam::DVec3;
use terrane_planet::recipe::Recipe;
use terrane_planet::terrain::Terrain;

/// A surface around the planet's centre, in planet-fixed metres.
pub(super) trait Surface {
    /// Distance from the planet's centre in a unit direction.
    fn radius(&self, direction: DVec3) -> f64;

    /// The point at which a ray from above first meets it; `direction` has length 1.
    fn meet(&self, origin: DVec3, direction: DVec3) -> Option<DVec3>;
}

/// The drawn ground of a planet, and its sea.
pub(super) struct DrawnSurface<'a> {
    ground: &'a DrawnGround,
    recipe: &'a Recipe,
    terrain: &'a Terrain,
    /// Whether the sea is drawn.
    wet: bool,
}

impl<'a> DrawnSurface<'a> {
    pub(super) fn new(ground: &'a DrawnGround, recipe: &'a Recipe, terrain: &'a Terrain) -> DrawnSurface<'a> {
        DrawnSurface { ground, recipe, terrain, wet: true }
    }

    /// With its sea, or without.
    pub(super) fn of_scene(scene: &'a Scene, wet: bool) -> DrawnSurface<'a> {
        DrawnSurface { wet, ..DrawnSurface::new(scene.ground(), &scene.planet().recipe, &scene.planet().terrain) }
    }
}

impl Surface for DrawnSurface<'_> {
    fn radius(&self, direction: DVec3) -> f64 {
        let ground = self.ground.height_at(direction).unwrap_or(0.0);
        let uppermost = if self.wet { self.terrain.ground_or_sea(self.recipe, direction, ground) } else { ground };
        self.recipe.radius + uppermost
    }

    fn meet(&self, origin: DVec3, direction: DVec3) -> Option<DVec3> {
        let ground = self.ground.known.raycast(origin, direction).map(|hit| hit.position);
        let dives = |&sea: &f64| origin.cross(direction).length() < sea;
        let sea = self.recipe.sea.as_ref().filter(|_| self.wet).map(|sea| self.recipe.radius + sea.level_m);
        let wet = |towards: &DVec3| !self.terrain.is_kept_dry(*towards);
        let sea = sea.filter(dives).and_then(|sea| meet_sphere(origin, direction, sea).filter(wet).map(|towards| towards * sea));
        ground.into_iter().chain(sea).min_by(|a, b| a.distance_squared(origin).total_cmp(&b.distance_squared(origin)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::fly_camera::FlyCamera;
    use super::super::pose::Pose;
    use super::*;
    use std::path::Path;
    use std::sync::{Arc, RwLock};
    use std::time::Duration;
    use terrane_planet::draw::cut::{Cut, Leaf};
    use terrane_planet::draw::view::Camera;
    use terrane_planet::globe::patch::PatchId;
    use terrane_planet::globe::sphere::direction_at;
    use terrane_planet::planet::{Planet, CLEARANCE_M};
    use terrane_planet::query::{KnownGround, Refiner};
    use terrane_planet::recipe::Sea;

    /// Some decimetres of air about the viewer's eye.
    const LEAST_AIR: f64 = 0.3;

    /// A planet without sea.
    fn dry_planet() -> Planet {
        let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("planet/recipes/tiny.toml");
        let mut planet = Planet::from_recipe(Recipe::load(&recipe).unwrap(), 32).unwrap();
        planet.recipe.sea = None;
        planet
    }

    /// A planet without sea, known to 3 m along a line from a valley into a mountain side and beyond, and foot and top of that side.
    fn mountain() -> (Planet, KnownGround, [DVec3; 2]) {
        let planet = dry_planet();
        let (low, high) = steepest(&planet);
        let along = (0..=60).map(|k| low.lerp(high, f64::from(k) / 40.0));
        let (planet, known) = known_about(planet, along);
        (planet, known, [low, high])
    }

    /// The planet, and its ground known to 3 m about sites.
    fn known_about(planet: Planet, sites: impl Iterator<Item = DVec3>) -> (Planet, KnownGround) {
        let planet = Arc::new(planet);
        let known = Arc::new(RwLock::new(KnownGround::new(planet.lattice, planet.cells)));
        let refiner = Refiner::new(planet.clone(), known.clone());
        let wanted: Vec<_> = sites.map(|direction| refiner.refine(direction, 3.0)).collect();
        assert!(wanted.iter().all(|refinement| refinement.wait(Duration::from_secs(60))));
        drop((wanted, refiner));
        let known = Arc::into_inner(known).unwrap().into_inner().unwrap();
        (Arc::into_inner(planet).unwrap(), known)
    }

    /// The site, of many, that lies deepest below the ground around it.
    fn hollow(planet: &Planet) -> DVec3 {
        let sites = (0..4000).map(|k| direction_at(f64::from(k % 63) * 2.5 - 78.0, f64::from(k / 63) * 5.6));
        let depth = |site: &DVec3| {
            let side = site.any_orthonormal_vector() * (400.0 / planet.recipe.radius);
            let around = [side, -side, site.cross(side), side.cross(*site)].map(|way| planet.terrain.height(*site + way));
            around.iter().sum::<f64>() / 4.0 - planet.terrain.height(*site)
        };
        sites.max_by(|a, b| depth(a).total_cmp(&depth(b))).unwrap()
    }

    /// The steepest of many slopes 150 m long: its foot and its top.
    fn steepest(planet: &Planet) -> (DVec3, DVec3) {
        let pairs = (0..4000).map(|k| {
            let foot = direction_at(f64::from(k % 63) * 2.5 - 78.0, f64::from(k / 63) * 5.6);
            (foot, (foot + foot.any_orthonormal_vector() * (150.0 / planet.recipe.radius)).normalize())
        });
        let rise = |(foot, top): &(DVec3, DVec3)| planet.terrain.height(*top) - planet.terrain.height(*foot);
        pairs.max_by(|a, b| rise(a).total_cmp(&rise(b))).unwrap()
    }

    /// Distance from a position to the nearest ground, of many directions.
    fn clearance(known: &KnownGround, position: DVec3) -> f64 {
        let directions = (0..343).map(|k| DVec3::new(f64::from(k % 7 - 3), f64::from(k / 7 % 7 - 3), f64::from(k / 49 - 3)));
        let hits = directions.filter_map(|direction| known.raycast(position, direction));
        hits.map(|hit| hit.distance).fold(f64::MAX, f64::min)
    }

    #[test]
    fn flying_into_a_mountain_side_leads_up_along_it() {
        let (planet, known, [foot, top]) = mountain();
        let ground = DrawnGround::new(known);
        let surface = DrawnSurface::new(&ground, &planet.recipe, &planet.terrain);
        let towards = (top - foot).normalize();
        let position = foot * (surface.radius(foot) + 10.0);
        let level = Camera { position, forward: towards, up: foot, fov: 1.0, size: [64, 64] };
        let mut pose = Pose::of_camera(&level);
        let mut camera = FlyCamera::default();
        let (mut risen, mut nearest, start) = (0.0f64, f64::MAX, pose.position.length());
        for _ in 0..400 {
            camera.step(&mut pose, (DVec3::Z, true), 1.0, 0.03, &surface);
            assert!(pose.altitude(&surface) >= CLEARANCE_M - 1e-6, "{} m", pose.altitude(&surface));
            nearest = nearest.min(clearance(&ground.known, pose.position));
            risen = risen.max(pose.position.length() - start);
            if pose.position.dot(towards) > top.dot(towards) * planet.recipe.radius {
                break;
            }
        }
        assert!(risen > 50.0, "the slope is only {risen} m high");
        assert!((LEAST_AIR..CLEARANCE_M * 1.01).contains(&nearest), "{nearest} m from the ground");
    }

    #[test]
    fn ground_that_becomes_known_lifts_the_viewer() {
        let planet = dry_planet();
        let bottom = hollow(&planet);
        let (planet, known) = known_about(planet, std::iter::once(bottom));
        let height = |site: DVec3, level| known.height_to_level(site, level).unwrap().height;
        let finest = |site: DVec3| known.height_at(site).unwrap();
        let coarser = (0..finest(bottom).level).map(|level| (bottom, level));
        let above = |&(site, level): &(DVec3, u8)| height(site, level) - finest(site).height;
        let (site, level) = coarser.max_by(|a, b| above(a).total_cmp(&above(b))).unwrap();
        let (low, high) = (finest(site).height, height(site, level));
        assert!(high > low + 5.0, "{high} is hardly above {low}");
        let mut ground = DrawnGround::new(known);
        assert_eq!(ground.height_at(site), Some(low));
        // A coarser patch that is still drawn lies above.
        let drawn = Leaf { id: PatchId::containing(site, level), coarser_sides: 0 };
        ground.follow(&Cut { leaves: vec![drawn], ..Cut::default() });
        assert_eq!(ground.height_at(site), Some(high));
        let surface = DrawnSurface::new(&ground, &planet.recipe, &planet.terrain);
        let position = site * (planet.recipe.radius + low + CLEARANCE_M);
        let mut pose = Pose::of_camera(&Camera::looking(position, 0.0, 0.0, 1.0, [64, 64]));
        assert!(pose.keep_above(&surface) && !pose.keep_above(&surface));
        assert!((pose.position.length() - planet.recipe.radius - high - CLEARANCE_M).abs() < 1e-6);
    }

    #[test]
    fn rays_meet_the_sea_before_its_ground() {
        let (planet, known, [foot, _]) = mountain();
        let ground = DrawnGround::new(known);
        let mut recipe = planet.recipe.clone();
        let dry = DrawnSurface::new(&ground, &recipe, &planet.terrain).meet(foot * 4e4, -foot).unwrap();
        let sea = |level_m| Sea { level_m, beach_m: 0.0, shallow: [0.0; 3], deep: [0.0; 3] };
        let bed = dry.length() - recipe.radius;
        for (level, above) in [(bed + 40.0, 40.0), (bed - 40.0, 0.0)] {
            recipe.sea = Some(sea(level));
            let surface = DrawnSurface::new(&ground, &recipe, &planet.terrain);
            let met = surface.meet(foot * 4e4, -foot).unwrap();
            assert!((met.length() - dry.length() - above).abs() < 1e-6, "{}", met.length() - dry.length());
            assert!((surface.radius(foot) - met.length()).abs() < 1e-3);
        }
    }
}
