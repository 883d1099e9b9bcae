//! Polished surfaces of plain heightfields. In: a sequence of collapses and the field that it simplifies. Out: the best surface
//! known with so many faces, or with the fewest faces found for a largest error.

use crate::plain::HalfEdgeCollapses;
use crate::polish::{polish, START_SHARE};
use crate::{Heightfield, TriangleSurface};

/// How often a number of faces is tried for a largest error.
const TRIES: usize = 4;

/// Largest error of a polished surface over that of an unpolished one with as many faces, as first guess.
const TYPICAL_RATIO: f64 = 0.75;

/// Guesses aim at this share of the wanted largest error, as a guess that ends just above it is lost.
const AIM: f64 = 0.99;

impl HalfEdgeCollapses {
    /// The surface with at most `faces` faces (and at least one less; the outline needs two) whose largest error is lowest:
    /// polished, or straight from the collapses if that is better. Vertices stand on samples but need not have their heights.
    ///
    /// # Panics
    /// For another heightfield than was simplified.
    pub fn polished(&self, field: &Heightfield, faces: usize) -> TriangleSurface {
        let surface = self.surface(field, self.collapses_to(faces));
        let start = self.surface(field, self.collapses_to((faces as f64 * START_SHARE) as usize));
        let polished = polish(start, field, faces);
        let better = polished.faces.len() <= faces && polished.deviation(field).max < surface.deviation(field).max;
        if better {
            polished
        } else {
            surface
        }
    }

    /// A surface whose largest error is at most `error`, with the fewest faces that a few tries find; the full grid if `error` is
    /// less than any surface has.
    ///
    /// # Panics
    /// For another heightfield than was simplified.
    pub fn polished_within(&self, field: &Heightfield, error: f64) -> TriangleSurface {
        let mut best = self.surface(field, self.collapses_within(error));
        let mut ratio = TYPICAL_RATIO;
        for _ in 0..TRIES {
            let faces = self.faces_after(self.collapses_within(AIM * error / ratio));
            if faces >= best.faces.len() {
                break;
            }
            let surface = self.polished(field, faces);
            let found = surface.deviation(field).max;
            if found <= error {
                best = surface;
            }
            let next = ratio * found / (AIM * error);
            if next == ratio {
                break;
            }
            ratio = next;
        }
        best
    }

    /// How many collapses, from the start, have errors of at most `error`.
    pub fn collapses_within(&self, error: f64) -> usize {
        self.order.iter().take_while(|&&v| f64::from(self.error[v as usize]) <= error).count()
    }
}

#[cfg(test)]
mod tests {
    use super::super::plain::simplify;
    use super::*;

    fn field(columns: usize, rows: usize) -> Heightfield {
        let height = |x: f64, y: f64| (x * 0.7).sin() * 3.0 + (y * 0.45 + x * 0.2).cos() * 5.0 + (x * y * 0.05).sin().abs();
        let at = |k: usize| height((k % columns) as f64, (k / columns) as f64) as f32;
        Heightfield::new(columns, rows, (0..columns * rows).map(at).collect()).unwrap()
    }

    /// Why a surface is no triangulation of the rectangle with its vertices on samples.
    fn flaw(surface: &TriangleSurface, field: &Heightfield) -> Option<&'static str> {
        let (east, north) = ((field.columns() - 1) as f64, (field.rows() - 1) as f64);
        let mut area = 0.0;
        for face in &surface.faces {
            let [a, b, c] = face.map(|v| surface.positions[v as usize].truncate());
            let doubled = (b - a).perp_dot(c - a);
            if doubled <= 0.0 {
                return Some("inverted");
            }
            area += doubled;
        }
        let corner = |x: f64, y: f64| surface.positions.iter().any(|p| (p.x, p.y) == (x, y));
        let corners = corner(0.0, 0.0) && corner(east, 0.0) && corner(0.0, north) && corner(east, north);
        if area != 2.0 * east * north {
            Some("area")
        } else if surface.deviation(field).uncovered != 0 {
            Some("uncovered")
        } else if !corners || surface.positions.iter().any(|p| p.x.fract() != 0.0 || p.y.fract() != 0.0) {
            Some("positions")
        } else {
            None
        }
    }

    #[test]
    fn polish_keeps_the_triangulation_and_the_face_count() {
        for (columns, rows) in [(65, 65), (40, 23), (9, 70), (5, 5), (2, 9), (2, 2)] {
            let field = field(columns, rows);
            let collapses = simplify(&field).unwrap();
            for faces in [2, 3, 20, 21, 150, 1000, 3000, 1_000_000] {
                let surface = collapses.polished(&field, faces);
                assert_eq!(flaw(&surface, &field), None, "{columns} x {rows}, {faces} faces");
                let possible = faces.min(collapses.most_faces());
                assert!(surface.faces.len() <= possible && surface.faces.len() + 2 > possible, "{columns} x {rows}: {}", faces);
            }
        }
    }

    #[test]
    fn a_damaged_triangulation_is_found() {
        let field = field(33, 33);
        let whole = simplify(&field).unwrap().polished(&field, 300);
        assert_eq!(flaw(&whole, &field), None);
        let mut turned = whole.clone();
        turned.faces[7].swap(0, 1);
        assert_eq!(flaw(&turned, &field), Some("inverted"));
        let mut holed = whole.clone();
        holed.faces.pop();
        assert_eq!(flaw(&holed, &field), Some("area"));
        let mut moved = whole;
        let inside = moved.positions.iter().position(|p| p.x > 0.0 && p.x < 32.0 && p.y > 0.0 && p.y < 32.0).unwrap();
        moved.positions[inside].x += 0.001;
        assert!(flaw(&moved, &field).is_some());
    }

    #[test]
    fn polish_lowers_the_error_by_more_than_a_tenth() {
        let field = field(129, 129);
        let collapses = simplify(&field).unwrap();
        for faces in [300, 1600, 6500] {
            let raw = collapses.surface(&field, collapses.collapses_to(faces)).deviation(&field).max;
            let polished = collapses.polished(&field, faces).deviation(&field).max;
            assert!(polished < 0.9 * raw, "{faces} faces: {polished} of {raw}");
        }
    }

    #[test]
    fn polish_is_the_same_on_any_number_of_threads() {
        let field = field(65, 65);
        let collapses = simplify(&field).unwrap();
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| collapses.polished(&field, 500))
        };
        let alone = on(1);
        assert!(alone == on(3));
        assert!(alone != collapses.polished(&field, 498));
    }

    #[test]
    fn polish_within_an_error_needs_fewer_faces_than_collapses_alone() {
        let field = field(65, 65);
        let collapses = simplify(&field).unwrap();
        for error in [0.05, 0.4, 2.0] {
            let surface = collapses.polished_within(&field, error);
            assert!(surface.deviation(&field).max <= error, "{error}");
            assert_eq!(flaw(&surface, &field), None);
            let raw = collapses.faces_after(collapses.collapses_within(error));
            assert!((surface.faces.len() as f64) < 0.95 * raw as f64, "{error}: {} of {raw} faces", surface.faces.len());
        }
        assert_eq!(collapses.polished_within(&field, -1.0).faces.len(), collapses.most_faces());
        assert_eq!(collapses.polished_within(&field, 1e9).faces.len(), 2);
    }

    #[test]
    fn polish_keeps_flat_ground_exact() {
        let flat = Heightfield::new(9, 9, vec![4.0; 81]).unwrap();
        let surface = simplify(&flat).unwrap().polished(&flat, 20);
        assert_eq!((flaw(&surface, &flat), surface.deviation(&flat).max), (None, 0.0));
    }
}
