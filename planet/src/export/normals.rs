//! Normals of the ground at the vertices of a mesh: from heights, by central differences, and not from the triangles, so that a coarse
//! mesh is lit like the ground that it stands for.

use super::Welded;
use crate::ground::{Ground, NormalSite};
use glam::DVec3;
use rayon::prelude::*;
use terrane_heightfield::{Heightfield, TriangleSurface};

/// Vertices whose heights are asked for together.
const CHUNK: usize = 1024;

/// Normals at the vertices of a surface over a field, from the samples beside the nearest one; `scale` as in
/// [`super::Model::of_heightfield`].
pub(super) fn of_heightfield(surface: &TriangleSurface, field: &Heightfield, scale: DVec3) -> Vec<DVec3> {
    surface.positions.iter().map(|p| at_sample(field, p.x, p.y, scale)).collect()
}

/// Normal at a place in sample spacings from the south-west, by the samples on both sides; on an edge of the field by the one inside.
pub(super) fn at_sample(field: &Heightfield, x: f64, y: f64, scale: DVec3) -> DVec3 {
    let last = [field.columns() - 1, field.rows() - 1];
    let [column, north] = [(x.round().max(0.0) as usize).min(last[0]), (y.round().max(0.0) as usize).min(last[1])];
    let [along, across] = slopes_at(field, [column, last[1] - north], scale);
    DVec3::new(-along, -across, 1.0).normalize()
}

/// How much the ground rises a metre east and north at a sample.
pub(super) fn slopes_at(field: &Heightfield, [column, row]: [usize; 2], scale: DVec3) -> [f64; 2] {
    let last = [field.columns() - 1, field.rows() - 1];
    let [west, east] = [column.saturating_sub(1), (column + 1).min(last[0])];
    let [above, below] = [row.saturating_sub(1), (row + 1).min(last[1])];
    let height = |column: usize, row: usize| f64::from(field.at(column, row)) * scale.z;
    let rise = |from: f64, to: f64, metres: f64| if (to - from).is_finite() { (to - from) / metres } else { 0.0 };
    let along = rise(height(west, row), height(east, row), (east - west) as f64 * scale.x);
    let across = rise(height(column, below), height(column, above), (below - above) as f64 * scale.y);
    [along, across]
}

/// Normals at the vertices of a planet's surface, between points one sample spacing to each side.
pub(super) fn of_planet(surface: &Welded, ground: &Ground) -> Vec<DVec3> {
    let chunks = surface.positions.par_chunks(CHUNK).zip(surface.levels.par_chunks(CHUNK));
    let chunk = |(positions, levels): (&[glam::IVec3], &[u8])| {
        let sites = positions.iter().zip(levels).map(|(p, &level)| {
            let spacing = ground.lattice.sample_spacing(ground.cells, level) * ground.lattice.unit;
            NormalSite { up: p.as_dvec3().normalize_or_zero(), spacing }
        });
        ground.normals(&sites.collect::<Vec<_>>())
    };
    chunks.flat_map_iter(chunk).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_has_its_normal_everywhere_and_a_coarse_mesh_that_of_the_samples() {
        // 2 m up a column of 4 m, 3 units of 2 m down a row of 12 m (so up towards the north by a half).
        let heights = (0..20).map(|k| (k % 5) as f32 - 3.0 * (k / 5) as f32).collect();
        let field = Heightfield::new(5, 4, heights).unwrap();
        let scale = DVec3::new(4.0, 12.0, 2.0);
        for (x, y) in [(0.0, 0.0), (4.0, 3.0), (2.0, 1.0), (1.4, 2.6)] {
            let n = at_sample(&field, x, y, scale);
            assert!((n - DVec3::new(-0.5, -0.5, 1.0).normalize()).length() < 1e-9, "{x} {y}: {n}");
        }
        // A ridge that a mesh of two flat triangles does not have.
        let ridge = Heightfield::new(3, 2, vec![0.0, 1.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
        assert_eq!(at_sample(&ridge, 1.0, 0.0, DVec3::ONE), DVec3::Z);
        assert!(at_sample(&ridge, 0.0, 0.0, DVec3::ONE).x < -0.7);
    }
}
