//! Inserts vertices at the worst samples of the worst faces. In: a triangulation and the peaks of its faces. Out: both, changed.

use super::mesh::{doubled_area, Triangulation};
use super::residual::{for_each_residual, peak};
use super::{largest, INSERT_ABOVE};
use crate::Heightfield;
use glam::DVec3;
use rayon::prelude::*;

/// Where a vertex may go.
struct Candidate {
    residual: f64,
    /// Half way between the ground and the surface: at the ground it would pull its neighbourhood too far.
    height: f64,
    face: u32,
    sample: usize,
}

/// Inserts vertices, worst first, where residuals are above [`INSERT_ABOVE`] of the largest and at least `least` (as far as there
/// are samples for them) until there are `faces`.
pub(super) fn insert_worst(mesh: &mut Triangulation, field: &Heightfield, peaks: &mut Vec<f64>, least: usize, faces: usize) {
    let bar = INSERT_ABOVE * largest(peaks);
    let wanted = |residual: f64| residual > bar || least > 0;
    let mut candidates: Vec<Candidate> = (0..peaks.len() as u32)
        .into_par_iter()
        .filter(|&face| mesh.is_alive(face) && wanted(peaks[face as usize]))
        .filter_map(|face| worst_sample(mesh, field, face))
        .filter(|candidate| wanted(candidate.residual))
        .collect();
    candidates.sort_by(|p, q| q.residual.total_cmp(&p.residual).then(p.face.cmp(&q.face)));
    let mut changed = vec![false; peaks.len()];
    let mut inserted = 0;
    for candidate in candidates {
        if mesh.count() + 2 > faces || (candidate.residual <= bar && inserted >= least) {
            break;
        }
        inserted += usize::from(insert(mesh, field, &candidate, &mut changed, peaks));
    }
}

/// The sample of a face with the largest residual, vertices left out.
fn worst_sample(mesh: &Triangulation, field: &Heightfield, face: u32) -> Option<Candidate> {
    let triangle = mesh.triangle(face);
    let mut worst: Option<Candidate> = None;
    for_each_residual(triangle, field, |sample, residual| {
        let height = f64::from(field.heights()[sample]) + 0.5 * residual;
        let residual = residual.abs();
        if worst.as_ref().is_none_or(|w| residual > w.residual) && !triangle.iter().any(|&v| is_at(v, field.position(sample))) {
            worst = Some(Candidate { residual, height, face, sample });
        }
    });
    worst
}

fn is_at(vertex: DVec3, position: DVec3) -> bool {
    vertex.x == position.x && vertex.y == position.y
}

/// Inserts one vertex unless a face that it needs has just been changed.
fn insert(
    mesh: &mut Triangulation,
    field: &Heightfield,
    candidate: &Candidate,
    changed: &mut Vec<bool>,
    peaks: &mut Vec<f64>,
) -> bool {
    let position = field.position(candidate.sample).with_z(candidate.height);
    let [a, b, c] = mesh.triangle(candidate.face);
    let on_edge = [[a, b, position], [b, c, position], [c, a, position]].iter().position(|&part| doubled_area(part) == 0.0);
    let edge = on_edge.map(|k| 3 * candidate.face + k as u32);
    let twin = edge.and_then(|edge| mesh.twin(edge));
    let beside = twin.map_or(candidate.face, |twin| twin / 3);
    if changed[candidate.face as usize] || changed[beside as usize] {
        return false;
    }
    let touched = match edge {
        None => mesh.split_face(candidate.face, position),
        Some(edge) => mesh.split_edge(edge, position),
    };
    changed.resize(mesh.capacity(), false);
    peaks.resize(mesh.capacity(), 0.0);
    for face in touched {
        changed[face as usize] = true;
        peaks[face as usize] = peak(mesh.triangle(face), field);
    }
    true
}
