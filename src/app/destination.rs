//! Where to go, as people write it: `46 8`, `46°30'N, 8°15'E`, `-38.95, 34.34, 1200 m`, or a view of one line.

use terrane_planet::draw::view_line::{ViewLine, SCHEME};
use terrane_planet::recipe::Place;

/// Somewhere to go to.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Destination {
    Site(Site),
    View(ViewLine),
}

/// A site, and how far above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Site {
    /// Latitude and longitude in degrees.
    pub(super) at: [f64; 2],
    /// Metres above ground or sea; what suits the viewer if none.
    pub(super) altitude_m: Option<f64>,
    /// Heading and pitch in degrees; what suits the altitude if none.
    pub(super) look: Option<[f64; 2]>,
}

impl Site {
    /// That of a place of a recipe.
    pub(super) fn of_place(place: &Place) -> Site {
        Site {
            at: [place.latitude_deg, place.longitude_deg],
            altitude_m: Some(place.altitude_m),
            look: Some([place.heading_deg, place.pitch_deg]),
        }
    }
}

/// What a text asks for, on a planet with some places.
///
/// # Errors
/// What was found, and what was expected.
pub(super) fn parse(text: &str, places: &[Place]) -> Result<Destination, String> {
    let text = text.trim();
    if let ([place], false) = (&Place::meant(places, text)[..], text.is_empty()) {
        return Ok(Destination::Site(Site::of_place(place)));
    }
    if text.starts_with(SCHEME) {
        return text.parse().map(Destination::View).map_err(|error| format!("{error}"));
    }
    let expected = || {
        format!("'{text}' is no place: expected latitude and longitude such as 46 8 or 46°30'N 8°E, and a height such as 1200 m if you like")
    };
    let mut numbers = Numbers { rest: text };
    let latitude = numbers.angle('N', 'S').ok_or_else(expected)?;
    let longitude = numbers.angle('E', 'W').ok_or_else(expected)?;
    let altitude_m = if numbers.rest.is_empty() { None } else { Some(numbers.altitude().ok_or_else(expected)?) };
    if !numbers.rest.is_empty() {
        return Err(expected());
    }
    if !(-90.0..=90.0).contains(&latitude) || !(-360.0..=360.0).contains(&longitude) {
        return Err(format!(
            "{latitude}, {longitude} is nowhere: expected -90 to 90 degrees north, and -360 to 360 degrees east"
        ));
    }
    Ok(Destination::Site(Site { at: [latitude, longitude], altitude_m, look: None }))
}

/// What is left of a text.
struct Numbers<'a> {
    rest: &'a str,
}

impl<'a> Numbers<'a> {
    /// Degrees, and minutes and seconds if there are any, with the letter of either way.
    fn angle(&mut self, plus: char, minus: char) -> Option<f64> {
        let degrees = self.number()?;
        let mut size = degrees.abs();
        if self.takes(&['°', 'º']) {
            if let Some((minutes, rest)) = self.part(&['\'', '′']) {
                (size, self.rest) = (size + minutes / 60.0, rest);
                if let Some((seconds, rest)) = self.part(&['"', '″']) {
                    (size, self.rest) = (size + seconds / 3600.0, rest);
                }
            }
        }
        let away = if self.takes(&[minus, minus.to_ascii_lowercase()]) { -1.0 } else { 1.0 };
        self.takes(&[plus, plus.to_ascii_lowercase()]);
        self.takes(&[',', ';']);
        Some(if degrees.is_sign_negative() { -size } else { size } * away)
    }

    /// Metres or kilometres above ground or sea.
    fn altitude(&mut self) -> Option<f64> {
        let number = self.number()?;
        let unit = self.rest;
        self.rest = "";
        let metres = match unit {
            "" | "m" => number,
            "km" => number * 1e3,
            _ => return None,
        };
        (0.5..=1e9).contains(&metres).then_some(metres)
    }

    fn number(&mut self) -> Option<f64> {
        let (number, rest) = first_number(self.rest)?;
        self.rest = rest;
        Some(number)
    }

    /// A number that one of some marks follows, and what is after both.
    fn part(&self, marks: &[char]) -> Option<(f64, &'a str)> {
        let (number, rest) = first_number(self.rest)?;
        Some((number, rest.strip_prefix(marks)?.trim_start()))
    }

    fn takes(&mut self, marks: &[char]) -> bool {
        let rest = self.rest.strip_prefix(marks);
        self.rest = rest.unwrap_or(self.rest).trim_start();
        rest.is_some()
    }
}

fn first_number(text: &str) -> Option<(f64, &str)> {
    let end = text.char_indices().find(|(at, c)| !(c.is_ascii_digit() || *c == '.' || (*at == 0 && (*c == '-' || *c == '+'))));
    let (number, rest) = text.split_at(end.map_or(text.len(), |(at, _)| at));
    Some((number.parse().ok()?, rest.trim_start()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn site(text: &str) -> Site {
        match parse(text, &[]) {
            Ok(Destination::Site(site)) => site,
            other => panic!("{text}: {other:?}"),
        }
    }

    fn at(text: &str) -> [f64; 2] {
        site(text).at
    }

    #[test]
    fn sites_are_understood_as_people_write_them() {
        for text in ["46 8", "46,8", " 46.0 , 8 ", "46N 8E", "46° N, 8° E", "46°0'N 8°0'0\"E", "+46;8"] {
            assert_eq!(at(text), [46.0, 8.0], "{text}");
        }
        assert_eq!(at("46°30'S 8°15'36\"w"), [-46.5, -8.26]);
        assert_eq!(at("-38.95 -34.34"), [-38.95, -34.34]);
        assert_eq!(at("-0.5, 0"), [-0.5, 0.0]);
    }

    #[test]
    fn heights_and_views_come_along() {
        let altitude = |text: &str| site(text).altitude_m;
        assert_eq!(altitude("46 8 1200"), Some(1200.0));
        assert_eq!(altitude("46N, 8E, 1.5 km"), Some(1500.0));
        assert_eq!(altitude("46 8"), None);
        let text = "terrane:1/at=46,8/height=4000/look=90,-10";
        assert_eq!(parse(text, &[]), Ok(Destination::View(text.parse().unwrap())));
    }

    #[test]
    fn what_is_nowhere_is_refused_with_what_was_expected() {
        for text in ["", "46", "46 8 x", "46 8 12 13", "north", "46E 8N", "46 8 -5"] {
            assert!(parse(text, &[]).unwrap_err().contains("expected latitude"), "{text}: {:?}", parse(text, &[]));
        }
        assert!(parse("98 8", &[]).unwrap_err().contains("nowhere"));
        assert!(parse("terrane:1/at=1,2", &[]).unwrap_err().contains("altitude"));
    }

    #[test]
    fn places_go_by_the_beginning_of_their_names_where_that_tells_them_apart() {
        let place = |name: &str, latitude_deg| Place {
            name: name.to_owned(),
            latitude_deg,
            longitude_deg: 8.0,
            altitude_m: 900.0,
            heading_deg: 10.0,
            pitch_deg: -5.0,
        };
        let places = [place("North coast", 1.0), place("North", 2.0), place("Long bay", 3.0)];
        let latitude = |text: &str| match parse(text, &places) {
            Ok(Destination::Site(site)) => Some(site.at[0]),
            _ => None,
        };
        assert_eq!(["north c", "NORTH", "long", "nor", ""].map(latitude), [Some(1.0), Some(2.0), Some(3.0), None, None]);
    }
}
