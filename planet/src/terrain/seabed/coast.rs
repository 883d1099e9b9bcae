//! Distances from the coasts of a whole planet. In: which samples of a map are water. Out: metres from each sample to the nearest of the
//! other kind, above 0 on land. By chamfer steps (Borgefors 1986), whose lengths follow from the latitude.

use std::f64::consts::PI;
use terrane_heightfield::angles::sin_cos;

/// Metres to the coast, positive on land; `most_m` (negative on water) where no coast is as near.
pub(super) fn distances(water: &[bool], size: [usize; 2], radius: f64, most_m: f32) -> Vec<f32> {
    let to = |kind: bool| {
        let mut metres: Vec<f32> = water.iter().map(|&w| if w == kind { 0.0 } else { most_m }).collect();
        let steps = Steps::new(size, radius);
        for row in 0..size[1] {
            steps.sweep(&mut metres, row, row.checked_sub(1));
        }
        for row in (0..size[1]).rev() {
            steps.sweep(&mut metres, row, Some(row + 1).filter(|&below| below < size[1]));
        }
        metres
    };
    // The coast runs between samples.
    let half = (0.5 * PI * radius / size[1] as f64) as f32;
    let from_coast = |to_other: f32| if to_other < most_m { to_other - half } else { most_m };
    let (to_water, to_land) = (to(true), to(false));
    let signed =
        |((&water, to_water), to_land): ((&bool, f32), f32)| if water { -from_coast(to_land) } else { from_coast(to_water) };
    water.iter().zip(to_water).zip(to_land).map(signed).collect()
}

/// Lengths of steps between neighbouring samples, in metres.
struct Steps {
    columns: usize,
    along: Vec<f32>,
    down: f32,
}

impl Steps {
    fn new([columns, rows]: [usize; 2], radius: f64) -> Steps {
        let down = PI * radius / rows as f64;
        let along = |row: usize| {
            let latitude = 90.0 - 180.0 * (row as f64 + 0.5) / rows as f64;
            (2.0 * PI * radius / columns as f64 * sin_cos(latitude).1) as f32
        };
        Steps { columns, along: (0..rows).map(along).collect(), down: down as f32 }
    }

    /// Brings a row up to date with the one that was before it, and with itself, around the planet both ways.
    fn sweep(&self, metres: &mut [f32], row: usize, before: Option<usize>) {
        let (columns, along) = (self.columns, self.along[row]);
        let aslant = (along * along + self.down * self.down).sqrt();
        if let Some(before) = before {
            for column in 0..columns {
                let at = |column: usize| metres[before * columns + column % columns];
                let near = (at(column + columns - 1).min(at(column + 1)) + aslant).min(at(column) + self.down);
                let own = &mut metres[row * columns + column];
                *own = own.min(near);
            }
        }
        let row = &mut metres[row * columns..][..columns];
        for k in 1..2 * columns {
            row[k % columns] = row[k % columns].min(row[(k - 1) % columns] + along);
        }
        for k in (0..2 * columns - 1).rev() {
            row[k % columns] = row[k % columns].min(row[(k + 1) % columns] + along);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_on_the_sphere_and_cross_the_date_line() {
        // Land east of the date line, 10 degrees wide, on both hemispheres.
        let (size, radius) = ([360, 180], 6.371e6);
        let water: Vec<bool> = (0..size[0] * size[1]).map(|k| k % size[0] >= 10).collect();
        let metres = distances(&water, size, radius, 1e8);
        let degree = PI * radius / 180.0;
        for (column, row, degrees) in [(4, 90, 4.5), (20, 90, -10.5), (350, 90, -9.5), (4, 30, 4.5 * 0.5)] {
            let (found, expected) = (f64::from(metres[row * size[0] + column]), degrees * degree);
            assert!((found - expected).abs() < 0.3 * degree, "{column}, {row}: {found} m, expected {expected} m");
        }
        assert!(distances(&[false; 32], [8, 4], radius, 5e5).iter().all(|&m| m == 5e5), "no sea, no coast");
        assert!(distances(&[true; 32], [8, 4], radius, 5e5).iter().all(|&m| m == -5e5), "no land, no coast");
    }
}
