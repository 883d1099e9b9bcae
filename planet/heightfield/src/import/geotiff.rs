//! Where the samples of a GeoTIFF lie (OGC GeoTIFF 1.1, 2019): a tie point and a pixel scale, in degrees on WGS 84, or in
//! metres of a projection, of which only the spacing is kept. Anything else leaves the site unknown.

use super::tiff::Tiff;
use super::{GeographicGrid, Imported};
use tiff::tags::Tag;

/// Keys of the directory, and the values that are understood.
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const PROJECTED_SYSTEM: u16 = 3072;
const PROJECTED_UNIT: u16 = 3076;
const PROJECTED: u16 = 1;
const GEOGRAPHIC: u16 = 2;
const PIXEL_IS_POINT: u16 = 2;
const WGS_84: u16 = 4326;
const METRE: u16 = 9001;

/// The UTM zones on WGS 84, north and south.
const UTM: [std::ops::RangeInclusive<u16>; 2] = [32_601..=32_660, 32_701..=32_760];

/// The image with what its tags say about where it lies.
pub(super) fn georeferenced(image: Imported, file: &mut Tiff) -> Imported {
    let (columns, rows) = (image.field.columns(), image.field.rows());
    let keys = file.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    let scale = file.get_tag_f64_vec(Tag::ModelPixelScaleTag).unwrap_or_default();
    let tie = file.get_tag_f64_vec(Tag::ModelTiepointTag).unwrap_or_default();
    let (&[step_east, step_south, ..], model) = (scale.as_slice(), key(&keys, MODEL_TYPE)) else { return image };
    match model {
        Some(GEOGRAPHIC) if key(&keys, GEOGRAPHIC_SYSTEM) == Some(WGS_84) => {
            let &[column, row, _, longitude, latitude, ..] = tie.as_slice() else { return image };
            // Pixels that are areas are tied by their north-west corner; samples are their centres.
            let half = if key(&keys, RASTER_TYPE) == Some(PIXEL_IS_POINT) { 0.0 } else { 0.5 };
            let (west, north) = (longitude + (half - column) * step_east, latitude - (half - row) * step_south);
            let grid = GeographicGrid { west, north, step_east, step_south };
            image.at(Some(grid).filter(|g| g.is_sound(columns, rows)))
        }
        Some(PROJECTED) if in_metres(&keys) && [step_east, step_south].iter().all(|s| (1e-3..=1e6).contains(s)) => {
            Imported { spacing_m: Some([step_east, step_south]), ..image }
        }
        _ => image,
    }
}

/// Whether a projection counts in metres.
fn in_metres(keys: &[u16]) -> bool {
    let zone = key(keys, PROJECTED_SYSTEM).is_some_and(|system| UTM.iter().any(|zones| zones.contains(&system)));
    zone || key(keys, PROJECTED_UNIT) == Some(METRE)
}

/// The value of a key that is stored in the directory itself.
fn key(keys: &[u16], wanted: u16) -> Option<u16> {
    let mut entries = keys.chunks_exact(4).skip(1);
    entries.find_map(|entry| (entry[0] == wanted && entry[1] == 0).then_some(entry[3]))
}
