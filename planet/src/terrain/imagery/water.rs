//! Water on a picture of a whole planet. In: sRGB-encoded pixels. Out: which of them are water by their colour, and which of those belong
//! to waters of some size.

use std::f64::consts::PI;
use terrane_heightfield::angles::sin_cos;

/// Whether a pixel is the blue of water: blue well above red and green. Snow in shadow is lighter, wet forest greener.
pub(in crate::terrain) fn is_blue([red, green, blue]: [u8; 3]) -> bool {
    let [red, green, blue] = [red, green, blue].map(u32::from);
    10 * blue > 14 * red + 60 && 10 * blue > 11 * green + 20 && red < 110
}

/// How much of each pixel is land, of 255: nothing of water, little beside it, where the picture's own edges and its compression mix both.
pub(in crate::terrain) fn land_counts(pixels: &[[u8; 3]], [columns, rows]: [usize; 2], wraps: bool) -> Vec<u8> {
    const BESIDE: u8 = 16;
    let water: Vec<bool> = pixels.iter().map(|&pixel| is_blue(pixel)).collect();
    let near_water = |k: usize| {
        let (column, row) = (k % columns, k / columns);
        let beside = |column: usize| {
            let west = if column > 0 { Some(column - 1) } else { wraps.then_some(columns - 1) };
            let east = if column + 1 < columns { Some(column + 1) } else { wraps.then_some(0) };
            [west, Some(column), east]
        };
        (row.saturating_sub(1)..=(row + 1).min(rows - 1))
            .any(|row| beside(column).into_iter().flatten().any(|column| water[row * columns + column]))
    };
    (0..pixels.len())
        .map(|k| {
            if water[k] {
                0
            } else if near_water(k) {
                BESIDE
            } else {
                255
            }
        })
        .collect()
}

/// Makes land of waters on a map of the whole planet that are smaller than `smallest_m2`, and water of islands of a single pixel, which
/// compression leaves in the sea.
pub(in crate::terrain) fn drop_small(water: &mut [bool], size: [usize; 2], radius: f64, smallest_m2: f64) {
    let areas = row_areas(size, radius);
    // A pixel alone: smaller than one and a half at the equator.
    let speck_m2 = 1.5 * areas[size[1] / 2];
    for (kind, smallest) in [(false, speck_m2), (true, smallest_m2)] {
        for body in bodies(water, size, kind) {
            if body.iter().map(|&k| areas[k / size[0]]).sum::<f64>() < smallest {
                body.into_iter().for_each(|k| water[k] = !kind);
            }
        }
    }
}

/// Area of a pixel of each row, in square metres.
fn row_areas([columns, rows]: [usize; 2], radius: f64) -> Vec<f64> {
    let band = |row: usize| {
        let sine = |edge: usize| sin_cos(90.0 - 180.0 * edge as f64 / rows as f64).0;
        2.0 * PI * radius * radius * (sine(row) - sine(row + 1)) / columns as f64
    };
    (0..rows).map(band).collect()
}

/// The connected bodies of one kind, by sides and corners, around the planet.
fn bodies(water: &[bool], [columns, rows]: [usize; 2], kind: bool) -> Vec<Vec<usize>> {
    let mut seen = vec![false; water.len()];
    let mut all = Vec::new();
    for start in 0..water.len() {
        if seen[start] || water[start] != kind {
            continue;
        }
        seen[start] = true;
        let (mut body, mut next) = (vec![start], 0);
        while next < body.len() {
            let (column, row) = (body[next] % columns, body[next] / columns);
            next += 1;
            for row in row.saturating_sub(1)..=(row + 1).min(rows - 1) {
                for column in [column + columns - 1, column, column + 1].map(|c| c % columns) {
                    let k = row * columns + column;
                    if !seen[k] && water[k] == kind {
                        seen[k] = true;
                        body.push(k);
                    }
                }
            }
        }
        all.push(body);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seas_are_blue_and_ground_is_not() {
        // Colours of the painted seas of NASA's Blue Marble, and of ground on it.
        for sea in [[17, 36, 69], [4, 14, 41], [28, 70, 128], [26, 104, 117], [25, 67, 125], [13, 36, 78], [24, 62, 107]] {
            assert!(is_blue(sea), "{sea:?}");
        }
        for land in [[78, 84, 50], [27, 42, 13], [199, 167, 120], [248, 252, 253], [96, 103, 109], [53, 51, 28], [81, 92, 60]] {
            assert!(!is_blue(land), "{land:?}");
        }
    }

    #[test]
    fn small_waters_become_land_also_across_the_date_line() {
        // A sea of two columns on either side of the date line, a lake of one pixel, an island of one pixel.
        let (columns, rows) = (16, 8);
        let sea = |k: usize| !(2..14).contains(&(k % columns)) && k != 3 * columns;
        let mut water: Vec<bool> = (0..columns * rows).map(|k| sea(k) || k == 4 * columns + 7).collect();
        let quarter = PI * 1e12;
        drop_small(&mut water, [columns, rows], 1e6, 0.9 * quarter);
        assert!((0..columns * rows).all(|k| water[k] != (2..14).contains(&(k % columns))));
        drop_small(&mut water, [columns, rows], 1e6, 1.1 * quarter);
        assert!(water.iter().all(|water| !water), "the sea is a quarter of the planet");
    }
}
