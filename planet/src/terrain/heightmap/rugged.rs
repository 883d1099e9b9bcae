//! Local relief of a heightmap: where what it leaves out is high, where low. In: samples. Out: the standard deviation, in metres, of those
//! around each.

use crate::recipe::{Layer, Recipe};
use rayon::prelude::*;

/// Samples to each side that count.
const REACH: usize = 1;

/// Whether a layer of a recipe follows local relief.
pub(super) fn is_asked_for(recipe: &Recipe) -> bool {
    let follows = |layer: &Layer| match layer {
        Layer::Mountains(mountains) => mountains.relief_m.is_some(),
        Layer::Hills(hills) => hills.relief_m.is_some(),
        _ => false,
    };
    recipe.layers.iter().any(follows)
}

/// Standard deviations, where a level is `per_level_m` metres.
pub(super) fn relief(levels: &[f32], [columns, rows]: [usize; 2], wraps: bool, per_level_m: f64) -> Vec<f32> {
    let of_row = |row: usize| {
        let near = row.saturating_sub(REACH)..=(row + REACH).min(rows - 1);
        (0..columns).map(move |column| {
            let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
            for row in near.clone() {
                for off in 0..=2 * REACH {
                    let at = column + columns + off - REACH;
                    let column = if wraps { at % columns } else { at.clamp(columns, 2 * columns - 1) - columns };
                    let level = f64::from(levels[row * columns + column]);
                    (sum, squares, count) = (sum + level, squares + level * level, count + 1.0);
                }
            }
            let mean = sum / count;
            ((squares / count - mean * mean).max(0.0).sqrt() * per_level_m) as f32
        })
    };
    (0..rows).into_par_iter().flat_map_iter(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plains_have_no_relief_and_slopes_have_theirs() {
        let (columns, rows) = (32, 8);
        let levels: Vec<f32> = (0..columns * rows).map(|k| if k % columns < 16 { 4.0 } else { (k % columns) as f32 }).collect();
        let relief = relief(&levels, [columns, rows], false, 25.0);
        let at = |column: usize| relief[3 * columns + column];
        // Three columns a level apart deviate by the square root of two thirds.
        assert!(at(8) == 0.0 && (at(24) - 25.0 * (2.0_f32 / 3.0).sqrt()).abs() < 1e-3, "{} {}", at(8), at(24));
    }
}
