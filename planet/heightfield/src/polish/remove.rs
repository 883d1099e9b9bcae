//! Removes vertices where the surface is much better than at its worst, to pay for others elsewhere. In: a triangulation and the
//! peaks of its faces. Out: both, changed.

use super::mesh::{doubled_area, next, Triangulation};
use super::residual::{aspect_is_kept, peak};
use crate::Heightfield;
use rayon::prelude::*;

/// A half-edge along which its origin collapses, and the largest residual that this leaves around it.
struct Candidate {
    residual: f64,
    edge: u32,
}

/// Collapses up to `most` vertices, least harm first, that leave no residual above `limit`.
pub(super) fn remove_calm(mesh: &mut Triangulation, field: &Heightfield, peaks: &mut [f64], limit: f64, most: usize) {
    let mut candidates: Vec<Candidate> =
        (0..mesh.positions.len() as u32).into_par_iter().filter_map(|v| least_harm(mesh, field, peaks, v, limit)).collect();
    candidates.sort_by(|p, q| p.residual.total_cmp(&q.residual).then(p.edge.cmp(&q.edge)));
    let mut changed = vec![false; peaks.len()];
    let mut removed = 0;
    for candidate in candidates {
        if removed == most {
            break;
        }
        let star = if mesh.is_alive(candidate.edge / 3) { mesh.star(mesh.origin(candidate.edge)) } else { None };
        let Some(star) = star.filter(|star| star.iter().all(|&e| !changed[e as usize / 3])) else { continue };
        mesh.collapse(candidate.edge, &star);
        for face in star.into_iter().map(|e| e / 3) {
            changed[face as usize] = true;
            peaks[face as usize] = if mesh.is_alive(face) { peak(mesh.triangle(face), field) } else { 0.0 };
        }
        removed += 1;
    }
}

/// The best collapse of a vertex, if there is one with all residuals below `limit`.
fn least_harm(mesh: &Triangulation, field: &Heightfield, peaks: &[f64], v: u32, limit: f64) -> Option<Candidate> {
    let star = mesh.star(v)?;
    if star.iter().any(|&e| peaks[e as usize / 3] >= limit) {
        return None;
    }
    let mut best: Option<Candidate> = None;
    for &edge in &star {
        let bound = best.as_ref().map_or(limit, |b| b.residual);
        if let Some(residual) = harm(mesh, field, &star, edge, bound) {
            best = Some(Candidate { residual, edge });
        }
    }
    best
}

/// Largest residual after a collapse along `edge`; `None` if that turns a face around, makes a sliver or reaches `bound`.
fn harm(mesh: &Triangulation, field: &Heightfield, star: &[u32], edge: u32, bound: f64) -> Option<f64> {
    let into = mesh.origin(next(edge));
    let mut worst = 0.0f64;
    for &leaving in star {
        let [p, q] = [mesh.origin(next(leaving)), mesh.apex(leaving)];
        if p == into || q == into {
            continue;
        }
        let triangle = mesh.positions_of([into, p, q]);
        if doubled_area(triangle) <= 0.0 || !aspect_is_kept(triangle) {
            return None;
        }
        worst = worst.max(peak(triangle, field));
        if worst >= bound {
            return None;
        }
    }
    Some(worst)
}
