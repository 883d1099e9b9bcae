//! `--at`: where a camera stands, as numbers or as the name of a place. In: text. Out: a site, once the planet is known.

use super::viewing::numbers;
use anyhow::{bail, ensure};
use terrane_planet::recipe::Recipe;

/// Where a camera stands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum At {
    /// Latitude, longitude in degrees, and metres above ground or sea.
    Site([f64; 3]),
    /// A place of the planet, and metres in place of its own.
    Place(String, Option<f64>),
}

/// A camera's site, and where it looks if a place says so: heading and pitch in degrees.
pub(crate) type Stance = ([f64; 3], Option<[f64; 2]>);

/// Three numbers; or a name, after which may stand a comma and metres.
pub(crate) fn at(text: &str) -> anyhow::Result<At> {
    let text = text.trim();
    if !text.starts_with(char::is_alphabetic) {
        return match numbers(text) {
            Ok(site) => Ok(At::Site(site)),
            Err(error) => bail!("{error}, nor the name of a place"),
        };
    }
    let Some((name, metres)) = text.rsplit_once(',') else { return Ok(At::Place(text.to_owned(), None)) };
    let metres = numbers::<1>(metres);
    ensure!(metres.is_ok(), "'{text}' is neither a place nor a place and metres, such as coast,500");
    Ok(At::Place(name.trim().to_owned(), metres.ok().map(|[metres]| metres)))
}

impl At {
    /// The site on a planet.
    pub(crate) fn stance(&self, recipe: &Recipe) -> anyhow::Result<Stance> {
        match self {
            At::Site(site) => Ok((*site, None)),
            At::Place(name, metres) => {
                let place = recipe.place(name)?;
                let site = [place.latitude_deg, place.longitude_deg, metres.unwrap_or(place.altitude_m)];
                Ok((site, Some([place.heading_deg, place.pitch_deg])))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrane_planet::recipe::shipped;

    #[test]
    fn places_stand_for_numbers() {
        assert_eq!(at("-38.95, 34.34,1e3").unwrap(), At::Site([-38.95, 34.34, 1e3]));
        let terra = shipped::load("terra").unwrap();
        let stance = |text| at(text).unwrap().stance(&terra);
        assert_eq!(stance("coast").unwrap(), ([-38.95, 34.34, 1500.0], Some([310.0, -9.0])));
        assert_eq!(stance("Coast, 200").unwrap().0, [-38.95, 34.34, 200.0]);
        let unknown = stance("atlantis").unwrap_err().to_string();
        assert!(unknown.contains("'atlantis' on Terra") && unknown.contains("Coast, Beach"), "{unknown}");
        for wrong in ["1,2", "coast,high", "", "7"] {
            assert!(at(wrong).is_err(), "{wrong}");
        }
    }
}
