//! The vertical error of a triangle surface at every sample of a heightfield, measured apart from whatever built the surface:
//! each triangle is scan-converted over the samples that it covers. In: a surface and the field that it stands for, in the
//! same coordinates. Out: the largest and the root mean square error, and how many samples lie under no triangle.

use crate::raster::for_each_row;
use crate::{Heightfield, TriangleSurface};
use glam::DVec3;

/// How far a surface is from the samples of a heightfield, vertically and in the unit of its heights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Largest error at any covered sample.
    pub max: f64,
    /// Root mean square error over the covered samples.
    pub rms: f64,
    /// Samples with data that no triangle covers.
    pub uncovered: usize,
}

impl TriangleSurface {
    /// The vertical error of this surface at all samples of `field` that have data. A sample under several triangles counts
    /// once in the mean and with its largest error in the maximum. Triangles without area seen from above cover nothing.
    ///
    /// # Panics
    /// If a face names a vertex that is not there.
    pub fn deviation(&self, field: &Heightfield) -> Deviation {
        let mut tally = Tally { field, seen: vec![false; field.heights().len()], covered: 0, max: 0.0, sum: 0.0 };
        for face in &self.faces {
            tally.add(face.map(|v| self.positions[v as usize]));
        }
        let data = field.heights().iter().filter(|height| !height.is_nan()).count();
        let rms = if tally.covered == 0 { 0.0 } else { (tally.sum / tally.covered as f64).sqrt() };
        Deviation { max: tally.max, rms, uncovered: data - tally.covered }
    }
}

/// Errors so far.
struct Tally<'a> {
    field: &'a Heightfield,
    seen: Vec<bool>,
    covered: usize,
    max: f64,
    sum: f64,
}

impl Tally<'_> {
    fn add(&mut self, triangle: [DVec3; 3]) {
        let [a, b, c] = triangle;
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        if area == 0.0 || area.is_nan() {
            return;
        }
        let last = (self.field.rows() - 1) as f64;
        for_each_row(triangle, last, |y, west, east| self.add_span(y, west, east));
    }

    /// Adds the samples of row `y` between the two ends of a span.
    fn add_span(&mut self, y: f64, west: DVec3, east: DVec3) {
        let (columns, rows) = (self.field.columns(), self.field.rows());
        let (first, last) = (west.x.ceil().max(0.0), east.x.floor().min((columns - 1) as f64));
        if last < first {
            return;
        }
        let width = east.x - west.x;
        let slope = if width > 0.0 { (east.z - west.z) / width } else { 0.0 };
        let row = (rows - 1 - y as usize) * columns;
        for column in first as usize..=last as usize {
            let sample = row + column;
            let height = west.z + (column as f64 - west.x) * slope;
            let error = (height - f64::from(self.field.heights()[sample])).abs();
            // Without data, or under a vertex that has no height.
            if error.is_nan() {
                continue;
            }
            self.max = self.max.max(error);
            if !std::mem::replace(&mut self.seen[sample], true) {
                self.covered += 1;
                self.sum += error * error;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A field of heights `height(x, y)`, y counted from the south.
    fn field(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> Heightfield {
        let sample = |i: usize| height((i % columns) as f64, (rows - 1 - i / columns) as f64) as f32;
        Heightfield::new(columns, rows, (0..columns * rows).map(sample).collect()).unwrap()
    }

    /// The rectangle of a field as a fan around `hub`, with the heights `height(x, y)`.
    fn fan(field: &Heightfield, hub: (f64, f64), height: impl Fn(f64, f64) -> f64) -> TriangleSurface {
        let (east, north) = ((field.columns() - 1) as f64, (field.rows() - 1) as f64);
        let plan = [(0.0, 0.0), (east, 0.0), (east, north), (0.0, north), hub];
        let positions = plan.iter().map(|&(x, y)| DVec3::new(x, y, height(x, y))).collect();
        TriangleSurface { positions, faces: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]] }
    }

    fn plane(x: f64, y: f64) -> f64 {
        3.0 + 0.5 * x - 0.25 * y
    }

    proptest! {
        #[test]
        fn no_sample_falls_between_triangles_and_planes_have_no_error(
            columns in 2usize..20, rows in 2usize..20, x in 0.01..0.99f64, y in 0.01..0.99f64
        ) {
            let field = field(columns, rows, plane);
            let hub = (x * (columns - 1) as f64, y * (rows - 1) as f64);
            let deviation = fan(&field, hub, plane).deviation(&field);
            prop_assert_eq!(deviation.uncovered, 0);
            prop_assert!(deviation.max < 1e-12, "{deviation:?}");
        }
    }

    #[test]
    fn one_wrong_sample_is_found_wherever_it_is() {
        let flat = field(9, 7, plane);
        for wrong in 0..63 {
            let mut heights = flat.heights().to_vec();
            heights[wrong] += 0.5;
            let field = Heightfield::new(9, 7, heights).unwrap();
            let deviation = fan(&flat, (3.3, 2.7), plane).deviation(&field);
            assert!((deviation.max - 0.5).abs() < 1e-12, "sample {wrong}: {deviation:?}");
            assert!((deviation.rms - 0.5 / 63.0f64.sqrt()).abs() < 1e-12, "sample {wrong}: {deviation:?}");
        }
    }

    #[test]
    fn a_missing_triangle_and_a_hole_in_the_surface_leave_samples_uncovered() {
        let field = field(9, 9, plane);
        let mut surface = fan(&field, (4.0, 4.0), plane);
        surface.faces.pop();
        // The western quarter without its two shared edges.
        assert_eq!(surface.deviation(&field).uncovered, 16);
        surface.faces.clear();
        assert_eq!(surface.deviation(&field), Deviation { max: 0.0, rms: 0.0, uncovered: 81 });
    }

    #[test]
    fn samples_without_data_count_nowhere_but_surfaces_without_height_do_not_cover() {
        let full = field(5, 5, plane);
        let mut heights = full.heights().to_vec();
        heights[7] = f32::NAN;
        let holed = Heightfield::new(5, 5, heights).unwrap();
        assert_eq!(fan(&full, (2.0, 2.0), plane).deviation(&holed).uncovered, 0);
        let mut surface = fan(&full, (2.0, 2.0), plane);
        surface.positions.iter_mut().for_each(|p| p.z = f64::NAN);
        assert_eq!(surface.deviation(&full).uncovered, 25);
    }

    #[test]
    fn rows_are_counted_from_the_north() {
        let field = field(4, 6, |_, y| y);
        assert_eq!(fan(&field, (1.5, 2.5), |_, y| y).deviation(&field).max, 0.0);
        assert_eq!(fan(&field, (1.5, 2.5), |_, y| 5.0 - y).deviation(&field).max, 5.0);
    }

    #[test]
    fn triangles_may_reach_beyond_the_field() {
        let field = field(4, 4, plane);
        let corners = [(-9.0, -7.0), (20.0, -7.5), (-4.0, 30.0)];
        let positions = corners.map(|(x, y)| DVec3::new(x, y, plane(x, y))).to_vec();
        let deviation = TriangleSurface { positions, faces: vec![[0, 1, 2]] }.deviation(&field);
        assert_eq!(deviation.uncovered, 0);
        assert!(deviation.max < 1e-12);
    }
}
