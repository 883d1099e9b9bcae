//! Tiles of the Shuttle Radar Topography Mission: one degree square with both borders, metres as 16-bit big-endian
//! integers, north row first. The name gives the south-west corner: `N36W085.hgt`. (USGS, SRTM Topography, 2015.)

use super::crs::Crs;
use super::gaps::Gaps;
use super::place::{self, Raster};
use super::{Fault, Format, ImportError, Imported, Source, Values};
use std::path::Path;

/// Columns and rows: three arc seconds and one; and two seconds of longitude by one of latitude, far north and south.
const SIZES: [[usize; 2]; 3] = [[1201, 1201], [3601, 3601], [1801, 3601]];

/// What stands for no data; and for what the radar saw nothing in, or too much.
const NO_DATA: f64 = -32_768.0;
const SPIKE: i16 = i16::MAX;

/// Whether so many bytes are such a tile.
pub(super) fn is_tile(length: usize) -> bool {
    SIZES.iter().any(|[columns, rows]| 2 * columns * rows == length)
}

/// Reads a tile.
pub(super) fn read(source: &Source) -> Result<Imported, ImportError> {
    let length = source.bytes.len();
    let size = SIZES.into_iter().find(|[columns, rows]| 2 * columns * rows == length).ok_or_else(|| {
        let expected = "2884802 (1201 x 1201 samples), 12967202 (1801 x 3601) or 25934402 (3601 x 3601)";
        source.refuse(Fault::Length, format!("{length} bytes"), expected)
    })?;
    source.check_part(size)?;
    let gaps = Gaps::new(source, Some(NO_DATA));
    let mut spikes = 0;
    let mut height = |b: &[u8]| {
        let metres = i16::from_be_bytes([b[0], b[1]]);
        spikes += usize::from(metres == SPIKE);
        if metres == SPIKE || gaps.holds(f64::from(metres), false) {
            f32::NAN
        } else {
            f32::from(metres)
        }
    };
    let heights = source.bytes.chunks_exact(2).map(&mut height).collect();
    let mut tile = Imported::new(source, Format::Hgt, Values::Metres, size, heights)?;
    tile.declared_no_data = Some(NO_DATA);
    if spikes > 0 {
        tile.notes.push(format!("{spikes} spikes of 32767 are no heights: taken as gaps"));
    }
    let Some([south, west]) = corner(source.name) else { return Ok(tile) };
    let degrees = Crs::of_code(4326).map_err(|found| source.refuse(Fault::Place, found, "degrees on WGS 84"))?;
    let step = size.map(|side| 1.0 / (side - 1) as f64);
    Ok(place::place(source, tile, &degrees, Raster { origin: [west, south + 1.0], step }))
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
