//! The layers a terrain is composed of, in order, and their parameters with units and ranges. In: one `[[layer]]` table.
//! Out: a checked [`Layer`]. What each layer looks like is in `recipes/README.md`.
//!
//! A kind of layer is a line of [`layer_kinds`] and two files of the same name: its parameters here, its ground in `terrain/`.

mod canyons;
mod caps;
mod craters;
mod dry;
mod dunes;
mod heightmap;
mod imagery;
mod lava;
mod relief;
mod rift;
mod seabed;
mod shield;

pub use canyons::Canyons;
pub use caps::Caps;
pub use craters::Craters;
pub use dry::Dry;
pub use dunes::Dunes;
pub use heightmap::{HeightScale, Heightmap, Placement};
pub use imagery::{Imagery, PictureFile};
pub use lava::Lava;
pub use relief::{Continents, Hills, Mountains, Plains};
pub use rift::Rift;
pub use seabed::Seabed;
pub use shield::Shield;

use super::error::RecipeError;
use super::reader::Reader;
use std::ops::RangeInclusive;

/// The kinds of layers, in the order in which messages list them: type, name in recipes, and the file of the same name in this folder and in
/// `terrain/`. Hands the list to a macro.
macro_rules! layer_kinds {
    ($apply:ident) => {
        $apply! {
            /// Oceans and continents.
            Continents = "continents" in relief;
            /// Mountain ranges.
            Mountains = "mountains" in relief;
            /// Hills, mounds, gullies.
            Hills = "hills" in relief;
            /// Gentle relief.
            Plains = "plains" in relief;
            /// Impact craters.
            Craters = "craters" in craters;
            /// Valleys with walls.
            Canyons = "canyons" in canyons;
            /// Dunes and ripples.
            Dunes = "dunes" in dunes;
            /// Plains of lava.
            Lava = "lava" in lava;
            /// Polar caps.
            Caps = "caps" in caps;
            /// A volcano.
            Shield = "shield" in shield;
            /// A rift valley.
            Rift = "rift" in rift;
            /// A heightfield file.
            Heightmap = "heightmap" in heightmap;
            /// A picture of the ground.
            Imagery = "imagery" in imagery;
            /// Coasts and a sea floor from a picture.
            Seabed = "seabed" in seabed;
            /// An area without sea.
            Dry = "dry" in dry;
        }
    };
}
pub(crate) use layer_kinds;

macro_rules! layers {
    ($($(#[$meta:meta])* $kind:ident = $name:literal in $file:ident;)*) => {
        /// One layer of the terrain.
        #[derive(Clone, Debug)]
        pub enum Layer {
            $($(#[$meta])* $kind($file::$kind),)*
        }

        impl Layer {
            /// Names of the kinds in recipes.
            const NAMES: &'static [&'static str] = &[$($name),*];

            pub(super) fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
                let kinds = format!("a layer kind: {}", Self::NAMES.join(", "));
                let kind = reader.string("kind", &kinds)?;
                let layer = match kind.as_str() {
                    $($name => Self::$kind($file::$kind::read(reader, radius)?),)*
                    other => return Err(reader.wrong_name("kind", other, &kinds)),
                };
                reader.finish()?;
                Ok(layer)
            }
        }
    };
}

layer_kinds!(layers);

/// Parameters of a kind of layer.
trait ReadLayer: Sized {
    /// Reads all its keys from the table of a layer of a planet of some radius in metres.
    fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError>;
}

const METRES: RangeInclusive<f64> = 0.0..=100_000.0;
/// Longest and shortest wavelength of a noise octave, in metres. 0.25 m on the largest radius keeps cells below 2^30.
const WAVELENGTH: RangeInclusive<f64> = 0.25..=1e8;
const UNIT: RangeInclusive<f64> = 0.0..=1.0;

/// A run of noise octaves, each half (nearly) as long as the one before.
#[derive(Clone, Debug)]
pub struct Octaves {
    /// Wavelength of the first octave, in metres (0.25 to 1e8).
    pub wavelength_m: f64,
    /// No octave is shorter than this, in metres (0.25 to 1e8; default 1).
    pub detail_m: f64,
    /// Amplitude of each octave relative to the one before (0.2 to 0.8). 0.5 is H = 1, 0.57 about H = 0.8.
    pub gain: f64,
}

impl Octaves {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let wavelength_m = reader.number("wavelength_m", WAVELENGTH)?;
        let detail_m = reader.number_or("detail_m", *WAVELENGTH.start()..=wavelength_m, wavelength_m.min(1.0))?;
        Ok(Self { wavelength_m, detail_m, gain: reader.number("gain", 0.2..=0.8)? })
    }
}

/// The part of the planet where a layer shows.
#[derive(Clone, Debug)]
pub struct Regions {
    /// Typical size of a region, in metres.
    pub region_m: f64,
    /// Share of the planet in such regions, about (0 to 1; default 0.5).
    pub cover: f64,
    /// Where the layer fades in, in metres of base elevation.
    pub above_m: [f64; 2],
}

impl Regions {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            region_m: reader.number("region_m", WAVELENGTH)?,
            cover: reader.number_or("cover", UNIT, 0.5)?,
            above_m: read_above(reader)?,
        })
    }
}

/// Everywhere, where the key is missing: no base elevation is this low.
fn read_above(reader: &Reader<'_>) -> Result<[f64; 2], RecipeError> {
    if reader.has("above_m") {
        reader.span("above_m", -1e5..=1e5)
    } else {
        Ok([-3e5, -2e5])
    }
}
