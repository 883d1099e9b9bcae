//! Ground on a heightmap that lies below the sea and stays dry: basins that the map closes. In: heights. Out: how firmly the sea is kept
//! out of each sample.
//!
//! Elevation data that know no sea floor have 0 at sea, and below that land; data that know it have one sea that hangs together. Either way
//! a hollow without a way to the sea, and not as deep as a sea, is land.

use std::collections::HashMap;

/// Deepest basin that is taken for land, in metres below the sea: the shore of the Dead Sea lies 430 m below.
pub(super) const DEEPEST_M: f64 = 500.0;

/// Samples by which a basin reaches over its rim, so that no sea stands on its slopes.
const RIM: usize = 2;

/// 1 where the sea is kept out, 0 elsewhere; nothing if that is nowhere. `depths` are metres below the sea's level, not above 0 where
/// there is none. A basin at the map's edge is open.
pub(super) fn dry(depths: &[f32], size: [usize; 2], wraps: bool) -> Option<Vec<f32>> {
    let bodies = bodies(depths, size, wraps);
    let largest = bodies.iter().map(|body| body.samples.len()).max()?;
    let mut dry = vec![0.0; depths.len()];
    let mut any = false;
    for body in bodies {
        let open = if wraps { body.samples.len() == largest } else { body.at_edge };
        if !open && f64::from(body.deepest) <= DEEPEST_M {
            any = true;
            body.samples.into_iter().for_each(|k| dry[k] = 1.0);
        }
    }
    for _ in 0..RIM {
        widen(&mut dry, depths, size, wraps);
    }
    any.then_some(dry)
}

/// Ground below the sea that hangs together.
struct Body {
    samples: Vec<usize>,
    deepest: f32,
    at_edge: bool,
}

fn bodies(depths: &[f32], size: [usize; 2], wraps: bool) -> Vec<Body> {
    let mut seen: Vec<bool> = depths.iter().map(|&depth| depth <= 0.0).collect();
    let mut all = Vec::new();
    for start in 0..depths.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut body = Body { samples: vec![start], deepest: 0.0, at_edge: false };
        let mut next = 0;
        while let Some(&k) = body.samples.get(next) {
            next += 1;
            body.deepest = body.deepest.max(depths[k]);
            let (column, row) = (k % size[0], k / size[0]);
            body.at_edge |= row == 0 || row + 1 == size[1] || (!wraps && (column == 0 || column + 1 == size[0]));
            for k in neighbours(k, size, wraps) {
                if !std::mem::replace(&mut seen[k], true) {
                    body.samples.push(k);
                }
            }
        }
        all.push(body);
    }
    all
}

/// Marks dry land around what is marked.
fn widen(dry: &mut [f32], depths: &[f32], size: [usize; 2], wraps: bool) {
    let mut found = HashMap::new();
    for k in (0..dry.len()).filter(|&k| dry[k] > 0.0) {
        for beside in neighbours(k, size, wraps).filter(|&k| depths[k] <= 0.0) {
            found.insert(beside, ());
        }
    }
    found.into_keys().for_each(|k| dry[k] = 1.0);
}

/// Neighbours by sides and corners.
fn neighbours(k: usize, [columns, rows]: [usize; 2], wraps: bool) -> impl Iterator<Item = usize> {
    let (column, row) = ((k % columns) as i64, (k / columns) as i64);
    let near = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
    near.into_iter().filter_map(move |(i, j)| {
        let (column, row) = (column + i, row + j);
        let column = if wraps { column.rem_euclid(columns as i64) } else { column };
        let inside = (0..columns as i64).contains(&column) && (0..rows as i64).contains(&row);
        inside.then_some((row * columns as i64 + column) as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map 16 x 8: a sea in the first four columns, and a basin of two by two samples at column 9, row 3.
    fn depths(basin_m: f32) -> Vec<f32> {
        let depth = |c: usize, r: usize| match (c, r) {
            (0..4, _) => 3000.0,
            (9..11, 3..5) => basin_m,
            _ => -100.0,
        };
        (0..128).map(|k| depth(k % 16, k / 16)).collect()
    }

    #[test]
    fn closed_basins_stay_dry_with_their_rims() {
        for wraps in [false, true] {
            let dry = dry(&depths(430.0), [16, 8], wraps).unwrap();
            let within = |k: usize| (7..13).contains(&(k % 16)) && (1..7).contains(&(k / 16));
            assert!((0..128).all(|k| (dry[k] == 1.0) == within(k)), "wraps: {wraps}");
        }
    }

    #[test]
    fn deep_and_open_basins_are_sea() {
        assert!(dry(&depths(2000.0), [16, 8], false).is_none(), "as deep as a sea");
        assert!(dry(&depths(-5.0), [16, 8], false).is_none(), "no basin");
        let mut open = depths(20.0);
        (5..8).for_each(|row| open[row * 16 + 9] = 20.0);
        assert!(dry(&open, [16, 8], false).is_none(), "at the map's edge");
        let mut joined = depths(20.0);
        (4..9).for_each(|column| joined[3 * 16 + column] = 20.0);
        assert!(dry(&joined, [16, 8], true).is_none(), "with a way to the sea");
    }
}
