//! Where first looks are taken from.

use crate::commands::viewing::keyframe_at;
use terrane_planet::draw::camera_path::Keyframe;
use terrane_planet::globe::sphere::{direction_at, latitude_longitude};
use terrane_planet::planet::Planet;

/// Vertical field of view in degrees.
const FOV: f64 = 50.0;

/// Name, metres above the site, heading and pitch in degrees: the way down of `tools/run`.
const DESCENT: [(&str, f64, [f64; 2]); 4] = [
    ("300 km", 3e5, [60.0, -22.0]),
    ("20 km", 2e4, [310.0, -15.0]),
    ("1 km", 1e3, [310.0, -11.0]),
    ("50 m", 50.0, [300.0, -6.0]),
];

/// The views of other planets among them.
const ELSEWHERE: [&str; 3] = ["300 km", "1 km", "50 m"];

/// Latitude and longitude of that way down on `terra`, and a view of its mountains: site and metres above it, heading and pitch.
const COAST: [f64; 2] = [-38.95, 34.34];
const MOUNTAINS: ([f64; 3], [f64; 2]) = ([44.78, 54.17, 6500.0], [200.0, -12.0]);

/// Sites among which the highest is looked for, spread evenly, and degrees of longitude from one to the next.
const SITES: u32 = 200;
const GOLDEN_ANGLE: f64 = 137.507_764_050_037_85;

/// A view with a name.
pub(super) struct Sight {
    pub(super) name: String,
    pub(super) keyframe: Keyframe,
}

/// The one that is asked for, or those that the planet has by default.
pub(super) fn sights(planet: &Planet, at: Option<[f64; 3]>, look: Option<[f64; 2]>) -> anyhow::Result<Vec<Sight>> {
    let sight = |name: &str, at, look| Ok(Sight { name: name.to_owned(), keyframe: keyframe_at(at, look, FOV, planet)? });
    let above = |[latitude, longitude]: [f64; 2], altitude_m| [latitude, longitude, altitude_m];
    if let Some(at) = at {
        let name = format!("{},{},{}", at[0], at[1], at[2]);
        return Ok(vec![sight(&name, at, look)?]);
    }
    if planet.recipe.name == "Terra" {
        let mut all: Vec<Sight> = DESCENT
            .iter()
            .map(|(name, altitude_m, look)| sight(name, above(COAST, *altitude_m), Some(*look)))
            .collect::<Result<_, _>>()?;
        let (at, look) = MOUNTAINS;
        all.push(sight("mountains", at, Some(look))?);
        return Ok(all);
    }
    let site = highest_site(planet);
    let some = DESCENT.iter().filter(|(name, ..)| ELSEWHERE.contains(name));
    some.map(|(name, altitude_m, [heading, pitch])| {
        // From high above a small planet the horizon is lower than that.
        let dip = (planet.recipe.radius / (planet.recipe.radius + altitude_m)).acos().to_degrees();
        sight(name, above(site, *altitude_m), Some([*heading, pitch.min(-dip)]))
    })
    .collect()
}

/// Latitude and longitude of the highest of some sites.
fn highest_site(planet: &Planet) -> [f64; 2] {
    let site = |k: u32| {
        let latitude = (1.0 - f64::from(2 * k + 1) / f64::from(SITES)).asin().to_degrees();
        direction_at(latitude, f64::from(k) * GOLDEN_ANGLE)
    };
    let height = |k: &u32| planet.surface_height(site(*k));
    let highest = (0..SITES).max_by(|a, b| height(a).total_cmp(&height(b))).unwrap_or(0);
    let (latitude, longitude) = latitude_longitude(site(highest));
    [latitude, longitude]
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrane_planet::draw::view_line::Stand;
    use terrane_planet::recipe::shipped;

    fn planet(name: &str) -> Planet {
        Planet::from_recipe(shipped::load(name).unwrap(), 16).unwrap()
    }

    #[test]
    fn planets_have_views_of_their_own() {
        let names =
            |planet: &Planet| -> Vec<String> { sights(planet, None, None).unwrap().into_iter().map(|s| s.name).collect() };
        assert_eq!(names(&planet("terra")), ["300 km", "20 km", "1 km", "50 m", "mountains"]);
        let tiny = planet("tiny");
        assert_eq!(names(&tiny), ELSEWHERE);
        let (first, second) = (highest_site(&tiny), highest_site(&tiny));
        assert!(first == second && tiny.surface_height(direction_at(first[0], first[1])) > 300.0, "{first:?}");
        let from_afar = &sights(&tiny, None, None).unwrap()[0];
        assert!(from_afar.keyframe.pitch < -80.0, "{}", from_afar.keyframe.pitch);
        let asked = sights(&tiny, Some([10.0, 20.0, 500.0]), Some([30.0, -20.0])).unwrap();
        assert_eq!((asked.len(), asked[0].keyframe.stand, asked[0].keyframe.pitch), (1, Stand::Altitude(500.0), -20.0));
        assert!(sights(&tiny, Some([100.0, 20.0, 500.0]), None).is_err());
    }
}
