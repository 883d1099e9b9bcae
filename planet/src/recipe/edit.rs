//! Edits: sites where the ground is changed after all layers, in order. In: one `[[edit]]` table, or numbers. Out: a checked
//! [`Edit`], and the text that appends it to a recipe. What each one looks like is in `recipes/README.md`.

use super::error::RecipeError;
use super::reader::Reader;
use std::fmt;
use std::ops::RangeInclusive;

/// Smallest radius of an edit, in metres: a few lattice units on the largest planet.
const LEAST_RADIUS_M: f64 = 0.1;

const LATITUDES: RangeInclusive<f64> = -90.0..=90.0;
const LONGITUDES: RangeInclusive<f64> = -180.0..=180.0;

/// Depths, in metres.
const DEPTHS_M: RangeInclusive<f64> = 0.001..=1e5;

/// Heights, in metres.
const HEIGHTS_M: RangeInclusive<f64> = -1e5..=1e5;

/// What an edit does to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// An impact crater. The radius is that of its rim; its ejecta end at [`Edit::REACH`] radii.
    Crater {
        /// Metres of its floor below the ground before (0.001 to 100000). The rim rises by a quarter of that.
        depth_m: f64,
        /// Metres above the datum (-100000 to 100000) that the ground within the rim is levelled to, most in the middle, before the
        /// crater is dug: an impact leaves no old relief. Without it the old relief shows through.
        ground_m: Option<f64>,
    },
    /// A level site, with a smooth shoulder in the outer quarter of the radius.
    Flatten {
        /// Metres above the datum (-100000 to 100000).
        height_m: f64,
    },
    /// A mound (or a hollow), highest in the middle and nothing at the radius.
    Raise {
        /// Metres in the middle (-100000 to 100000).
        by_m: f64,
    },
}

/// One edit of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edit {
    /// Latitude of the middle, in degrees (-90 to 90).
    pub latitude_deg: f64,
    /// Longitude of the middle, in degrees (-180 to 180).
    pub longitude_deg: f64,
    /// Radius on the ground in metres (0.1 to a third of the planet's radius).
    pub radius_m: f64,
    /// What happens there.
    pub shape: Shape,
}

/// A number of an edit that is out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}`: found {found}, expected a number from {} to {}", range.start(), range.end())]
pub struct EditRange {
    /// Its key in the recipe.
    pub key: &'static str,
    /// What it is.
    pub found: f64,
    /// What it may be.
    pub range: RangeInclusive<f64>,
}

/// A key, its value and its range.
type Number = (&'static str, f64, RangeInclusive<f64>);

impl Shape {
    /// Its name in recipes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Crater { .. } => "crater",
            Self::Flatten { .. } => "flatten",
            Self::Raise { .. } => "raise",
        }
    }

    fn numbers(self) -> Vec<Number> {
        match self {
            Self::Crater { depth_m, ground_m } => {
                let ground = ground_m.map(|ground_m| ("ground_m", ground_m, HEIGHTS_M));
                [("depth_m", depth_m, DEPTHS_M)].into_iter().chain(ground).collect()
            }
            Self::Flatten { height_m } => vec![("height_m", height_m, HEIGHTS_M)],
            Self::Raise { by_m } => vec![("by_m", by_m, HEIGHTS_M)],
        }
    }

    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let kinds = "an edit: crater, flatten, raise";
        match reader.string("kind", kinds)?.as_str() {
            "crater" => Ok(Self::Crater {
                depth_m: reader.number("depth_m", DEPTHS_M)?,
                ground_m: reader.has("ground_m").then(|| reader.number("ground_m", HEIGHTS_M)).transpose()?,
            }),
            "flatten" => Ok(Self::Flatten { height_m: reader.number("height_m", HEIGHTS_M)? }),
            "raise" => Ok(Self::Raise { by_m: reader.number("by_m", HEIGHTS_M)? }),
            other => Err(reader.wrong_name("kind", other, kinds)),
        }
    }
}

/// The radius must be at most so many metres: so that the reach is at most a planet's radius and chords tell near from far.
fn radii(planet_m: f64) -> RangeInclusive<f64> {
    LEAST_RADIUS_M..=planet_m / Edit::REACH
}

impl Edit {
    /// Farthest that a crater changes the ground, in rim radii.
    pub const REACH: f64 = 3.0;

    /// Distance from the middle in metres past which no bit of the ground changes.
    pub fn reach_m(&self) -> f64 {
        match self.shape {
            Shape::Crater { .. } => Self::REACH * self.radius_m,
            Shape::Flatten { .. } | Shape::Raise { .. } => self.radius_m,
        }
    }

    /// Keys and values as in recipes.
    pub fn numbers(&self) -> Vec<(&'static str, f64)> {
        self.ranges(f64::MAX).into_iter().map(|(key, value, _)| (key, value)).collect()
    }

    fn ranges(&self, planet_m: f64) -> Vec<Number> {
        let site = [
            ("latitude_deg", self.latitude_deg, LATITUDES),
            ("longitude_deg", self.longitude_deg, LONGITUDES),
            ("radius_m", self.radius_m, radii(planet_m)),
        ];
        site.into_iter().chain(self.shape.numbers()).collect()
    }

    /// Checks all numbers for a planet of `planet_m` metres radius.
    ///
    /// # Errors
    /// Names the first that is out of range; a NaN is in no range.
    pub fn check(&self, planet_m: f64) -> Result<(), EditRange> {
        let wrong = self.ranges(planet_m).into_iter().find(|(_, found, range)| !range.contains(found));
        wrong.map_or(Ok(()), |(key, found, range)| Err(EditRange { key, found, range }))
    }

    pub(super) fn read(reader: &Reader<'_>, planet_m: f64) -> Result<Self, RecipeError> {
        let edit = Edit {
            shape: Shape::read(reader)?,
            latitude_deg: reader.number("latitude_deg", LATITUDES)?,
            longitude_deg: reader.number("longitude_deg", LONGITUDES)?,
            radius_m: reader.number("radius_m", radii(planet_m))?,
        };
        reader.finish()?;
        Ok(edit)
    }

    /// The text that appends this edit to a recipe, whatever the recipe ends with. Reading it gives the same edit, so the very text
    /// can be found again and taken away.
    pub(super) fn text(&self) -> String {
        let numbers: String = self.numbers().iter().map(|(key, value)| format!("{key} = {value:?}\n")).collect();
        format!("\n[[edit]]\nkind = \"{}\"\n{numbers}", self.shape.name())
    }
}

impl fmt::Display for Edit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Edit { latitude_deg, longitude_deg, radius_m, shape } = self;
        write!(f, "{} at {latitude_deg}, {longitude_deg}, radius {radius_m} m, ", shape.name())?;
        match shape {
            Shape::Crater { depth_m, .. } => write!(f, "{depth_m} m deep"),
            Shape::Flatten { height_m } => write!(f, "to {height_m} m above the datum"),
            Shape::Raise { by_m } => write!(f, "by {by_m} m"),
        }
    }
}
