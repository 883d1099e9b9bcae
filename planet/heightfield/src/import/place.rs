//! Where samples lie and how far apart they are: from coordinates of a system to degrees on a body, or to true metres.

use super::crs::{Crs, Kind};
use super::{Ellipsoid, Fault, GeographicGrid, ImportError, Imported, Source};

/// A projection whose lengths are true within this share in the middle of a map is taken at its word, as surveyors do: 10 m of a
/// UTM zone are 10 m. Beyond, metres are those on the ground.
const TRUE_ENOUGH: f64 = 1.0 / 500.0;

/// Largest step that must be meant in degrees when coordinates fit a globe.
const LARGEST_STEP_DEG: f64 = 1.0;

/// Change of scale over a map from which on it is told.
const UNEVEN: f64 = 0.02;

/// Where the samples of a file lie, as it says.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    /// The coordinate system: `EPSG:32632`, or a proj string.
    pub crs: String,
    /// The same as WKT 1 on one line, for programs that want it; none for a projection that no table has.
    pub wkt: Option<String>,
    /// Coordinates of the north-western sample.
    pub origin: [f64; 2],
    /// Units from a sample to the next one east and to the next one south of it, above 0.
    pub step: [f64; 2],
    /// The unit of coordinates.
    pub unit: String,
    /// The body.
    pub body: Ellipsoid,
    /// Longitude and latitude in the middle of the map, in degrees.
    pub middle_deg: [f64; 2],
    /// The same of the north-western, north-eastern, south-western and south-eastern samples.
    pub corners_deg: [[f64; 2]; 4],
    /// Direction of the map's north there, in degrees clockwise from true north.
    pub heading_deg: f64,
    /// True metres a stated metre there, eastwards and northwards; 1 for degrees.
    pub scale: [f64; 2],
}

/// A raster in the plane of a coordinate system, north up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Raster {
    /// Coordinates of the north-western sample.
    pub(super) origin: [f64; 2],
    /// Units between samples eastwards and southwards, above 0.
    pub(super) step: [f64; 2],
}

impl Raster {
    /// Coordinates at a sample, also between samples.
    fn at(&self, column: f64, row: f64) -> [f64; 2] {
        [self.origin[0] + column * self.step[0], self.origin[1] - row * self.step[1]]
    }
}

/// The image with its place, or without and with the reason.
pub(super) fn place(source: &Source, image: Imported, crs: &Crs, raster: Raster) -> Imported {
    let placed = match &crs.kind {
        Kind::Geographic { unit_deg, meridian } => geographic(source, &image, crs, raster, *unit_deg, *meridian),
        Kind::Projected(_) => projected(source, &image, crs, raster),
    };
    match placed {
        Ok(Placed { georeference, grid, spacing_m, notes }) => {
            let mut image = image;
            image.notes.extend(notes);
            if crs.is_shifted {
                let datum = "its datum lies up to some hundred metres beside WGS 84, and is not shifted";
                image.notes.push(format!("{}: {datum}", crs.name));
            }
            Imported { georeference: Some(georeference), grid, spacing_m: Some(spacing_m), unplaced: None, ..image }
        }
        Err(error) => Imported { unplaced: Some(Box::new(error)), ..image },
    }
}

/// The image where no system is named: steps can only be lengths, unless they may be degrees.
pub(super) fn without_system(source: &Source, image: Imported, Raster { origin: [west, north], step }: Raster) -> Imported {
    let [across, down] = step;
    let [east, south] = [west + image.field.columns() as f64 * across, north - image.field.rows() as f64 * down];
    let on_globe = west >= -361.0 && east <= 541.0 && south >= -91.0 && north <= 91.0;
    if on_globe && across.max(down) < LARGEST_STEP_DEG {
        let found = format!("steps of {across}, which may be degrees");
        let error = source.refuse(Fault::Place, found, "a coordinate system, of which the format holds none");
        return Imported { unplaced: Some(Box::new(error)), ..image };
    }
    let mut image = Imported { spacing_m: Some(step), ..image };
    image.notes.push("names no coordinate system: its steps are taken as metres (--crs says otherwise)".into());
    image
}

struct Placed {
    georeference: Georeference,
    grid: Option<GeographicGrid>,
    spacing_m: [f64; 2],
    notes: Vec<String>,
}

fn geographic(
    source: &Source,
    image: &Imported,
    crs: &Crs,
    Raster { origin, step }: Raster,
    unit_deg: f64,
    meridian: f64,
) -> Result<Placed, ImportError> {
    let (columns, rows) = (image.field.columns(), image.field.rows());
    let [west, north] = [origin[0] * unit_deg + meridian, origin[1] * unit_deg];
    let grid = GeographicGrid { west, north, step_east: step[0] * unit_deg, step_south: step[1] * unit_deg };
    if !grid.is_sound(columns, rows) {
        let found = format!(
            "{} from longitude {west:.3}, latitude {north:.3} to {:.3}, {:.3}",
            crs.name,
            grid.east(columns),
            grid.south(rows)
        );
        return Err(source.refuse(Fault::Place, found, "degrees that lie on a globe"));
    }
    let spacing_m = grid.spacing_m(rows, &crs.body);
    let middle_deg = [0.5 * (west + grid.east(columns)), 0.5 * (north + grid.south(rows))];
    let (crs_name, unit, body) = (crs.name.clone(), crs.unit(), crs.body);
    let (east, south) = (grid.east(columns), grid.south(rows));
    let corners_deg = [[west, north], [east, north], [west, south], [east, south]];
    let (heading_deg, scale) = (0.0, [1.0; 2]);
    let wkt = crs.wkt();
    let georeference = Georeference { crs: crs_name, wkt, origin, step, unit, body, middle_deg, corners_deg, heading_deg, scale };
    let ends = [grid.north, grid.south(rows)].map(|latitude| crs.body.radian_m(latitude)[0]);
    let ratio = ends[0].max(ends[1]) / ends[0].min(ends[1]).max(1e-9);
    let mut notes = Vec::new();
    if ratio > 1.0 + UNEVEN {
        notes.push(uneven("a degree of longitude is", ratio));
    }
    Ok(Placed { georeference, grid: Some(grid), spacing_m, notes })
}

fn uneven(what: &str, ratio: f64) -> String {
    let percent = 100.0 * (ratio - 1.0);
    format!("{what} {percent:.0} % longer on one side of the map than on the other: a flat mesh takes the length in the middle")
}

fn projected(source: &Source, image: &Imported, crs: &Crs, raster: Raster) -> Result<Placed, ImportError> {
    let last = [image.field.columns() as f64 - 1.0, image.field.rows() as f64 - 1.0];
    // Far enough apart for digits to matter little, near enough for curvature not to.
    let reach = raster.step[0].max(raster.step[1]);
    let around = |across: f64, down: f64| crs.around(raster.at(across * last[0], down * last[1]), reach);
    let middle = around(0.5, 0.5).ok_or_else(|| {
        let [x, y] = raster.at(0.5 * last[0], 0.5 * last[1]);
        source.refuse(Fault::Place, format!("{} at {x}, {y}", crs.name), "a place on the body, inside the projection's reach")
    })?;
    let unit_m = crs.unit_m().unwrap_or(1.0);
    let scale = middle.metres.map(|m| m / unit_m);
    let at_its_word = scale.iter().all(|s| (s - 1.0).abs() <= TRUE_ENOUGH);
    let metres = if at_its_word { [unit_m; 2] } else { middle.metres.map(steady) };
    let spacing_m = [raster.step[0] * metres[0], raster.step[1] * metres[1]];
    if !spacing_m.iter().all(|s| (1e-6..=1e7).contains(s)) {
        let found = format!("{} with {} x {} m between samples", crs.name, spacing_m[0], spacing_m[1]);
        return Err(source.refuse(Fault::Place, found, "a spacing from 0.000001 m to 10000 km"));
    }
    let mut notes = Vec::new();
    if !at_its_word {
        let per = 100.0 * scale[0];
        notes.push(format!("{}: lengths on the ground are {per:.2} % of those on the map in its middle, and taken", crs.name));
    }
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.0], [0.5, 1.0]];
    let lengths = corners.iter().filter_map(|[a, d]| around(*a, *d)).map(|local| local.metres[0]);
    let (low, high) = lengths.fold((middle.metres[0], middle.metres[0]), |(l, h), m| (l.min(m), h.max(m)));
    if high > low * (1.0 + UNEVEN) {
        notes.push(uneven("a unit of the map is", high / low));
    }
    let georeference = Georeference {
        crs: crs.name.clone(),
        wkt: crs.wkt(),
        origin: raster.origin,
        step: raster.step,
        unit: crs.unit(),
        body: crs.body,
        middle_deg: middle.place,
        corners_deg: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
            .map(|[across, down]| crs.degrees(raster.at(across * last[0], down * last[1])).unwrap_or([f64::NAN; 2])),
        heading_deg: middle.heading,
        scale,
    };
    Ok(Placed { georeference, grid: None, spacing_m, notes })
}

/// A length to six digits: about the rest the mathematics of platforms may disagree, and planets must not.
fn steady(metres: f64) -> f64 {
    let digits = 10_f64.powi(6 - metres.log10().ceil() as i32);
    (metres * digits).round() / digits
}
