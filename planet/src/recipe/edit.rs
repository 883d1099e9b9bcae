//! Edits: places where the ground is changed after all layers, in order. In: one `[[edit]]` table, or numbers. Out: a checked
//! [`Edit`], and the text that appends it to a recipe. What each one looks like is in `recipes/README.md`.

use super::error::RecipeError;
use super::reader::Reader;
use std::fmt;
use std::ops::RangeInclusive;

/// Smallest radius of an edit, in metres: a few lattice units on the largest planet.
const LEAST_RADIUS_M: f64 = 0.1;

/// Depths and heights, in metres.
const HEIGHTS_M: RangeInclusive<f64> = -1e5..=1e5;

/// What an edit does to the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// An impact crater. The radius is that of its rim; its ejecta end at [`Edit::REACH`] radii.
    Crater {
        /// Metres of its floor below the ground before (0.001 to 100000). The rim rises by a quarter of that.
        depth_m: f64,
    },
    /// A level place, with a smooth shoulder in the outer quarter of the radius.
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

impl Shape {
    /// Name, key, value and range of the one number that each shape has.
    fn measure(self) -> (&'static str, &'static str, f64, RangeInclusive<f64>) {
        match self {
            Self::Crater { depth_m } => ("crater", "depth_m", depth_m, 0.001..=1e5),
            Self::Flatten { height_m } => ("flatten", "height_m", height_m, HEIGHTS_M),
            Self::Raise { by_m } => ("raise", "by_m", by_m, HEIGHTS_M),
        }
    }

    /// Its name in recipes.
    pub fn name(self) -> &'static str {
        self.measure().0
    }

    /// Key and value of its number.
    pub fn number(self) -> (&'static str, f64) {
        let (_, key, value, _) = self.measure();
        (key, value)
    }
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

    fn numbers(&self, planet_m: f64) -> [(&'static str, f64, RangeInclusive<f64>); 4] {
        let (_, key, value, range) = self.shape.measure();
        [
            ("latitude_deg", self.latitude_deg, -90.0..=90.0),
            ("longitude_deg", self.longitude_deg, -180.0..=180.0),
            // The reach is at most a planet's radius, so that chords still tell near from far.
            ("radius_m", self.radius_m, LEAST_RADIUS_M..=planet_m / Self::REACH),
            (key, value, range),
        ]
    }

    /// Checks all numbers for a planet of `planet_m` metres radius.
    ///
    /// # Errors
    /// Names the first that is out of range; a NaN is in no range.
    pub fn check(&self, planet_m: f64) -> Result<(), EditRange> {
        let wrong = self.numbers(planet_m).into_iter().find(|(_, found, range)| !range.contains(found));
        wrong.map_or(Ok(()), |(key, found, range)| Err(EditRange { key, found, range }))
    }

    pub(super) fn read(reader: &Reader<'_>, planet_m: f64) -> Result<Self, RecipeError> {
        let kinds = "an edit: crater, flatten, raise";
        let kind = reader.string("kind", kinds)?;
        // Numbers that are still to be read are NaN.
        let shape = match kind.as_str() {
            "crater" => Shape::Crater { depth_m: f64::NAN },
            "flatten" => Shape::Flatten { height_m: f64::NAN },
            "raise" => Shape::Raise { by_m: f64::NAN },
            other => return Err(reader.wrong("kind", reader.line_of("kind"), format!("string \"{other}\""), kinds)),
        };
        let unread = Edit { latitude_deg: f64::NAN, longitude_deg: f64::NAN, radius_m: f64::NAN, shape };
        let mut read = [0.0; 4];
        for (read, (key, _, range)) in read.iter_mut().zip(unread.numbers(planet_m)) {
            *read = reader.number(key, range)?;
        }
        reader.finish()?;
        let [latitude_deg, longitude_deg, radius_m, value] = read;
        let shape = match shape {
            Shape::Crater { .. } => Shape::Crater { depth_m: value },
            Shape::Flatten { .. } => Shape::Flatten { height_m: value },
            Shape::Raise { .. } => Shape::Raise { by_m: value },
        };
        Ok(Edit { latitude_deg, longitude_deg, radius_m, shape })
    }

    /// The text that appends this edit to a recipe, whatever the recipe ends with. Reading it gives the same edit, so the very text
    /// can be found again and taken away.
    pub(super) fn text(&self) -> String {
        let (kind, key, value, _) = self.shape.measure();
        let Edit { latitude_deg, longitude_deg, radius_m, .. } = self;
        format!(
            "\n[[edit]]\nkind = \"{kind}\"\nlatitude_deg = {latitude_deg:?}\nlongitude_deg = {longitude_deg:?}\n\
             radius_m = {radius_m:?}\n{key} = {value:?}\n"
        )
    }
}

impl fmt::Display for Edit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Edit { latitude_deg, longitude_deg, radius_m, shape } = self;
        write!(f, "{} at {latitude_deg}, {longitude_deg}, radius {radius_m} m, ", shape.name())?;
        match shape {
            Shape::Crater { depth_m } => write!(f, "{depth_m} m deep"),
            Shape::Flatten { height_m } => write!(f, "to {height_m} m above the datum"),
            Shape::Raise { by_m } => write!(f, "by {by_m} m"),
        }
    }
}
