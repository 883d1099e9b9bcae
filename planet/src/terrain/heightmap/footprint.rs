//! Where a heightmap lies: which of its samples a direction falls on, and how much it counts there.
//!
//! In: unit directions. Out: column and row as fractions, and a weight that falls to 0 at the edge.

use super::globe::Globe;
use super::{projected, smoothstep};
use crate::recipe::Placement;
use std::f64::consts::PI;
use terrane_heightfield::angles::{atan2, sin_cos};
use terrane_heightfield::import::{GeographicGrid, Imported};

/// Share of a map's side over which it blends with the ground unless the recipe says otherwise.
const BLEND_SHARE: f64 = 0.1;

/// Largest extent of a map that lies where its file says, in degrees of latitude and of longitude.
const WIDEST_GRID_DEG: f64 = 90.0;

/// Its farthest latitude: nearer to the poles, columns of the same file lie too close together to blend evenly.
const FARTHEST_LATITUDE_DEG: f64 = 85.0;

/// Room in a grid's reach for rounding, in degrees.
const REACH_ROOM_DEG: f64 = 1e-6;

/// A position on a map.
pub(in crate::terrain) struct Spot {
    pub(in crate::terrain) column: f64,
    pub(in crate::terrain) row: f64,
    pub(in crate::terrain) weight: f64,
}

/// Where a map lies.
pub(in crate::terrain) enum Footprint {
    Planet(Globe),
    Rectangle(Rectangle),
    Grid(Grid),
}

/// What was found and what was expected.
pub(super) type Fault = (String, String);

impl Footprint {
    pub(in crate::terrain) fn new(image: &Imported, placement: &Placement, radius: f64) -> Result<Footprint, Fault> {
        match *placement {
            Placement::Planet => Globe::new(image).map(Footprint::Planet),
            Placement::File { blend_m } if image.grid.is_none() && image.georeference.is_some() => {
                projected::rectangle(image, blend_m, radius).map(Footprint::Rectangle)
            }
            Placement::File { blend_m } => Grid::new(image, blend_m, radius).map(Footprint::Grid),
            Placement::Local { latitude_deg, longitude_deg, width_m, heading_deg, blend_m } => {
                let frame = frame(latitude_deg, longitude_deg, heading_deg);
                Rectangle::new(image, frame, width_m, blend_m, radius).map(Footprint::Rectangle)
            }
        }
    }

    /// Whether the last column's neighbour is the first.
    pub(in crate::terrain) fn wraps(&self) -> bool {
        matches!(self, Footprint::Planet(_))
    }

    /// Metres on the planet between neighbouring rows, where the map says or the recipe; nothing for a map of the whole planet.
    pub(in crate::terrain) fn row_pitch_m(&self) -> Option<f64> {
        match self {
            Footprint::Planet(_) => None,
            Footprint::Rectangle(rectangle) => Some(2.0 * rectangle.half_m[1] / rectangle.size[1]),
            Footprint::Grid(grid) => Some(grid.spacing_m[1]),
        }
    }

    /// The position on the map, if the direction falls on it.
    pub(in crate::terrain) fn locate(&self, d: [f64; 3]) -> Option<Spot> {
        match self {
            Footprint::Planet(globe) => Some(globe.locate(d)),
            Footprint::Rectangle(rectangle) => rectangle.locate(d),
            Footprint::Grid(grid) => grid.locate(d),
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Centre, right and up of a map placed on the sphere.
pub(super) fn frame(latitude_deg: f64, longitude_deg: f64, heading_deg: f64) -> [[f64; 3]; 3] {
    let (sin_lat, cos_lat) = sin_cos(latitude_deg);
    let (sin_lon, cos_lon) = sin_cos(longitude_deg);
    let (sin_head, cos_head) = sin_cos(heading_deg);
    let east = [-sin_lon, cos_lon, 0.0];
    let north = [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat];
    let turn = |a: f64, b: f64| [0, 1, 2].map(|k| a * east[k] + b * north[k]);
    [[cos_lat * cos_lon, cos_lat * sin_lon, sin_lat], turn(cos_head, -sin_head), turn(sin_head, cos_head)]
}

/// A rectangle in the gnomonic plane about its centre.
pub(in crate::terrain) struct Rectangle {
    frame: [[f64; 3]; 3],
    size: [f64; 2],
    half_m: [f64; 2],
    blend_m: f64,
    radius: f64,
}

impl Rectangle {
    fn new(
        image: &Imported,
        frame: [[f64; 3]; 3],
        width_m: Option<f64>,
        blend_m: Option<f64>,
        radius: f64,
    ) -> Result<Self, Fault> {
        let size = [image.field.columns() as f64, image.field.rows() as f64];
        if let (Some(unplaced), None) = (&image.unplaced, width_m) {
            return Err((unplaced.found.to_string(), format!("{}, `crs`, or `width_m`", unplaced.expected)));
        }
        let own_width = image.spacing_m.map(|[across, _]| size[0] * across);
        let unknown = || ("a file that does not state its spacing".to_owned(), "`width_m`".to_owned());
        let width_m = width_m.or(own_width).ok_or_else(unknown)?;
        if !(1.0..=radius).contains(&width_m) {
            return Err((format!("a map {width_m:.0} m wide"), "1 m to the planet's radius; `width_m` can shrink it".into()));
        }
        // Without a spacing samples are square.
        let height_m = match image.spacing_m {
            None => width_m * size[1] / size[0],
            Some([across, along]) => width_m * (size[1] * along) / (size[0] * across),
        };
        Self::of_size(frame, size, [0.5 * width_m, 0.5 * height_m], blend_m, radius)
    }

    /// A rectangle of so many metres on either side of its centre.
    pub(super) fn of_size(
        frame: [[f64; 3]; 3],
        size: [f64; 2],
        half_m: [f64; 2],
        blend_m: Option<f64>,
        radius: f64,
    ) -> Result<Self, Fault> {
        let blend_m = blend_width(blend_m, BLEND_SHARE * 2.0 * half_m[0], half_m[0])?;
        Ok(Self { frame, size, half_m, blend_m, radius })
    }

    pub(super) fn locate(&self, d: [f64; 3]) -> Option<Spot> {
        let [centre, right, up] = self.frame;
        let ahead = dot(d, centre);
        if ahead <= 0.1 {
            return None;
        }
        let (u, v) = (dot(d, right) / ahead * self.radius, dot(d, up) / ahead * self.radius);
        let inside = (self.half_m[0] - u.abs()).min(self.half_m[1] - v.abs());
        if inside < 0.0 {
            return None;
        }
        let column = (u / self.half_m[0] * 0.5 + 0.5) * self.size[0] - 0.5;
        let row = (0.5 - v / self.half_m[1] * 0.5) * self.size[1] - 0.5;
        Some(Spot { column, row, weight: fade(self.blend_m, inside) })
    }
}

/// Weight at a distance from the edge.
fn fade(blend_m: f64, inside: f64) -> f64 {
    if blend_m > 0.0 {
        smoothstep([0.0, blend_m], inside)
    } else {
        1.0
    }
}

/// The width of the edge, which may not reach past the middle.
fn blend_width(wanted: Option<f64>, default: f64, most: f64) -> Result<f64, Fault> {
    match wanted {
        Some(blend_m) if blend_m > most => Err((format!("`blend_m` of {blend_m}"), format!("at most half the map, {most:.0} m"))),
        wanted => Ok(wanted.unwrap_or(default)),
    }
}

/// Samples along parallels and meridians, where the file says.
pub(in crate::terrain) struct Grid {
    centre: [f64; 3],
    /// Cosine of the angle from the centre within which all of it lies: a cheap first test.
    cos_reach: f64,
    middle_longitude: f64,
    north: f64,
    step: [f64; 2],
    /// Columns and rows, less one.
    last: [f64; 2],
    /// Metres on the planet between samples at the equator and along meridians.
    spacing_m: [f64; 2],
    blend_m: f64,
}

impl Grid {
    fn new(image: &Imported, blend_m: Option<f64>, radius: f64) -> Result<Grid, Fault> {
        if let Some(unplaced) = &image.unplaced {
            return Err((unplaced.found.to_string(), format!("{}, or `crs`", unplaced.expected)));
        }
        let unknown = || {
            let expected = "a GeoTIFF or an HGT tile such as N36W085.hgt; or place it by \
                            `latitude_deg`, `longitude_deg` and `width_m`";
            ("a file that does not state its place".to_owned(), expected.to_owned())
        };
        let geographic = image.grid.ok_or_else(unknown)?;
        let last = [image.field.columns() as f64 - 1.0, image.field.rows() as f64 - 1.0];
        let (south, extent) =
            (geographic.south(image.field.rows()), [geographic.step_east * last[0], geographic.step_south * last[1]]);
        let far = geographic.north.max(-south);
        if extent[0].max(extent[1]) > WIDEST_GRID_DEG || far > FARTHEST_LATITUDE_DEG {
            let found =
                format!("{:.3} x {:.3} degrees between latitudes {south:.3} and {:.3}", extent[0], extent[1], geographic.north);
            let expected = "at most 90 degrees a side, within 85 degrees of the equator; leave out `placement` for a map of \
                            the whole planet";
            return Err((found, expected.to_owned()));
        }
        Ok(Grid::at(geographic, south, extent, last, radius)).and_then(|grid| grid.blended(blend_m, far))
    }

    fn at(geographic: GeographicGrid, south: f64, extent: [f64; 2], last: [f64; 2], radius: f64) -> Grid {
        let middle = geographic.west + 0.5 * extent[0];
        let middle_longitude = middle - 360.0 * ((middle + 180.0) / 360.0).floor();
        let [centre, ..] = frame(0.5 * (geographic.north + south), middle_longitude, 0.0);
        // No point is farther than half the way along a meridian and then along a parallel.
        let reach = 0.5 * (extent[0] + extent[1]) + REACH_ROOM_DEG;
        let spacing_m = [geographic.step_east, geographic.step_south].map(|step| step * (PI / 180.0) * radius);
        let step = [geographic.step_east, geographic.step_south];
        Grid {
            centre,
            cos_reach: sin_cos(reach).1,
            middle_longitude,
            north: geographic.north,
            step,
            last,
            spacing_m,
            blend_m: 0.0,
        }
    }

    fn blended(self, blend_m: Option<f64>, far: f64) -> Result<Grid, Fault> {
        let width = self.last[0] * self.spacing_m[0] * sin_cos(far).1;
        let smaller = width.min(self.last[1] * self.spacing_m[1]);
        Ok(Grid { blend_m: blend_width(blend_m, BLEND_SHARE * smaller, 0.5 * smaller)?, ..self })
    }

    fn locate(&self, d: [f64; 3]) -> Option<Spot> {
        if dot(d, self.centre) < self.cos_reach {
            return None;
        }
        let horizontal = (d[0] * d[0] + d[1] * d[1]).sqrt();
        let latitude = atan2(d[2], horizontal) * (180.0 / PI);
        let beside = atan2(d[1], d[0]) * (180.0 / PI) - self.middle_longitude;
        let beside = beside - 360.0 * ((beside + 180.0) / 360.0).floor();
        let (column, row) = (beside / self.step[0] + 0.5 * self.last[0], (self.north - latitude) / self.step[1]);
        let inside = [column.min(self.last[0] - column), row.min(self.last[1] - row)];
        if inside[0] < 0.0 || inside[1] < 0.0 {
            return None;
        }
        let across = fade(self.blend_m, inside[0] * self.spacing_m[0] * horizontal);
        let weight = across * fade(self.blend_m, inside[1] * self.spacing_m[1]);
        Some(Spot { column, row, weight })
    }
}
