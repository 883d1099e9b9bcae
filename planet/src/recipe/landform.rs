//! Landforms of dry worlds and their parameters with units and ranges: canyons, dunes, lava, polar caps, and landmarks that have their
//! place in the recipe: shield volcanoes and rifts. In: one
//! `[[layer]]` table. Out: the checked layer.

use super::error::RecipeError;
use super::layer::{read_above, Octaves, METRES, UNIT, WAVELENGTH};
use super::reader::Reader;

/// Valleys with walls, floors and side valleys, in part of the planet.
#[derive(Clone, Debug)]
pub struct Canyons {
    /// Octaves of the network: the first sets how far apart the main canyons are, the others their side valleys.
    pub octaves: Octaves,
    /// Depth of the floor below the ground around, in metres.
    pub depth_m: f64,
    /// How far the network is pushed about, in metres (0 to 1e6; default 0).
    pub warp_m: f64,
    /// Width from rim to rim (0.02 to 0.9): the share of the network's noise that lies within the rims.
    pub width: f64,
    /// Share of the width that is walls, and not floor (0.05 to 1; default 0.5).
    pub wall: f64,
    /// How much the walls are stairs, and not slopes (0 to 1; default 0.5).
    pub ledges: f64,
    /// Typical size of a region with canyons, in metres.
    pub region_m: f64,
    /// Share of the planet with canyons, about (0 to 1; default 0.5).
    pub cover: f64,
    /// Where canyons fade in, in metres of base elevation.
    pub above_m: [f64; 2],
}

/// Dunes or ripples across one wind, in part of the planet.
#[derive(Clone, Debug)]
pub struct Dunes {
    /// Distance from crest to crest, in metres (0.25 to 1e8).
    pub wavelength_m: f64,
    /// Height of the highest crests, in metres.
    pub amplitude_m: f64,
    /// Typical size of a dune field, in metres.
    pub region_m: f64,
    /// Share of the planet under dunes, about (0 to 1; default 0.5).
    pub cover: f64,
    /// Where dunes fade in, in metres of base elevation.
    pub above_m: [f64; 2],
}

/// Lava that fills low ground up to one level. It counts as base elevation.
#[derive(Clone, Debug)]
pub struct Lava {
    /// Level of the lava, in metres of base elevation.
    pub level_m: f64,
    /// Height over which the ground bends into the plain, in metres (1 to 100000; default 100).
    pub shore_m: f64,
    /// Height of wrinkle ridges, in metres (default 0: none).
    pub ridge_m: f64,
    /// Typical distance between them, in metres (default 100000).
    pub ridge_apart_m: f64,
}

/// Domes of ice about both poles, with spiral troughs.
#[derive(Clone, Debug)]
pub struct Caps {
    /// Latitude of their edge, in degrees (45 to 89).
    pub latitude_deg: f64,
    /// Height of the pole above the ground, in metres.
    pub height_m: f64,
    /// Depth of the deepest troughs, in metres.
    pub trough_m: f64,
    /// Distance from trough to trough, in metres (1000 to 1e6).
    pub apart_m: f64,
}

/// A shield volcano, or with neither scarp nor caldera a swell. It counts as base elevation.
#[derive(Clone, Debug)]
pub struct Shield {
    /// Latitude of the top, in degrees (-90 to 90).
    pub latitude_deg: f64,
    /// Longitude of the top, in degrees (-180 to 180).
    pub longitude_deg: f64,
    /// Distance of the foot from the top, in metres (1 to the planet's radius).
    pub radius_m: f64,
    /// Height of the top, in metres.
    pub height_m: f64,
    /// Share of the height that is a scarp at the foot (0 to 0.5; default 0).
    pub scarp: f64,
    /// Radius of the caldera, in metres (0 to half of `radius_m`; default 0: none).
    pub caldera_m: f64,
    /// Depth of the caldera, in metres (default 0).
    pub caldera_depth_m: f64,
}

/// A rift valley.
#[derive(Clone, Debug)]
pub struct Rift {
    /// Latitude of its middle, in degrees (-90 to 90).
    pub latitude_deg: f64,
    /// Longitude of its middle, in degrees (-180 to 180).
    pub longitude_deg: f64,
    /// Which way it runs, in degrees clockwise from north (-360 to 360).
    pub heading_deg: f64,
    /// Length from end to end, in metres (1 to the planet's radius and a half).
    pub length_m: f64,
    /// Width from rim to rim, in metres (1 to half of `length_m`).
    pub width_m: f64,
    /// Depth of the floor, in metres.
    pub depth_m: f64,
    /// How much the walls are stairs, and not slopes (0 to 1; default 0.3).
    pub ledges: f64,
}

impl Lava {
    pub(crate) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            level_m: reader.number("level_m", -1e5..=1e5)?,
            shore_m: reader.number_or("shore_m", 1.0..=1e5, 100.0)?,
            ridge_m: reader.number_or("ridge_m", METRES, 0.0)?,
            ridge_apart_m: reader.number_or("ridge_apart_m", WAVELENGTH, 1e5)?,
        })
    }
}

impl Caps {
    pub(crate) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            latitude_deg: reader.number("latitude_deg", 45.0..=89.0)?,
            height_m: reader.number("height_m", METRES)?,
            trough_m: reader.number_or("trough_m", METRES, 0.0)?,
            apart_m: reader.number_or("apart_m", 1e3..=1e6, 5e4)?,
        })
    }
}

impl Shield {
    pub(crate) fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let radius_m = reader.number("radius_m", 1.0..=radius)?;
        Ok(Self {
            latitude_deg: reader.number("latitude_deg", -90.0..=90.0)?,
            longitude_deg: reader.number("longitude_deg", -180.0..=180.0)?,
            radius_m,
            height_m: reader.number("height_m", METRES)?,
            scarp: reader.number_or("scarp", 0.0..=0.5, 0.0)?,
            caldera_m: reader.number_or("caldera_m", 0.0..=0.5 * radius_m, 0.0)?,
            caldera_depth_m: reader.number_or("caldera_depth_m", METRES, 0.0)?,
        })
    }
}

impl Rift {
    pub(crate) fn read(reader: &Reader<'_>, radius: f64) -> Result<Self, RecipeError> {
        let length_m = reader.number("length_m", 1.0..=1.5 * radius)?;
        Ok(Self {
            latitude_deg: reader.number("latitude_deg", -90.0..=90.0)?,
            longitude_deg: reader.number("longitude_deg", -180.0..=180.0)?,
            heading_deg: reader.number("heading_deg", -360.0..=360.0)?,
            length_m,
            width_m: reader.number("width_m", 1.0..=0.5 * length_m)?,
            depth_m: reader.number("depth_m", METRES)?,
            ledges: reader.number_or("ledges", UNIT, 0.3)?,
        })
    }
}

impl Canyons {
    pub(crate) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            octaves: Octaves::read(reader)?,
            depth_m: reader.number("depth_m", METRES)?,
            warp_m: reader.number_or("warp_m", 0.0..=1e6, 0.0)?,
            width: reader.number("width", 0.02..=0.9)?,
            wall: reader.number_or("wall", 0.05..=1.0, 0.5)?,
            ledges: reader.number_or("ledges", UNIT, 0.5)?,
            region_m: reader.number("region_m", WAVELENGTH)?,
            cover: reader.number_or("cover", UNIT, 0.5)?,
            above_m: read_above(reader)?,
        })
    }
}

impl Dunes {
    pub(crate) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        Ok(Self {
            wavelength_m: reader.number("wavelength_m", WAVELENGTH)?,
            amplitude_m: reader.number("amplitude_m", METRES)?,
            region_m: reader.number("region_m", WAVELENGTH)?,
            cover: reader.number_or("cover", UNIT, 0.5)?,
            above_m: read_above(reader)?,
        })
    }
}
