//! Tiles of the Shuttle Radar Topography Mission: one degree square with both borders, metres as 16-bit big-endian
//! integers, north row first. The name gives the south-west corner: `N36W085.hgt`. (USGS, SRTM Topography, 2015.)

use super::{Fault, Format, GeographicGrid, ImportError, Imported, Source, Values};
use std::path::Path;

/// Samples a side: three arc seconds and one.
const SIDES: [usize; 2] = [1201, 3601];

/// What stands for no data.
const NO_DATA: i16 = i16::MIN;

/// Reads a tile.
pub(super) fn read(source: &Source) -> Result<Imported, ImportError> {
    let length = source.bytes.len();
    let side = SIDES.into_iter().find(|side| 2 * side * side == length).ok_or_else(|| {
        let expected = "2884802 (1201 x 1201 samples) or 25934402 (3601 x 3601)";
        source.refuse(Fault::Length, format!("{length} bytes"), expected)
    })?;
    let height = |b: &[u8]| match i16::from_be_bytes([b[0], b[1]]) {
        NO_DATA => f32::NAN,
        metres => f32::from(metres),
    };
    let heights = source.bytes.chunks_exact(2).map(height).collect();
    let tile = Imported::new(source, Format::Hgt, Values::Metres, [side, side], heights)?;
    let step = 1.0 / (side - 1) as f64;
    let grid =
        corner(source.name).map(|[south, west]| GeographicGrid { west, north: south + 1.0, step_east: step, step_south: step });
    Ok(tile.at(grid))
}

/// Latitude and longitude of the south-west corner, from a name such as `N36W085.hgt` or `s01e010.SRTMGL1.hgt`.
fn corner(name: &str) -> Option<[f64; 2]> {
    let name = Path::new(name).file_name()?.to_str()?.to_ascii_uppercase();
    let degrees = |text: Option<&str>, most: f64| {
        let digits = text.filter(|t| t.bytes().all(|b| b.is_ascii_digit()))?;
        digits.parse::<f64>().ok().filter(|d| *d <= most)
    };
    let sign = |at: usize, [positive, negative]: [&str; 2]| match name.get(at..at + 1)? {
        letter if letter == positive => Some(1.0),
        letter if letter == negative => Some(-1.0),
        _ => None,
    };
    let south = sign(0, ["N", "S"])? * degrees(name.get(1..3), 90.0)?;
    let west = sign(3, ["E", "W"])? * degrees(name.get(4..7), 180.0)?;
    (-90.0..90.0).contains(&south).then_some([south, west])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tile_names_give_their_corners() {
        assert_eq!(corner("some/folder/N36W085.hgt"), Some([36.0, -85.0]));
        assert_eq!(corner("s01e010.SRTMGL1.hgt"), Some([-1.0, 10.0]));
        for name in ["tile.hgt", "N36.hgt", "N+6W085.hgt", "N36W185.hgt", "N95W085.hgt", "é36W085.hgt", "W085N36.hgt", ""] {
            assert_eq!(corner(name), None, "{name}");
        }
    }
}
