//! The `[[place]]` tables of a recipe: views worth a visit, by name. In: a table, or a name. Out: a checked [`Place`]; and the text of a
//! recipe without them, since they decide nothing of a planet.

use super::error::RecipeError;
use super::reader::Reader;
use std::borrow::Cow;
use thiserror::Error;

/// A view of a planet that has a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its name, which begins with a letter. No two of a planet are the same but for case.
    pub name: String,
    /// Latitude of the camera in degrees (-90 to 90).
    pub latitude_deg: f64,
    /// Its longitude in degrees (-180 to 180).
    pub longitude_deg: f64,
    /// Its altitude in metres above ground or sea (0.5 to 1e9).
    pub altitude_m: f64,
    /// Where it looks, in degrees clockwise from north (-360 to 360).
    pub heading_deg: f64,
    /// And in degrees above the horizontal (-90 to 90).
    pub pitch_deg: f64,
}

/// Why no place is meant by a name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PlaceError {
    /// The planet has none.
    #[error("no place '{found}' on {planet}: its recipe lists none; expected latitude, longitude and metres")]
    NoPlaces {
        /// The name asked for.
        found: String,
        /// The planet's name.
        planet: String,
    },
    /// None or several of those that it has.
    #[error("no one place '{found}' on {planet}, expected the beginning of one of: {names}")]
    Unknown {
        /// The name asked for.
        found: String,
        /// The planet's name.
        planet: String,
        /// The names that there are, or those that begin so.
        names: String,
    },
}

impl Place {
    pub(super) fn read(reader: &Reader<'_>) -> Result<Place, RecipeError> {
        let expected = "a name on one line that begins with a letter";
        let name = reader.string("name", expected)?;
        if !name.starts_with(char::is_alphabetic) || name.contains(char::is_control) {
            return Err(reader.wrong_name("name", &name, expected));
        }
        let place = Place {
            name,
            latitude_deg: reader.number("latitude_deg", -90.0..=90.0)?,
            longitude_deg: reader.number("longitude_deg", -180.0..=180.0)?,
            altitude_m: reader.number("altitude_m", 0.5..=1e9)?,
            heading_deg: reader.number("heading_deg", -360.0..=360.0)?,
            pitch_deg: reader.number("pitch_deg", -90.0..=90.0)?,
        };
        reader.finish()?;
        Ok(place)
    }

    /// The places of the top-level tables of a recipe.
    pub(super) fn read_all(reader: &Reader<'_>, text: &str) -> Result<Vec<Place>, RecipeError> {
        let tables = reader.tables("place")?;
        let mut places: Vec<Place> = Vec::new();
        for table in &tables {
            let place = Place::read(table)?;
            if places.iter().any(|other| same(&other.name, &place.name)) {
                return Err(table.wrong_name("name", &place.name, "a name that no place before has"));
            }
            places.push(place);
        }
        // What decides the planet is found by these lines.
        let lines = text.lines().filter(|line| is_header(line)).count();
        if lines != tables.len() {
            let found = format!("{} tables and {lines} lines [[place]]", tables.len());
            return Err(reader.wrong("place", reader.line_of("place"), found, "a line [[place]] for each place, and no other"));
        }
        Ok(places)
    }

    /// The places that a text may mean, in small or capital letters: the one of that name, or else all whose names begin so.
    pub fn meant<'a>(places: &'a [Place], text: &str) -> Vec<&'a Place> {
        if let Some(exact) = places.iter().find(|place| same(&place.name, text)) {
            return vec![exact];
        }
        places.iter().filter(|place| place.name.to_lowercase().starts_with(&text.to_lowercase())).collect()
    }

    /// The place of a planet that a name means: its own, or the beginning of no other's, in small or capital letters.
    pub(super) fn find<'a>(places: &'a [Place], planet: &str, found: &str) -> Result<&'a Place, PlaceError> {
        let meant = Place::meant(places, found);
        match &meant[..] {
            [place] => Ok(place),
            _ => {
                let (found, planet) = (found.to_owned(), planet.to_owned());
                if places.is_empty() {
                    return Err(PlaceError::NoPlaces { found, planet });
                }
                let listed = if meant.is_empty() { places.iter().collect() } else { meant };
                let names = listed.iter().map(|place| place.name.as_str()).collect::<Vec<_>>().join(", ");
                Err(PlaceError::Unknown { found, planet, names })
            }
        }
    }
}

fn same(a: &str, b: &str) -> bool {
    a.to_lowercase() == b.to_lowercase()
}

fn is_header(line: &str) -> bool {
    let line = line.split('#').next().unwrap_or_default().trim();
    let inner = line.strip_prefix("[[").and_then(|line| line.strip_suffix("]]"));
    inner.is_some_and(|inner| inner.trim() == "place")
}

/// The text of a recipe without its places: what decides the planet. A place goes from its line `[[place]]` to its last key, and a row of
/// places takes with it what stands between them, and one blank line before it if there is one: so a text to whose end places were added
/// gives what it was before.
pub fn ground_text(text: &str) -> Cow<'_, str> {
    if !text.lines().any(is_header) {
        return Cow::Borrowed(text);
    }
    let mut kept: Vec<&str> = Vec::new();
    let (mut inside, mut after) = (false, Vec::new());
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim();
        if trimmed.starts_with('[') {
            let was_inside = inside;
            inside = is_header(line);
            if !inside {
                kept.append(&mut after);
            } else if !was_inside && kept.last().is_some_and(|line| line.trim().is_empty()) {
                kept.pop();
            }
        }
        match (inside, trimmed.is_empty() || trimmed.starts_with('#')) {
            (false, _) => kept.push(line),
            (true, true) => after.push(line),
            (true, false) => after.clear(),
        }
    }
    kept.append(&mut after);
    Cow::Owned(kept.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::{Edit, Recipe, Shape};
    use std::path::Path;

    const TINY: &str = include_str!("../../recipes/tiny.toml");
    const COAST: &str = "\n[[place]]\nname = \"Coast\"\nlatitude_deg = 1.5\nlongitude_deg = -2\naltitude_m = 300\nheading_deg = 40\npitch_deg = -9\n";

    fn bare() -> String {
        ground_text(TINY).into_owned()
    }

    fn read(places: &str) -> Result<Recipe, String> {
        Recipe::from_toml(&(bare() + places), "tiny.toml", Path::new("")).map_err(|error| error.to_string())
    }

    fn named(name: &str) -> String {
        COAST.replace("Coast", name)
    }

    #[test]
    fn places_are_optional_and_checked() {
        assert!(read("").unwrap().places.is_empty());
        let place = Place {
            name: "Coast".into(),
            latitude_deg: 1.5,
            longitude_deg: -2.0,
            altitude_m: 300.0,
            heading_deg: 40.0,
            pitch_deg: -9.0,
        };
        assert_eq!(read(COAST).unwrap().places, [place]);
        let wrong = [
            ("\"Coast\"", "\"7\"", "`place[0].name`: found string \"7\", expected a name on one line that begins with a letter"),
            ("altitude_m = 300", "altitude_m = 0", "`place[0].altitude_m`"),
            ("pitch_deg = -9", "pitch_deg = -91", "`place[0].pitch_deg`"),
            ("heading_deg = 40\n", "", "`place[0].heading_deg`: found nothing"),
            ("heading_deg = 40\n", "heading_deg = 40\nzoom = 1\n", "`place[0].zoom`: found an unknown key"),
            ("[[place]]", "[[place]]\n[[ place ]] # twice", "`place[0].name`: found nothing"),
        ];
        for (from, to, message) in wrong {
            let error = read(&COAST.replace(from, to)).unwrap_err();
            assert!(error.contains(message), "{to}: {error}");
        }
        let twice = read(&(named("Coast") + &named("COAST"))).unwrap_err();
        assert!(twice.contains("`place[1].name`") && twice.contains("a name that no place before has"), "{twice}");
        let inline = format!("place = []\n{}", bare());
        assert!(Recipe::from_toml(&inline, "tiny.toml", Path::new("")).is_ok());
        let inline = inline.replace(
            "[]",
            "[{ name = \"A\", latitude_deg = 1, longitude_deg = 1, altitude_m = 1, heading_deg = 1, pitch_deg = 1 }]",
        );
        let error = Recipe::from_toml(&inline, "tiny.toml", Path::new("")).unwrap_err().to_string();
        assert!(error.contains("found 1 tables and 0 lines [[place]]"), "{error}");
    }

    #[test]
    fn names_may_be_short_and_are_listed_where_they_fail() {
        let recipe = read(&["Coast", "Coastal hills", "Mountains"].map(named).concat()).unwrap();
        let found = |name: &str| recipe.place(name).map(|place| place.name.as_str()).map_err(|error| error.to_string());
        assert_eq!([found("coast"), found("COASTAL"), found("m")], [Ok("Coast"), Ok("Coastal hills"), Ok("Mountains")]);
        assert_eq!(found("co").unwrap_err(), "no one place 'co' on Tiny, expected the beginning of one of: Coast, Coastal hills");
        assert!(found("sea").unwrap_err().ends_with("one of: Coast, Coastal hills, Mountains"));
        assert!(read("").unwrap().place("coast").unwrap_err().to_string().contains("its recipe lists none"));
    }

    #[test]
    fn places_leave_the_text_that_decides_the_ground() {
        let recipe = read(&(named("A") + "# a remark\n" + &named("B"))).unwrap();
        assert_eq!((recipe.places.len(), ground_text(&recipe.text)), (2, Cow::from(bare())));
        // Edits come after places, and after text without places, and are the same.
        let shape = Shape::Raise { by_m: 3.0 };
        let edit = Edit { latitude_deg: 1.0, longitude_deg: 2.0, radius_m: 50.0, shape };
        let edited = recipe.with_edit(&edit).unwrap();
        assert_eq!(ground_text(&edited.text), read("").unwrap().with_edit(&edit).unwrap().text);
        assert_eq!(edited.without_last_edit().unwrap().unwrap().text, recipe.text);
        // What comes after them is not theirs.
        assert_eq!(ground_text(&(recipe.text.clone() + "\n# changed\n")), bare() + "\n# changed\n");
        // Places amidst the text go, and what is around them stays.
        let (head, tail) = TINY.split_at(TINY.find("\n[atmosphere]").unwrap());
        let amidst = format!("{head}{}{tail}", named("C"));
        assert_eq!(ground_text(&amidst), ground_text(TINY));
        assert!(!ground_text(&amidst.replace("seed = 7", "seed = 8")).eq(&ground_text(TINY)));
    }
}
