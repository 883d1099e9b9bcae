//! Holes in a surface where a heightfield has no data. In: the samples without data. Out: the border samples that a simplifier must
//! leave in place, so that its triangles lie wholly inside or wholly outside; and the surface without those inside.
//!
//! A hole is made of the triangles of the full grid that touch a sample without data. A collapse of a vertex removes only edges of
//! that vertex: edges between two vertices that stay remain, and so does the border.

use crate::decimate::mesh::cell_corners;
use crate::{Heightfield, TriangleSurface};
use std::collections::HashMap;

/// The samples without data of a heightfield.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holes {
    columns: usize,
    rows: usize,
    gap: Vec<bool>,
}

impl Holes {
    /// The holes of a field, if it has any.
    pub fn of(field: &Heightfield) -> Option<Holes> {
        let gap: Vec<bool> = field.heights().iter().map(|h| h.is_nan()).collect();
        gap.contains(&true).then(|| Holes { columns: field.columns(), rows: field.rows(), gap })
    }

    /// Samples without data.
    pub fn count(&self) -> usize {
        self.gap.iter().filter(|&&gap| gap).count()
    }

    /// Whether a sample has no data.
    pub fn is_gap(&self, sample: usize) -> bool {
        self.gap[sample]
    }

    /// The samples on the borders: those with data on a triangle that touches a sample without.
    pub fn border(&self) -> Vec<bool> {
        let mut border = vec![false; self.gap.len()];
        for (i, j) in (0..self.rows - 1).flat_map(|j| (0..self.columns - 1).map(move |i| (i, j))) {
            for triangle in cell_corners(self.columns, i, j) {
                if triangle.iter().any(|&v| self.gap[v as usize]) {
                    triangle.iter().filter(|&&v| !self.gap[v as usize]).for_each(|&v| border[v as usize] = true);
                }
            }
        }
        border
    }

    /// A surface without the triangles that lie in holes, in whose borders it has all vertices.
    pub fn cut(&self, surface: &TriangleSurface) -> TriangleSurface {
        let mut cut = TriangleSurface::default();
        let mut numbers: HashMap<u32, u32> = HashMap::new();
        for face in &surface.faces {
            let [a, b, c] = face.map(|v| surface.positions[v as usize]);
            let middle = (a + b + c) / 3.0;
            if self.holds(middle.x, (self.rows - 1) as f64 - middle.y) {
                continue;
            }
            cut.faces.push(face.map(|v| {
                *numbers.entry(v).or_insert_with(|| {
                    cut.positions.push(surface.positions[v as usize]);
                    cut.positions.len() as u32 - 1
                })
            }));
        }
        cut
    }

    /// Whether a place, in columns and rows, lies in a hole.
    fn holds(&self, column: f64, row: f64) -> bool {
        let cell = |at: f64, samples: usize| (at.max(0.0) as usize).min(samples - 2);
        let (i, j) = (cell(column, self.columns), cell(row, self.rows));
        let (x, y) = (column - i as f64, row - j as f64);
        let [first, second] = cell_corners(self.columns, i, j);
        // The first triangle has the edge of row j; the diagonal runs from there to the other corner.
        let in_first = if (i + j).is_multiple_of(2) { y <= x } else { y <= 1.0 - x };
        let triangle = if in_first { first } else { second };
        triangle.iter().any(|&v| self.gap[v as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plain::{simplify_around, simplify_with};
    use std::collections::HashMap;

    /// Hills with two holes, one of which reaches the edge.
    fn holed() -> Heightfield {
        let gap = |c: usize, r: usize| ((8..15).contains(&c) && (6..10 + c % 3).contains(&r)) || (c > 30 && r > 20 + c % 2);
        let height = |k: usize| {
            let (c, r) = (k % 37, k / 37);
            if gap(c, r) {
                f32::NAN
            } else {
                (c as f32 * 0.7).sin() * 3.0 + (r as f32 * 0.45).cos() * 5.0
            }
        };
        Heightfield::new(37, 29, (0..37 * 29).map(height).collect()).unwrap()
    }

    /// Edges of one face only, as positions, from a lower to a higher one.
    fn borders(surface: &TriangleSurface) -> Vec<[[u64; 3]; 2]> {
        let mut count: HashMap<[[u64; 3]; 2], usize> = HashMap::new();
        for f in &surface.faces {
            for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
                let mut ends = [a, b].map(|v| surface.positions[v as usize].to_array().map(f64::to_bits));
                ends.sort_unstable();
                *count.entry(ends).or_default() += 1;
            }
        }
        count.into_iter().filter(|(_, n)| *n == 1).map(|(ends, _)| ends).collect()
    }

    #[test]
    fn holes_keep_their_borders_at_every_level() {
        let field = holed();
        let holes = Holes::of(&field).unwrap();
        let mut filled = field.clone();
        assert_eq!(filled.fill_gaps(), holes.count());
        let collapses = simplify_around(&filled, &holes.border(), &mut |_| ()).unwrap();
        let inner = |surface: &TriangleSurface| {
            let on_side = |p: [u64; 3]| {
                let [x, y, _] = p.map(f64::from_bits);
                x == 0.0 || y == 0.0 || x == 36.0 || y == 28.0
            };
            let mut edges: Vec<_> = borders(surface).into_iter().filter(|[a, b]| !on_side(*a) || !on_side(*b)).collect();
            edges.sort_unstable();
            edges
        };
        let finest = holes.cut(&collapses.surface(&filled, 0));
        let border = inner(&finest);
        let uncovered = finest.deviation(&filled).uncovered;
        assert!(border.len() > 30 && uncovered.abs_diff(holes.count()) < 4, "{uncovered} of {}", holes.count());
        for collapsed in [100, 400, collapses.order.len()] {
            let surface = holes.cut(&collapses.surface(&filled, collapsed));
            assert_eq!(inner(&surface), border, "{collapsed} collapses");
            // What the finest surface covers every other one covers, too.
            assert_eq!(surface.deviation(&filled).uncovered, uncovered, "{collapsed} collapses");
        }
        // Without border samples that stay, borders move.
        let free = simplify_with(&filled, &mut |_| ()).unwrap();
        assert_ne!(inner(&holes.cut(&free.surface(&filled, 400))), border);
    }

    #[test]
    fn a_field_without_gaps_has_no_holes() {
        assert_eq!(Holes::of(&Heightfield::new(2, 2, vec![1.0; 4]).unwrap()), None);
    }
}
