//! The ground of a planet as GeoTIFF, so that GIS sees it: heights as Float32, or albedo as RGB, on a grid of latitude and longitude.
//!
//! In: a planet and a [`GroundGrid`]. Out: the bytes of a file whose geographic keys (OGC GeoTIFF 1.1) name a user-defined datum on a
//! sphere of the planet's radius. Samples are points. Heights are metres above the datum, bare of the sea.

use crate::globe::sphere::direction_at;
use crate::ground::{GroundColour, GroundPoint};
use crate::planet::Planet;
use glam::DVec3;
use std::io::Cursor;
use thiserror::Error;
use tiff::encoder::colortype::{ColorType, Gray32Float, RGB8};
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, TiffValue};
use tiff::tags::Tag;
use tiff::TiffError;

/// Most samples of a raster: 1 GiB of heights and of what is in progress.
pub const MOST_RASTER_SAMPLES: u64 = 1 << 27;

/// Nearest to a pole, in degrees, that a grid may reach: there meridians meet, and steps of longitude are worth nothing.
const POLE: f64 = 89.9;

/// Why there is no raster.
#[derive(Debug, Error)]
pub enum RasterError {
    /// Too many samples, or too few.
    #[error("{0} x {1} samples, expected sides of 2 or more and at most {MOST_RASTER_SAMPLES} samples; ask for fewer, or for several rasters")]
    Size(u32, u32),
    /// A grid over a pole, or more than once around.
    #[error("the grid reaches from latitude {south:.3} to {north:.3} and over {width:.3} degrees of longitude, expected within -{POLE} \
             and {POLE} and at most 360; take a smaller --size or --spacing, or a site farther from the pole")]
    Reach {
        /// Its southern edge in degrees.
        south: f64,
        /// Its northern edge.
        north: f64,
        /// Degrees of longitude.
        width: f64,
    },
    /// A file that cannot be made.
    #[error("cannot encode the GeoTIFF: {0}; please report this")]
    Encode(#[from] TiffError),
}

/// Where samples lie: rows from the north, columns from the west.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundGrid {
    /// Samples from west to east.
    pub columns: u32,
    /// Samples from north to south.
    pub rows: u32,
    /// Longitude of the first column in degrees.
    pub west: f64,
    /// Latitude of the first row in degrees.
    pub north: f64,
    /// Degrees between columns.
    pub step_east: f64,
    /// Degrees between rows.
    pub step_south: f64,
    /// Metres between samples at the middle.
    pub spacing: f64,
}

impl GroundGrid {
    /// A grid around a site in degrees, with samples so many metres apart at its middle, on a sphere of a radius in metres.
    ///
    /// # Errors
    /// For more than [`MOST_RASTER_SAMPLES`], and for a grid that reaches a pole or meets itself.
    pub fn around(
        [latitude, longitude]: [f64; 2],
        [columns, rows]: [u32; 2],
        spacing: f64,
        radius: f64,
    ) -> Result<Self, RasterError> {
        if columns < 2 || rows < 2 || u64::from(columns) * u64::from(rows) > MOST_RASTER_SAMPLES {
            return Err(RasterError::Size(columns, rows));
        }
        let step_south = (spacing / radius).to_degrees();
        let step_east = step_south / latitude.to_radians().cos();
        let half = |count: u32, step: f64| 0.5 * f64::from(count - 1) * step;
        let (north, south) = (latitude + half(rows, step_south), latitude - half(rows, step_south));
        let width = 2.0 * half(columns, step_east);
        if !(north <= POLE && south >= -POLE && width <= 360.0) {
            return Err(RasterError::Reach { south, north, width });
        }
        Ok(GroundGrid { columns, rows, west: longitude - 0.5 * width, north, step_east, step_south, spacing })
    }

    /// Directions of a row, from one column before the first to one after the last.
    fn directions(&self, row: i64) -> Vec<DVec3> {
        let latitude = self.north - row as f64 * self.step_south;
        (-1..=i64::from(self.columns)).map(|c| direction_at(latitude, self.west + c as f64 * self.step_east)).collect()
    }
}

/// Heights of a row in metres, with one more at both ends.
fn heights(planet: &Planet, grid: &GroundGrid, row: i64) -> Vec<f64> {
    planet.ground().metres(&grid.directions(row))
}

/// Heights of some rows, in metres above the datum.
pub fn height_rows(planet: &Planet, grid: &GroundGrid, rows: std::ops::Range<u32>) -> Vec<f32> {
    let row = |row| heights(planet, grid, i64::from(row)).into_iter().skip(1).take(grid.columns as usize);
    rows.flat_map(row).map(|h| h as f32).collect()
}

/// sRGB-encoded albedo of some rows, three bytes a sample.
pub fn albedo_rows(planet: &Planet, grid: &GroundGrid, rows: std::ops::Range<u32>) -> Vec<u8> {
    let mut around: Vec<Vec<f64>> =
        (i64::from(rows.start) - 1..=i64::from(rows.start)).map(|r| heights(planet, grid, r)).collect();
    let mut colours = Vec::new();
    for row in rows {
        around.push(heights(planet, grid, i64::from(row) + 1));
        let [above, here, below] = [0, 1, 2].map(|k| &around[around.len() - 3 + k]);
        let directions = grid.directions(i64::from(row));
        let metres_north = 2.0 * grid.spacing;
        let shrink = directions[0].truncate().length() / direction_at(grid.middle(), 0.0).truncate().length();
        let point = |c: usize| {
            let east = (here[c + 1] - here[c - 1]) / (2.0 * grid.spacing * shrink);
            let north = (above[c] - below[c]) / metres_north;
            GroundPoint { direction: directions[c], height: here[c], slope: east.hypot(north), north, spacing: grid.spacing }
        };
        let points: Vec<GroundPoint> = (1..=grid.columns as usize).map(point).collect();
        let mut row = vec![[0; 3]; points.len()];
        GroundColour::albedo(&planet.terrain, &points, &mut row);
        colours.extend(row.into_iter().flatten());
        around.remove(0);
    }
    colours
}

impl GroundGrid {
    /// Latitude of the middle in degrees.
    fn middle(&self) -> f64 {
        self.north - 0.5 * f64::from(self.rows - 1) * self.step_south
    }
}

/// The file of heights, row by row.
///
/// # Errors
/// If it cannot be encoded.
pub fn height_file(planet: &Planet, grid: &GroundGrid, heights: &[f32]) -> Result<Vec<u8>, RasterError> {
    encode::<Gray32Float>(planet, grid, heights)
}

/// The file of an albedo, row by row.
///
/// # Errors
/// If it cannot be encoded.
pub fn albedo_file(planet: &Planet, grid: &GroundGrid, albedo: &[u8]) -> Result<Vec<u8>, RasterError> {
    encode::<RGB8>(planet, grid, albedo)
}

fn encode<C: ColorType>(planet: &Planet, grid: &GroundGrid, samples: &[C::Inner]) -> Result<Vec<u8>, RasterError>
where
    [C::Inner]: TiffValue,
{
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file)?.with_compression(Compression::Deflate(DeflateLevel::Balanced));
    let mut image = encoder.new_image::<C>(grid.columns, grid.rows)?;
    let directory = image.encoder();
    directory.write_tag(Tag::ModelPixelScaleTag, &[grid.step_east, grid.step_south, 0.0][..])?;
    directory.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, grid.west, grid.north, 0.0][..])?;
    let name = citation(planet);
    directory.write_tag(Tag::GeoKeyDirectoryTag, &keys(name.len() as u16)[..])?;
    directory.write_tag(Tag::GeoDoubleParamsTag, &[planet.recipe.radius, planet.recipe.radius][..])?;
    directory.write_tag(Tag::GeoAsciiParamsTag, name.as_str())?;
    image.write_data(samples)?;
    Ok(file.into_inner())
}

/// The name of the coordinate system, ended as the keys want it.
fn citation(planet: &Planet) -> String {
    let plain: String = planet.recipe.name.chars().filter(|c| c.is_ascii_alphanumeric() || *c == ' ').collect();
    format!("{plain} sphere|")
}

/// The directory of geographic keys: degrees on a user-defined sphere, heights in metres, samples that are points.
fn keys(name_length: u16) -> Vec<u16> {
    const DOUBLES: u16 = 34_736;
    const ASCII: u16 = 34_737;
    const USER_DEFINED: u16 = 32_767;
    let entries: [[u16; 4]; 10] = [
        [1024, 0, 1, 2],               // model: geographic
        [1025, 0, 1, 2],               // raster: points
        [2048, 0, 1, USER_DEFINED],    // geographic system
        [2049, ASCII, name_length, 0], // its name
        [2050, 0, 1, USER_DEFINED],    // datum
        [2051, 0, 1, 8901],            // prime meridian: as Greenwich
        [2054, 0, 1, 9102],            // degrees
        [2056, 0, 1, USER_DEFINED],    // ellipsoid
        [2057, DOUBLES, 1, 0],         // semi-major axis
        [2058, DOUBLES, 1, 1],         // semi-minor axis
    ];
    let head = [1, 1, 0, entries.len() as u16];
    head.into_iter().chain(entries.into_iter().flatten()).collect()
}
