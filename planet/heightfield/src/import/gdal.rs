//! Whatever the system's GDAL opens and no reader here knows: VRT mosaics, NetCDF, IMG, JPEG 2000, LERC in TIFF. In: a path. Out:
//! the samples of the first band, lines at a time, with scale, offset, unit, no-data, place and coordinate system as GDAL says.

use super::crs::Crs;
use super::gaps::Gaps;
use super::geotiff::{Part, Tags};
use super::metadata::{unit_m, Band};
use super::tiff::turn;
use super::{Fault, Format, ImportError, Imported, Source, Values, Window};
use gdal::raster::{GdalDataType, RasterBand};
use gdal::Dataset;
use std::path::Path;

/// Samples that are read at a time.
const MOST_AT_ONCE: usize = 1 << 22;

/// Reads a file that was refused with `known`.
pub(super) fn read(source: &Source, path: &Path, known: ImportError) -> Result<Imported, ImportError> {
    let Ok(dataset) = Dataset::open(path) else { return Err(known) };
    if dataset.raster_count() != 1 {
        return Err(known);
    }
    let refuse = |e: gdal::errors::GdalError| source.refuse(Fault::Damaged, e.to_string(), "a raster that GDAL reads");
    let full = dataset.rasterband(1).map_err(refuse)?;
    let size = [full.x_size(), full.y_size()];
    let own = match source.options.overview {
        Some(overview) if overview > 0 => full.overview(overview - 1).map_err(refuse)?,
        _ => dataset.rasterband(1).map_err(refuse)?,
    };
    let window = source.options.part(source, [own.x_size(), own.y_size()])?;
    source.check_part(window.size())?;
    let unit = full.unit();
    let unit_m = unit_m(&unit).ok_or_else(|| source.refuse(Fault::Kind, format!("heights in '{unit}'"), "a unit of length"))?;
    let band = Band { scale: full.scale().unwrap_or(1.0), offset: full.offset().unwrap_or(0.0), unit_m: Some(unit_m) };
    let values = values(full.band_type(), &band, &unit);
    let mut heights = heights(source, &own, window, &band, full.no_data_value()).map_err(refuse)?;
    let tags = dataset.geo_transform().ok().map(Tags::of_affine);
    if let Some(tags) = &tags {
        turn(&mut heights, window.columns, tags.turned());
    }
    let mut image = Imported::new(source, Format::Gdal, values, window.size(), heights)?;
    image.declared_no_data = full.no_data_value();
    let driver = dataset.driver().short_name();
    image.notes.push(format!("read by GDAL ({driver})"));
    let factor = [size[0] as f64 / own.x_size() as f64, size[1] as f64 / own.y_size() as f64];
    let Some(tags) = tags else { return Ok(image) };
    Ok(tags.placed(source, image, Part { window, factor }, || system(&dataset)))
}

fn values(kind: GdalDataType, band: &Band, unit: &str) -> Values {
    match kind {
        GdalDataType::UInt8 if band.is_plain() && unit.is_empty() => Values::Levels { full: 255.0 },
        GdalDataType::UInt16 if band.is_plain() && unit.is_empty() => Values::Levels { full: 65_535.0 },
        _ => Values::Metres,
    }
}

fn heights(
    source: &Source,
    band: &RasterBand,
    Window { column, row, columns, rows }: Window,
    scale: &Band,
    no_data: Option<f64>,
) -> gdal::errors::Result<Vec<f32>> {
    let gaps = Gaps::new(source, no_data);
    let floats = matches!(band.band_type(), GdalDataType::Float32 | GdalDataType::Float64);
    let mut heights = Vec::with_capacity(columns * rows);
    let lines = (MOST_AT_ONCE / columns).max(1);
    for first in (0..rows).step_by(lines) {
        let size = (columns, lines.min(rows - first));
        let numbers = band.read_as::<f64>((column as isize, (row + first) as isize), size, size, None)?;
        heights.extend(numbers.data().iter().map(|&number| match gaps.holds(number, floats) || number.is_infinite() {
            true => f32::NAN,
            false => scale.metres(number) as f32,
        }));
    }
    Ok(heights)
}

/// The coordinate system: by its code where the table here has it, else as a proj string.
fn system(dataset: &Dataset) -> Result<Crs, String> {
    let named = dataset.spatial_ref().map_err(|_| "no coordinate system".to_owned())?;
    let code =
        named.auth_code().ok().and_then(|code| u16::try_from(code).ok()).filter(|_| named.auth_name().as_deref() == Some("EPSG"));
    if let Some(crs) = code.and_then(|code| Crs::of_code(code).ok()) {
        return Ok(crs);
    }
    let proj = named.to_proj4().map_err(|e| format!("{} ({e})", named.name().unwrap_or_default()))?;
    Crs::of_proj(&proj, proj.trim())
}
