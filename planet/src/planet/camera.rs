//! Where cameras stand over a planet. In: a site and metres above what lies uppermost there, ground or sea, or above the datum. Out:
//! positions and cameras in planet-fixed metres.

use super::Planet;
use crate::draw::camera_path::{Keyframe, Waypoint};
use crate::draw::view::Camera;
use crate::draw::view_line::Stand;
use crate::globe::sphere::direction_at;
use glam::DVec3;

/// Metres above ground or sea that a camera keeps as it moves over what is drawn, which may be higher than the terrain for a while. A
/// camera that is lower is lifted. Keyframes may ask for less: [`Planet::camera_at`] takes them at their word.
pub const CLEARANCE_M: f64 = 1.5;

/// Least metres above ground or sea of a camera that is asked for.
pub const LEAST_ALTITUDE_M: f64 = 0.5;

impl Planet {
    /// Metres above the datum of what lies uppermost in a unit direction: the ground, or the sea where it covers the ground.
    pub fn surface_height(&self, direction: DVec3) -> f64 {
        self.terrain.ground_or_sea(&self.recipe, direction, self.terrain.height(direction))
    }

    /// The position `altitude_m` metres above ground or sea in a unit direction, in metres from the planet's centre.
    pub fn position_above(&self, direction: DVec3, altitude_m: f64) -> DVec3 {
        direction * (self.recipe.radius + self.surface_height(direction) + altitude_m)
    }

    /// The position of a stand in a unit direction, in metres from the planet's centre. Heights below [`LEAST_ALTITUDE_M`] above ground
    /// or sea are lifted to that.
    pub fn position_of(&self, direction: DVec3, stand: Stand) -> DVec3 {
        match stand {
            Stand::Altitude(metres) => self.position_above(direction, metres),
            Stand::Height(metres) => {
                let least = self.surface_height(direction) + LEAST_ALTITUDE_M;
                direction * (self.recipe.radius + metres.max(least))
            }
        }
    }

    /// Metres above ground or sea of a stand in a unit direction, lifted as in [`Planet::position_of`].
    pub fn altitude_of(&self, direction: DVec3, stand: Stand) -> f64 {
        match stand {
            Stand::Altitude(metres) => metres,
            Stand::Height(metres) => (metres - self.surface_height(direction)).max(LEAST_ALTITUDE_M),
        }
    }

    /// The camera of a keyframe, for a picture of a size in pixels. Nothing is range-checked:
    /// [`crate::draw::camera_path::CameraPath::new`] says which keyframes make sense.
    pub fn camera_at(&self, keyframe: &Keyframe, size: [u32; 2]) -> Camera {
        let position = self.position_of(direction_at(keyframe.latitude, keyframe.longitude), keyframe.stand);
        Camera::looking(position, keyframe.heading, keyframe.pitch, keyframe.fov.to_radians(), size)
    }

    /// The camera on a path, for a picture of a size in pixels.
    pub fn camera_on(&self, waypoint: &Waypoint, size: [u32; 2]) -> Camera {
        let position = self.position_of(waypoint.up, waypoint.stand);
        let (forward, up) = waypoint.facing();
        Camera { position, forward, up, fov: waypoint.fov.to_radians(), size }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::globe::sphere::latitude_longitude;
    use crate::recipe::Recipe;
    use std::path::Path;

    fn planet() -> Planet {
        let recipe = Recipe::from_toml(include_str!("../../recipes/tiny.toml"), "tiny", Path::new("")).unwrap();
        Planet::from_recipe(recipe, 16).unwrap()
    }

    /// The deepest and the highest, of many sites: latitude and longitude.
    fn sea_and_land(planet: &Planet) -> [[f64; 2]; 2] {
        let sites = || (0..600).map(|k| [f64::from(k % 30) * 5.0 - 72.0, f64::from(k / 30) * 18.0 - 180.0]);
        let height = |site: &[f64; 2]| planet.terrain.height(direction_at(site[0], site[1]));
        let higher = |a: &[f64; 2], b: &[f64; 2]| height(a).total_cmp(&height(b));
        [sites().min_by(higher).unwrap(), sites().max_by(higher).unwrap()]
    }

    #[test]
    fn the_surface_is_the_ground_on_land_and_the_sea_elsewhere() {
        let mut planet = planet();
        let level = planet.recipe.sea.as_ref().unwrap().level_m;
        let [sea, land] = sea_and_land(&planet).map(|[latitude, longitude]| direction_at(latitude, longitude));
        let [bed, ground] = [sea, land].map(|site| planet.terrain.height(site));
        assert!(bed < level - 10.0 && ground > level + 10.0, "{bed} m and {ground} m tell nothing");
        assert_eq!([sea, land].map(|site| planet.surface_height(site)), [level, ground]);
        // Without its sea the planet is ground everywhere.
        planet.recipe.sea = None;
        assert_eq!([sea, land].map(|site| planet.surface_height(site)), [bed, ground]);
    }

    /// The keyframe of a camera, altitudes counted from a height in metres above the datum.
    fn keyframe_of(planet: &Planet, camera: &Camera, surface: f64) -> Keyframe {
        let up = camera.position.normalize();
        let east = DVec3::Z.cross(up).normalize();
        let (latitude, longitude) = latitude_longitude(up);
        Keyframe {
            time_s: 0.0,
            latitude,
            longitude,
            stand: Stand::Altitude(camera.position.length() - planet.recipe.radius - surface),
            heading: camera.forward.dot(east).atan2(camera.forward.dot(up.cross(east))).to_degrees(),
            pitch: camera.forward.dot(up).asin().to_degrees(),
            fov: camera.fov.to_degrees(),
        }
    }

    fn keyframe([latitude, longitude]: [f64; 2], stand: Stand) -> Keyframe {
        Keyframe { time_s: 0.0, latitude, longitude, stand, heading: 110.0, pitch: -12.0, fov: 50.0 }
    }

    fn differs(a: &Keyframe, b: &Keyframe) -> bool {
        let metres = |k: &Keyframe| match k.stand {
            Stand::Altitude(metres) | Stand::Height(metres) => metres,
        };
        let numbers = |k: &Keyframe| [k.latitude, k.longitude, metres(k), k.heading, k.pitch, k.fov];
        numbers(a).iter().zip(numbers(b)).any(|(a, b)| (a - b).abs() > 1e-6)
    }

    #[test]
    fn a_camera_stands_where_its_keyframe_says() {
        let planet = planet();
        for [latitude, longitude] in sea_and_land(&planet) {
            for altitude_m in [0.5, CLEARANCE_M, 3000.0] {
                let wanted = keyframe([latitude, longitude], Stand::Altitude(altitude_m));
                let camera = planet.camera_at(&wanted, [640, 360]);
                let site = direction_at(latitude, longitude);
                let found = keyframe_of(&planet, &camera, planet.surface_height(site));
                assert!(camera.size == [640, 360] && !differs(&wanted, &found), "{wanted:?} became {found:?}");
            }
        }
    }

    #[test]
    fn altitudes_from_the_bed_of_the_sea_are_noticed() {
        let planet = planet();
        let [[latitude, longitude], _] = sea_and_land(&planet);
        let wanted = keyframe([latitude, longitude], Stand::Altitude(2.0));
        let camera = planet.camera_at(&wanted, [640, 360]);
        let bed = planet.terrain.height(direction_at(latitude, longitude));
        assert!(differs(&wanted, &keyframe_of(&planet, &camera, bed)));
    }

    #[test]
    fn waypoints_and_keyframes_have_the_same_camera() {
        let planet = planet();
        for (site, stand) in [([-38.0, 250.0], Stand::Altitude(900.0)), ([90.0, 30.0], Stand::Height(4000.0))] {
            let keyframe = keyframe(site, stand);
            let [a, b] = [planet.camera_at(&keyframe, [640, 360]), planet.camera_on(&Waypoint::of(&keyframe), [640, 360])];
            assert!(a.position.distance(b.position) < 1e-6, "{a:?} {b:?}");
            assert!(a.forward.distance(b.forward) < 1e-9 && a.up.distance(b.up) < 1e-9 && a.fov == b.fov, "{a:?} {b:?}");
        }
    }

    #[test]
    fn heights_count_from_the_datum_and_never_lead_into_the_ground() {
        let planet = planet();
        for [latitude, longitude] in sea_and_land(&planet) {
            let site = direction_at(latitude, longitude);
            let surface = planet.surface_height(site);
            let above = |stand| planet.position_of(site, stand).length() - planet.recipe.radius - surface;
            assert!((above(Stand::Height(surface + 70.0)) - 70.0).abs() < 1e-6);
            assert!((above(Stand::Height(surface - 70.0)) - LEAST_ALTITUDE_M).abs() < 1e-6);
            assert!((planet.altitude_of(site, Stand::Height(surface + 70.0)) - 70.0).abs() < 1e-6);
        }
    }
}
