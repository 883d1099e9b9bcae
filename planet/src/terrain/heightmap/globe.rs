//! A heightmap of the whole planet: equirectangular, with the longitude of its left edge from the file, else -180. In: unit
//! directions. Out: column and row.

use super::footprint::{Fault, Spot};
use std::f64::consts::PI;
use terrane_heightfield::angles::atan2;
use terrane_heightfield::import::Imported;

/// Share of a turn, and of a sample, by which a map may be short of one or beyond: rounding.
const OFF: f64 = 1e-3;
const OFF_SAMPLES: f64 = 0.05;

/// A map of all longitudes and latitudes.
pub(in crate::terrain) struct Globe {
    /// Columns and rows that a turn and a half turn have.
    columns: f64,
    rows: f64,
    /// Columns and rows between the file's first sample and where it lies without a word.
    shift: [f64; 2],
}

impl Globe {
    pub(super) fn new(image: &Imported) -> Result<Globe, Fault> {
        let (columns, rows) = (image.field.columns() as f64, image.field.rows() as f64);
        if let Some(grid) = image.grid {
            let turn = [360.0 / grid.step_east, 180.0 / grid.step_south];
            let found = format!(
                "{:.3} x {:.3} degrees from longitude {:.3}, latitude {:.3}",
                columns * grid.step_east,
                rows * grid.step_south,
                grid.west,
                grid.north
            );
            // Samples may stand on both ends: on the poles, and twice on the same meridian.
            let whole = |samples: f64, turn: f64| [0.0, 1.0].iter().any(|end| (samples - turn - end).abs() < OFF_SAMPLES);
            if !whole(columns, turn[0]) || !whole(rows, turn[1]) {
                return Err((found, "the whole planet, or `placement = \"file\"` to put it where the file says".into()));
            }
            let shift =
                [(-180.0 + 0.5 * grid.step_east - grid.west) / grid.step_east, (grid.north - 90.0) / grid.step_south + 0.5];
            return Ok(Globe { columns: turn[0], rows: turn[1], shift });
        }
        if let Some(place) = &image.georeference {
            return Globe::projected(image, place.middle_deg[0], columns, rows);
        }
        if columns != 2.0 * rows {
            let found = format!("{columns} x {rows} samples");
            return Err((found, "a whole-planet map twice as wide as high".into()));
        }
        Ok(Globe { columns, rows, shift: [0.0; 2] })
    }

    /// A map in metres along parallels and meridians, as those of other planets often are.
    fn projected(image: &Imported, middle: f64, columns: f64, rows: f64) -> Result<Globe, Fault> {
        let whole = image.georeference.as_ref().zip(image.spacing_m).is_some_and(|(place, [across, _])| {
            let turn = 2.0 * PI * place.body.semi_major_m;
            (columns * across / turn - 1.0).abs() < OFF && columns == 2.0 * rows && place.crs.contains("+proj=eqc")
        });
        if !whole {
            let found = format!("{columns} x {rows} samples of a map that is not the whole planet's");
            return Err((
                found,
                "`placement = \"file\"` to put it where the file says, or `latitude_deg` and `longitude_deg`".into(),
            ));
        }
        // To a millionth of a degree: about the rest the mathematics of platforms may disagree.
        let middle = (middle * 1e6).round() / 1e6;
        Ok(Globe { columns, rows, shift: [-middle / 360.0 * columns, 0.0] })
    }

    pub(super) fn locate(&self, d: [f64; 3]) -> Spot {
        let longitude = atan2(d[1], d[0]);
        let latitude = atan2(d[2], (d[0] * d[0] + d[1] * d[1]).sqrt());
        let column = (longitude / (2.0 * PI) + 0.5) * self.columns - 0.5 + self.shift[0];
        let row = (0.5 - latitude / PI) * self.rows - 0.5 + self.shift[1];
        Spot { column, row, weight: 1.0 }
    }

    /// Columns of a turn: a file may hold its first ones once more at its end.
    pub(super) fn turn(&self) -> usize {
        self.columns.round() as usize
    }
}
