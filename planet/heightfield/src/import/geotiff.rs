//! Where the samples of a GeoTIFF lie (OGC GeoTIFF 1.1, 2019): a tie point and a pixel scale, or a matrix. South-up and mirrored
//! rasters are turned upright; rotated ones are not.

use super::crs::Crs;
use super::geokeys::GeoKeys;
use super::place::{self, Raster};
use super::tiff::Tiff;
use super::{Fault, ImportError, Imported, Source, Window};
use tiff::tags::Tag;

/// Share of a step by which rows may lean before a raster counts as rotated.
const LEAN: f64 = 1e-6;

/// What the tags of a file say about its place.
pub(super) struct Tags {
    keys: GeoKeys,
    matrix: Matrix,
}

/// Six numbers from columns and rows to coordinates, in GDAL's order.
pub(super) type Affine = [f64; 6];

/// From columns and rows to coordinates.
enum Matrix {
    None,
    /// `x = x0 + a column + b row`, `y = y0 + d column + e row`.
    Affine {
        origin: [f64; 2],
        a: f64,
        b: f64,
        d: f64,
        e: f64,
    },
    /// So many points whose place is known, and nothing between.
    ControlPoints(usize),
}

/// The part of the raster that was read.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) window: Window,
    /// Samples of the full raster a sample, across and down; above 1 for overviews.
    pub(super) factor: [f64; 2],
}

/// How rows and columns run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Turned {
    pub(super) rows: bool,
    pub(super) columns: bool,
}

impl Tags {
    /// Those of a raster whose place another library has read: coordinates of corners, in a system that the user's, else this
    /// one, names.
    pub(super) fn of_affine([x, a, b, y, d, e]: Affine) -> Tags {
        let keys = GeoKeys { directory: Vec::new(), doubles: Vec::new(), text: String::new() };
        Tags { keys, matrix: Matrix::Affine { origin: [x, y], a, b, d, e } }
    }

    pub(super) fn read(file: &mut Tiff) -> Tags {
        let directory = file.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
        let doubles = file.get_tag_f64_vec(Tag::GeoDoubleParamsTag).unwrap_or_default();
        let text = file.get_tag_ascii_string(Tag::GeoAsciiParamsTag).unwrap_or_default();
        let scale = file.get_tag_f64_vec(Tag::ModelPixelScaleTag).unwrap_or_default();
        let ties = file.get_tag_f64_vec(Tag::ModelTiepointTag).unwrap_or_default();
        let matrix = file.get_tag_f64_vec(Tag::ModelTransformationTag).unwrap_or_default();
        Tags { keys: GeoKeys { directory, doubles, text }, matrix: Matrix::of(&scale, &ties, &matrix) }
    }

    /// Whether rows run northwards, and columns westwards.
    pub(super) fn turned(&self) -> Turned {
        match self.matrix {
            Matrix::Affine { a, b, d, e, .. } if !leans([a, b, d, e]) => Turned { rows: e > 0.0, columns: a < 0.0 },
            _ => Turned::default(),
        }
    }

    /// Metres a unit of height: of the vertical keys, or of the system.
    pub(super) fn height_unit_m(&self, source: &Source) -> Result<Option<f64>, ImportError> {
        let stated = self.keys.height_unit_m();
        let stated =
            stated.map_err(|found| source.refuse(Fault::Kind, found, "metres or feet").with_advice("convert it to metres"))?;
        Ok(stated.or_else(|| self.keys.crs().ok()?.height_unit_m))
    }

    /// The image, turned upright, with its place.
    pub(super) fn georeferenced(&self, source: &Source, image: Imported, part: Part) -> Imported {
        self.placed(source, image, part, || self.keys.crs())
    }

    /// The same in a system that is read elsewhere.
    pub(super) fn placed(&self, source: &Source, image: Imported, part: Part, crs: impl Fn() -> Result<Crs, String>) -> Imported {
        match self.raster(source, &image, part, crs) {
            Ok(None) => image,
            Ok(Some((crs, raster))) => place::place(source, image, &crs, raster),
            Err(error) => Imported { unplaced: Some(Box::new(error)), ..image },
        }
    }

    fn raster(
        &self,
        source: &Source,
        image: &Imported,
        part: Part,
        crs: impl Fn() -> Result<Crs, String>,
    ) -> Result<Option<(Crs, Raster)>, ImportError> {
        let refuse = |found: String, expected: &str| source.refuse(Fault::Place, found, expected);
        let (origin, [a, b, d, e]) = match self.matrix {
            Matrix::None if self.keys.is_empty() || source.options.crs.is_none() => return Ok(None),
            Matrix::None => {
                return Err(refuse("no place".into(), "a tie point and a scale").with_advice("state --spacing M alone"))
            }
            Matrix::ControlPoints(count) => {
                let found = format!("{count} ground control points");
                let warp = "resample it, for instance with gdalwarp, or take samples as they lie (--spacing M)";
                return Err(refuse(found, "a raster along the axes of its coordinate system").with_advice(warp));
            }
            Matrix::Affine { origin, a, b, d, e } => (origin, [a, b, d, e]),
        };
        if leans([a, b, d, e]) {
            let found = format!("a raster turned by {:.3} degrees", d.atan2(a).to_degrees().abs());
            let warp = "turn it north with gdalwarp, or take rows and columns as they lie (--spacing M)";
            return Err(refuse(found, "rows along the first axis of its coordinate system").with_advice(warp));
        }
        if ![a, e].iter().all(|step| (1e-12..=1e9).contains(&step.abs())) || !origin.iter().all(|x| x.is_finite()) {
            return Err(refuse(format!("steps of {a} and {e}"), "steps above 0"));
        }
        let crs = match &source.options.crs {
            Some(text) => Crs::of_user(text).map_err(|found| refuse(format!("--crs: {found}"), "a system that is known"))?,
            None => crs().map_err(|found| refuse(found, "a coordinate system that is known"))?,
        };
        // The centre of the first sample that is kept, which after turning is the north-western one.
        let shift = if self.keys.is_point() { 0.5 } else { 0.0 };
        let (last, turned) = ([image.field.columns() - 1, image.field.rows() - 1], self.turned());
        let at = |first: usize, turned: bool, last: usize, factor: f64| {
            (first as f64 + if turned { last as f64 } else { 0.0 } + 0.5) * factor - shift
        };
        let column = at(part.window.column, turned.columns, last[0], part.factor[0]);
        let row = at(part.window.row, turned.rows, last[1], part.factor[1]);
        let origin = [origin[0] + column * a, origin[1] + row * e];
        Ok(Some((crs, Raster { origin, step: [a.abs() * part.factor[0], e.abs() * part.factor[1]] })))
    }
}

impl Matrix {
    fn of(scale: &[f64], ties: &[f64], matrix: &[f64]) -> Matrix {
        match (scale, ties, matrix) {
            (&[across, down, ..], &[column, row, _, x, y, ..], _) if across != 0.0 && down != 0.0 => {
                // Scales are lengths: files that count rows upwards say so by a matrix.
                let (a, e) = (across.abs(), -down.abs());
                Matrix::Affine { origin: [x - column * a, y - row * e], a, b: 0.0, d: 0.0, e }
            }
            (_, _, &[a, b, _, x, d, e, _, y, ..]) => Matrix::Affine { origin: [x, y], a, b, d, e },
            (_, ties, _) if ties.len() > 6 => Matrix::ControlPoints(ties.len() / 6),
            _ => Matrix::None,
        }
    }
}

fn leans([a, b, d, e]: [f64; 4]) -> bool {
    b.abs() > LEAN * e.abs() || d.abs() > LEAN * a.abs()
}
