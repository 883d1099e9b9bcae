//! Camera paths that any planet has: down to a place, along a shore, and round all places. In: a planet, whose recipe may list places.
//! Out: routes. Altitudes and ways go by the planet's radius, so that a world of 30 km is seen as one of 6,000.

mod hop;
mod shore;

use super::Planet;
use crate::draw::camera_path::{Keyframe, Route};
use crate::draw::view::local_frame;
use crate::draw::view_line::Stand;
use crate::globe::sphere::{direction_at, latitude_longitude};
use glam::{DQuat, DVec3};

/// Altitude in planet radii from which the whole planet is in the picture.
const ORBIT: f64 = 3.1;

/// Vertical field of view in degrees.
const FOV: f64 = 50.0;

/// A path that any planet has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Journey {
    /// From orbit down to the first place, in a minute.
    Descent,
    /// Low along the shore nearest to the first place that has one near; where there is no sea, along the foot of hills.
    Coast,
    /// From orbit down to every place in turn; from one to the next as high as half the way is long.
    Tour,
}

impl Journey {
    /// All of them, with their names.
    pub const ALL: [(&'static str, Journey); 3] =
        [("descent", Journey::Descent), ("coast", Journey::Coast), ("tour", Journey::Tour)];
}

impl Planet {
    /// The route of a journey over this planet. Where its recipe lists no places, the highest sites of some hundred stand for them.
    pub fn journey(&self, journey: Journey) -> Route {
        let stops = Stop::all(self);
        let keyframes = match journey {
            Journey::Descent => descent(self, &stops),
            Journey::Coast => shore::keyframes(self, &stops),
            Journey::Tour => hop::tour(self, &stops),
        };
        Route::timed(keyframes)
    }
}

/// A camera that stands somewhere.
#[derive(Clone, Copy, Debug)]
struct Stop {
    up: DVec3,
    altitude_m: f64,
    heading: f64,
    pitch: f64,
}

/// Sites among which high ones are looked for where there are no places, and degrees of longitude from one to the next.
const SITES: u32 = 200;
const GOLDEN_ANGLE: f64 = 137.507_764_050_037_85;

/// Parts of the planet, each of which has one.
const PARTS: u32 = 4;

impl Stop {
    /// The places of a planet, at least one.
    fn all(planet: &Planet) -> Vec<Stop> {
        let places = &planet.recipe.places;
        if places.is_empty() {
            return Stop::high_ones(planet);
        }
        let stop = |place: &crate::recipe::Place| Stop {
            up: direction_at(place.latitude_deg, place.longitude_deg),
            altitude_m: place.altitude_m,
            heading: place.heading_deg,
            pitch: place.pitch_deg,
        };
        places.iter().map(stop).collect()
    }

    /// The highest of sites that are spread evenly, of each part of the planet one, the highest first.
    fn high_ones(planet: &Planet) -> Vec<Stop> {
        let height = |site: &DVec3| planet.surface_height(*site);
        let part = |part: u32| (part * SITES / PARTS..(part + 1) * SITES / PARTS).map(site);
        let mut highest: Vec<DVec3> = (0..PARTS).filter_map(|k| part(k).max_by(|a, b| height(a).total_cmp(&height(b)))).collect();
        highest.sort_by(|a, b| height(b).total_cmp(&height(a)));
        let altitude_m = (planet.recipe.radius / 100.0).min(1000.0);
        let pitch = pitch_at(altitude_m, planet.recipe.radius);
        highest.into_iter().map(|up| Stop { up, altitude_m, heading: 0.0, pitch }).collect()
    }

    fn keyframe(&self, time_s: f64) -> Keyframe {
        let (latitude, longitude) = latitude_longitude(self.up);
        let stand = Stand::Altitude(self.altitude_m);
        Keyframe { time_s, latitude, longitude, stand, heading: short_way(self.heading), pitch: self.pitch, fov: FOV }
    }

    /// The same turned by degrees to the right.
    fn turned(&self, degrees: f64) -> Stop {
        Stop { heading: self.heading + degrees, ..*self }
    }
}

/// One of the sites that are spread evenly.
fn site(k: u32) -> DVec3 {
    let latitude = (1.0 - f64::from(2 * k + 1) / f64::from(SITES)).asin().to_degrees();
    direction_at(latitude, f64::from(k) * GOLDEN_ANGLE)
}

/// Seconds, share of the way down by the altitude's logarithm, and degrees that are yet to turn.
const DESCENT: [(f64, f64, f64); 5] =
    [(0.0, 0.0, -30.0), (20.0, 0.326, -30.0), (35.0, 0.536, -20.0), (50.0, 0.768, -5.0), (60.0, 1.0, 0.0)];

/// Places from which so large a part of the planet is in sight, in radii of altitude, are none to descend to.
const LOW: f64 = 0.1;

fn descent(planet: &Planet, stops: &[Stop]) -> Vec<Keyframe> {
    let radius = planet.recipe.radius;
    let Some(end) = stops.iter().find(|stop| stop.altitude_m < LOW * radius).or(stops.first()) else { return Vec::new() };
    let top = (ORBIT * radius).max(end.altitude_m);
    let keyframe = |(time_s, share, turn): (f64, f64, f64)| {
        let altitude_m = top.powf(1.0 - share) * end.altitude_m.powf(share);
        let pitch = if share < 1.0 { pitch_at(altitude_m, radius) } else { end.pitch };
        Stop { altitude_m, pitch, ..end.turned(turn) }.keyframe(time_s)
    };
    DESCENT.map(keyframe).to_vec()
}

/// The pitch, in degrees, of a camera that sees where it flies: below the horizon, the more the higher, and straight down from orbit.
fn pitch_at(altitude_m: f64, radius: f64) -> f64 {
    let dip = (radius / (radius + altitude_m)).acos().to_degrees();
    let below = 43.0 * (altitude_m / (0.047 * radius)).powf(0.2);
    -(dip + below).min(90.0)
}

/// The direction an angle away from another, in radians, towards a heading in degrees.
fn moved(up: DVec3, heading: f64, angle: f64) -> DVec3 {
    let frame = local_frame(up);
    let (sine, cosine) = heading.to_radians().sin_cos();
    let ahead = frame.y_axis * cosine + frame.x_axis * sine;
    (up * angle.cos() + ahead * angle.sin()).normalize()
}

/// The great circle from one direction to another; any of them if they are the same, or opposite.
struct Circle {
    from: DVec3,
    axis: DVec3,
    angle: f64,
}

impl Circle {
    fn between(from: DVec3, to: DVec3) -> Circle {
        let across = from.cross(to);
        let angle = across.length().atan2(from.dot(to));
        Circle { from, axis: across.try_normalize().unwrap_or_else(|| from.any_orthonormal_vector()), angle }
    }

    /// The direction at a share of the way.
    fn at(&self, share: f64) -> DVec3 {
        DQuat::from_axis_angle(self.axis, self.angle * share) * self.from
    }

    /// Degrees clockwise from north of the way on from there.
    fn heading(&self, share: f64) -> f64 {
        let up = self.at(share);
        let (frame, ahead) = (local_frame(up), self.axis.cross(up));
        ahead.dot(frame.x_axis).atan2(ahead.dot(frame.y_axis)).to_degrees()
    }
}

/// An angle in degrees within -180 and 180.
fn short_way(angle: f64) -> f64 {
    angle - 360.0 * (angle / 360.0).round()
}

/// From 0 to 1, level at both ends.
fn smooth(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::{shipped, Recipe};
    use std::path::Path;

    fn planet(name: &str) -> Planet {
        Planet::from_recipe(shipped::load(name).unwrap(), 16).unwrap()
    }

    fn metres(stand: Stand) -> f64 {
        let (Stand::Altitude(metres) | Stand::Height(metres)) = stand;
        metres
    }

    /// Whether the planet's disc, as large as its datum, reaches into the middle column of a picture.
    fn sees_ground(planet: &Planet, camera: &crate::draw::view::Camera) -> bool {
        let down = -camera.position.normalize();
        let limb = (planet.recipe.radius / camera.position.length()).min(1.0).asin();
        let (forward, half) = (camera.forward, camera.fov / 2.0);
        forward.angle_between(down) < limb + half
    }

    #[test]
    fn every_shipped_planet_has_every_journey() {
        for name in ["terra", "luna", "mars", "tiny", "jacksboro", "earth"] {
            let planet = planet(name);
            assert!((4..=8).contains(&planet.recipe.places.len()), "{name}");
            for (title, journey) in Journey::ALL {
                let path =
                    planet.journey(journey).path(planet.recipe.radius).unwrap_or_else(|error| panic!("{name} {title}: {error}"));
                let (first, last) = path.span();
                assert!((20.0..400.0).contains(&(last - first)), "{name} {title}: {last} s");
                for k in 0..=300 {
                    let waypoint = path.at(first + (last - first) * f64::from(k) / 300.0);
                    let camera = planet.camera_on(&waypoint, [1280, 720]);
                    let altitude = camera.position.length() - planet.recipe.radius - planet.surface_height(waypoint.up);
                    assert!(altitude > 5.0 && altitude < 4.0 * planet.recipe.radius, "{name} {title}: {altitude} m at {k}");
                    assert!(sees_ground(&planet, &camera), "{name} {title}: nothing but sky at {k}");
                }
            }
        }
    }

    #[test]
    fn planets_without_places_have_journeys_too() {
        let text = crate::recipe::ground_text(include_str!("../../../recipes/tiny.toml")).into_owned();
        let recipe = Recipe::from_toml(&text, "tiny", Path::new("")).unwrap();
        assert!(recipe.places.is_empty());
        let planet = Planet::from_recipe(recipe, 16).unwrap();
        for (title, journey) in Journey::ALL {
            planet.journey(journey).path(planet.recipe.radius).unwrap_or_else(|error| panic!("{title}: {error}"));
        }
    }

    #[test]
    fn a_descent_ends_at_the_first_place_as_its_recipe_has_it() {
        let planet = planet("terra");
        let (route, place) = (planet.journey(Journey::Descent), &planet.recipe.places[0]);
        let last = route.keyframes.last().unwrap();
        assert!((last.latitude - place.latitude_deg).abs() < 1e-9 && (last.longitude - place.longitude_deg).abs() < 1e-9);
        assert!((metres(last.stand) / place.altitude_m - 1.0).abs() < 1e-9);
        assert_eq!((last.heading, last.pitch), (short_way(place.heading_deg), place.pitch_deg));
    }

    #[test]
    fn a_tour_comes_by_every_place() {
        let planet = planet("tiny");
        let path = planet.journey(Journey::Tour).path(planet.recipe.radius).unwrap();
        let (first, last) = path.span();
        let points: Vec<_> = (0..=4000).map(|k| path.at(first + (last - first) * f64::from(k) / 4000.0)).collect();
        for place in &planet.recipe.places {
            let up = direction_at(place.latitude_deg, place.longitude_deg);
            let near = |k: &&crate::draw::camera_path::Waypoint| k.up.angle_between(up) < 1e-6;
            let there: Vec<f64> = points.iter().filter(near).map(|point| metres(point.stand)).collect();
            let lowest = there.iter().fold(f64::MAX, |a, b| a.min(*b));
            assert!((lowest / place.altitude_m - 1.0).abs() < 1e-6, "{}: {lowest}", place.name);
        }
    }

    #[test]
    fn a_coast_is_flown_level_between_land_and_sea() {
        let planet = planet("tiny");
        let route = planet.journey(Journey::Coast);
        let ground = |keyframe: &Keyframe| planet.terrain.height(direction_at(keyframe.latitude, keyframe.longitude));
        let level = planet.terrain.sea_level().unwrap();
        let near = |keyframe: &&Keyframe| (ground(keyframe) - level).abs() < 150.0;
        assert!(route.keyframes.iter().all(|keyframe| matches!(keyframe.stand, Stand::Height(_))));
        let (count, all) = (route.keyframes.iter().filter(near).count(), route.keyframes.len());
        assert!(2 * count > all, "{count} of {all} keyframes are near the shore");
    }
}
