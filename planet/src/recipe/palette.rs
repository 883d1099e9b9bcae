//! Ground colours of a recipe and the thresholds between them. In: the `[palette]` table. Out: a checked [`Palette`].
//! Colours are sRGB-encoded, 0 to 255 a channel.

use super::error::RecipeError;
use super::reader::Reader;

/// An sRGB-encoded colour, each channel 0 to 255.
pub type Colour = [f64; 3];

/// Colours of a world with climate: vegetation, deserts, snow.
#[derive(Clone, Debug)]
pub struct Living {
    /// Sea floor just below the waves.
    pub shelf: Colour,
    /// Deep sea floor.
    pub abyss: Colour,
    /// Sand along the coast.
    pub beach: Colour,
    /// Wet grassland.
    pub lush: Colour,
    /// Dry grassland and steppe.
    pub dry: Colour,
    /// Forest.
    pub forest: Colour,
    /// Sand desert.
    pub desert: Colour,
    /// Stony, redder desert.
    pub badland: Colour,
    /// Tundra and alpine meadow.
    pub tundra: Colour,
    /// Bare rock.
    pub rock: Colour,
    /// Snow and ice.
    pub snow: Colour,
    /// Beaches reach this high above the sea, in metres (0 to 1000).
    pub beach_m: f64,
    /// Snow line at the equator, in metres above `radius` (0 to 100000).
    pub snow_line_m: f64,
    /// How far the tree line lies below the snow line, in metres (0 to 100000).
    pub tree_drop_m: f64,
    /// Latitude where the snow line comes down to 0 m, in degrees (1 to 90).
    pub polar_deg: f64,
    /// Slopes (tangent of the angle) over which soil gives way to rock.
    pub rock_slope: [f64; 2],
    /// Size of climate regions, in metres.
    pub climate_m: f64,
    /// Size of the largest colour patches (woods, meadows), in metres.
    pub patch_m: f64,
}

/// Colours of a world without air.
#[derive(Clone, Debug)]
pub struct Airless {
    /// Bright old highlands.
    pub highland: Colour,
    /// Dark lava plains.
    pub mare: Colour,
    /// Fresh ejecta: rays.
    pub ray: Colour,
    /// Base elevations over which mare gives way to highland, in metres.
    pub mare_m: [f64; 2],
    /// Size of the largest colour patches, in metres.
    pub patch_m: f64,
}

/// Colours of a dry world with thin air: dust, sand, rock, polar ice.
#[derive(Clone, Debug)]
pub struct Desert {
    /// Bright dust that covers most of the ground.
    pub dust: Colour,
    /// Dark sand, in broad patches and streaks.
    pub sand: Colour,
    /// Dunes of the `dunes` layers.
    pub dune: Colour,
    /// Bare rock on slopes.
    pub rock: Colour,
    /// Paler beds in that rock, and pale dust.
    pub strata: Colour,
    /// Ice about the poles.
    pub ice: Colour,
    /// Latitude of the edge of the ice, in degrees (1 to 90; 90: none).
    pub ice_deg: f64,
    /// Share of the planet under dark sand, about (0 to 1; default 0.3).
    pub sand_cover: f64,
    /// Thickness of strata, in metres (0.1 to 1e5; default 40).
    pub strata_m: f64,
    /// Slopes (tangent of the angle) over which dust gives way to rock.
    pub rock_slope: [f64; 2],
    /// Size of the regions of dark sand, in metres.
    pub climate_m: f64,
    /// Size of the largest colour patches within them, in metres.
    pub patch_m: f64,
}

/// Ground colours.
#[derive(Clone, Debug)]
pub enum Palette {
    /// A world with climate.
    Living(Box<Living>),
    /// A world without air.
    Airless(Airless),
    /// A dry world with thin air.
    Desert(Box<Desert>),
}

impl Palette {
    pub(crate) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let kinds = "a palette kind: living, airless, desert";
        let kind = reader.string("kind", kinds)?;
        let palette = match kind.as_str() {
            "living" => Self::Living(Box::new(Living::read(reader)?)),
            "airless" => Self::Airless(Airless::read(reader)?),
            "desert" => Self::Desert(Box::new(Desert::read(reader)?)),
            other => return Err(reader.wrong_name("kind", other, kinds)),
        };
        reader.finish()?;
        Ok(palette)
    }
}

fn colour(reader: &Reader<'_>, key: &'static str) -> Result<Colour, RecipeError> {
    reader.numbers(key, 0.0..=255.0)
}

impl Living {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            shelf: colour(reader, "shelf")?,
            abyss: colour(reader, "abyss")?,
            beach: colour(reader, "beach")?,
            lush: colour(reader, "lush")?,
            dry: colour(reader, "dry")?,
            forest: colour(reader, "forest")?,
            desert: colour(reader, "desert")?,
            badland: colour(reader, "badland")?,
            tundra: colour(reader, "tundra")?,
            rock: colour(reader, "rock")?,
            snow: colour(reader, "snow")?,
            beach_m: reader.number("beach_m", 0.0..=1000.0)?,
            snow_line_m: reader.number("snow_line_m", 0.0..=1e5)?,
            tree_drop_m: reader.number("tree_drop_m", 0.0..=1e5)?,
            polar_deg: reader.number("polar_deg", 1.0..=90.0)?,
            rock_slope: reader.span("rock_slope", 0.0..=100.0)?,
            climate_m: reader.number("climate_m", 100.0..=1e8)?,
            patch_m: reader.number("patch_m", 100.0..=1e8)?,
        })
    }
}

impl Airless {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            highland: colour(reader, "highland")?,
            mare: colour(reader, "mare")?,
            ray: colour(reader, "ray")?,
            mare_m: reader.span("mare_m", -1e5..=1e5)?,
            patch_m: reader.number("patch_m", 100.0..=1e8)?,
        })
    }
}

impl Desert {
    fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            dust: colour(reader, "dust")?,
            sand: colour(reader, "sand")?,
            dune: colour(reader, "dune")?,
            rock: colour(reader, "rock")?,
            strata: colour(reader, "strata")?,
            ice: colour(reader, "ice")?,
            ice_deg: reader.number("ice_deg", 1.0..=90.0)?,
            sand_cover: reader.number_or("sand_cover", 0.0..=1.0, 0.3)?,
            strata_m: reader.number_or("strata_m", 0.1..=1e5, 40.0)?,
            rock_slope: reader.span("rock_slope", 0.0..=100.0)?,
            climate_m: reader.number("climate_m", 100.0..=1e8)?,
            patch_m: reader.number("patch_m", 100.0..=1e8)?,
        })
    }
}
