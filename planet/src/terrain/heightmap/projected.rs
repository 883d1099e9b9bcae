//! Heightmaps in metres of a projection, where the file says: the rectangle about its middle that its corners confirm. In: a file
//! whose projection is understood. Out: a rectangle, or why none lies there.

use super::footprint::{frame, Fault, Rectangle};
use terrane_heightfield::angles::sin_cos;
use terrane_heightfield::import::Imported;

/// Samples by which a corner may lie beside its place on the rectangle.
const MOST_OFF: f64 = 1.0;

pub(super) fn rectangle(image: &Imported, blend_m: Option<f64>, radius: f64) -> Result<Rectangle, Fault> {
    let (Some(place), Some(spacing_m)) = (&image.georeference, image.spacing_m) else {
        return Err(("a file that does not state its place".into(), "one that does".into()));
    };
    // To a centimetre: about the rest the mathematics of platforms may disagree, and planets must not.
    let rounded = |degrees: f64| (degrees * 1e7).round() / 1e7;
    let [longitude, latitude] = place.middle_deg.map(rounded);
    let frame = frame(latitude, longitude, rounded(place.heading_deg));
    let size = [image.field.columns() as f64, image.field.rows() as f64];
    // Degrees stay what they are: what is a metre on the file's body may be more or less on the planet.
    let per_radian = place.body.radian_m(latitude);
    let round = radius * sin_cos(latitude).1;
    let half_m = [0.5 * size[0] * spacing_m[0] / per_radian[0] * round, 0.5 * size[1] * spacing_m[1] / per_radian[1] * radius];
    let rectangle = Rectangle::of_size(frame, size, half_m, blend_m, radius)?;
    let last = [size[0] - 1.0, size[1] - 1.0];
    for (corner, wanted) in place.corners_deg.iter().zip([[0.0, 0.0], [last[0], 0.0], [0.0, last[1]], last]) {
        let [centre, ..] = self::frame(corner[1], corner[0], 0.0);
        let off = rectangle.locate(centre).map(|spot| (spot.column - wanted[0]).abs().max((spot.row - wanted[1]).abs()));
        if off.is_none_or(|off| off > MOST_OFF) {
            let found = format!("a map in {} that is too large to lie flat about {latitude:.4}, {longitude:.4}", place.crs);
            let expected = "smaller maps, or degrees: gdalwarp -t_srs EPSG:4326";
            return Err((found, expected.into()));
        }
    }
    Ok(rectangle)
}
