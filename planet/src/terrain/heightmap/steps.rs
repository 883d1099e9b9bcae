//! Takes the steps out of heights that a format holds in few levels. In: whole levels. Out: levels as smooth as they can be where each may move
//! by half a level at most, so that coasts and ranges, which rise by many levels a sample, stay what they are.

use rayon::prelude::*;

/// How far a sample may move, in levels.
const HALF: f32 = 0.5;

/// Rounds of smoothing. What is flat over more samples than about twice this keeps a trace of its steps.
const ROUNDS: usize = 48;

/// Smooths the steps of a map's samples; `wraps` if the last column's neighbour is the first.
pub(super) fn smooth(levels: &mut Vec<f32>, [columns, rows]: [usize; 2], wraps: bool) {
    let whole = levels.clone();
    for _ in 0..ROUNDS {
        let last: &[f32] = levels;
        let next = (0..rows).into_par_iter().flat_map_iter(|row| {
            let (above, below) = (row.saturating_sub(1) * columns, (row + 1).min(rows - 1) * columns);
            let whole = &whole;
            (0..columns).map(move |column| {
                let west = if column > 0 {
                    column - 1
                } else if wraps {
                    columns - 1
                } else {
                    0
                };
                let east = if column + 1 < columns {
                    column + 1
                } else if wraps {
                    0
                } else {
                    column
                };
                let own = row * columns + column;
                let around =
                    last[row * columns + west] + last[row * columns + east] + last[above + column] + last[below + column];
                (0.5 * last[own] + 0.125 * around).clamp(whole[own] - HALF, whole[own] + HALF)
            })
        });
        *levels = next.collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stairs_become_slopes_and_cliffs_stay() {
        // A plain that rises by a level every eight samples, then a cliff of 40 levels.
        let (columns, rows) = (96, 8);
        let whole = |column: usize| if column < 80 { (column / 8) as f32 } else { 50.0 };
        let mut levels: Vec<f32> = (0..columns * rows).map(|k| whole(k % columns)).collect();
        smooth(&mut levels, [columns, rows], false);
        let row = &levels[3 * columns..][..columns];
        assert!((0..columns).all(|k| (row[k] - whole(k)).abs() <= HALF));
        let rises: Vec<f32> = row[12..68].windows(2).map(|w| w[1] - w[0]).collect();
        assert!(rises.iter().all(|rise| (0.05..0.25).contains(rise)), "an eighth of a level a sample: {rises:?}");
        assert!(row[80] - row[79] > 39.0, "the cliff stays: {}", row[80] - row[79]);
    }
}
