//! Closes a surface to a solid: walls down from its rim, and a floor.
//!
//! In: triangles, counter-clockwise from outside, and where each vertex comes down. Out: the same with walls and a floor; every directed
//! edge has its opposite, whatever the surface's outline and holes.

use glam::DVec3;
use std::collections::HashMap;

/// The shape of a floor.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Floor {
    /// A plane: over a rectangle a fan of few triangles will do.
    Flat,
    /// As many triangles as the surface has, turned over.
    Curved,
}

/// The directed edges of triangles that no opposite edge cancels.
pub(super) fn rim(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let directed = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let mut edges: Vec<([u32; 2], [u32; 2])> = directed.map(|[a, b]| ([a.min(b), a.max(b)], [a, b])).collect();
    edges.sort_unstable();
    let left = |run: &[([u32; 2], [u32; 2])]| {
        let forward = run.iter().filter(|(key, edge)| key == edge).count();
        let (surplus, edge) = if 2 * forward > run.len() {
            (2 * forward - run.len(), run[0].0)
        } else {
            (run.len() - 2 * forward, [run[0].0[1], run[0].0[0]])
        };
        std::iter::repeat_n(edge, surplus)
    };
    edges.chunk_by(|a, b| a.0 == b.0).flat_map(left).collect()
}

/// Adds walls and a floor.
pub(super) fn close(positions: &mut Vec<DVec3>, triangles: &mut Vec<[u32; 3]>, down: &dyn Fn(DVec3) -> DVec3, floor: Floor) {
    let rim = rim(triangles);
    if rim.is_empty() {
        return;
    }
    let fan = floor == Floor::Flat && is_rectangle(positions, &rim);
    let surface = triangles.len();
    let mut below: HashMap<u32, u32> = HashMap::new();
    let mut beneath = |v: u32, positions: &mut Vec<DVec3>| {
        *below.entry(v).or_insert_with(|| {
            positions.push(down(positions[v as usize]));
            positions.len() as u32 - 1
        })
    };
    let mut feet = Vec::with_capacity(rim.len());
    for &[a, b] in &rim {
        let [c, d] = [beneath(a, positions), beneath(b, positions)];
        triangles.extend([[b, a, c], [b, c, d]]);
        feet.push([c, d]);
    }
    if fan {
        let middle = feet.iter().map(|f| positions[f[0] as usize]).sum::<DVec3>() / feet.len() as f64;
        positions.push(middle);
        let centre = positions.len() as u32 - 1;
        triangles.extend(feet.iter().map(|&[c, d]| [d, c, centre]));
    } else {
        for k in 0..surface {
            let [a, b, c] = triangles[k].map(|v| beneath(v, positions));
            triangles.push([b, a, c]);
        }
    }
}

/// Whether a rim is the outline of one upright rectangle in x and y: all of it lies on the sides of its box, and is as long as those.
fn is_rectangle(positions: &[DVec3], rim: &[[u32; 2]]) -> bool {
    let at = |v: u32| positions[v as usize].truncate();
    let corners = rim.iter().map(|e| at(e[0]));
    let (low, high) = corners.fold((glam::DVec2::INFINITY, glam::DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let on_a_side = |[a, b]: [u32; 2]| {
        let [a, b] = [at(a), at(b)];
        (0..2).any(|k| a[k] == b[k] && (a[k] == low[k] || a[k] == high[k]))
    };
    let length: f64 = rim.iter().map(|&[a, b]| at(a).distance(at(b))).sum();
    let around = 2.0 * (high - low).element_sum();
    rim.iter().all(|&edge| on_a_side(edge)) && (length - around).abs() <= 1e-9 * around
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 4 × 4 cells, without the cell of a number.
    fn grid(hole: Option<usize>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let height = |k: u32| f64::from(k * 7 % 5);
        let positions = (0..25).map(|k| DVec3::new(f64::from(k % 5), f64::from(k / 5), height(k))).collect();
        let cell = |k: usize| {
            let a = (k % 4 + k / 4 * 5) as u32;
            [[a, a + 1, a + 6], [a, a + 6, a + 5]]
        };
        (positions, (0..16).filter(|&k| Some(k) != hole).flat_map(cell).collect())
    }

    fn volume(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let six = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            a.dot(b.cross(c))
        });
        six.sum::<f64>() / 6.0
    }

    /// Between the triangles and the level z = -1.
    fn integral(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let prism = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b - a).truncate().perp_dot((c - a).truncate()) / 2.0 * ((a.z + b.z + c.z) / 3.0 + 1.0)
        });
        prism.sum()
    }

    #[test]
    fn solids_are_closed_and_hold_the_integral_of_the_heights() {
        for hole in [None, Some(5), Some(0), Some(2)] {
            let (mut positions, mut triangles) = grid(hole);
            let (wanted, surface) = (integral(&positions, &triangles), triangles.len());
            close(&mut positions, &mut triangles, &|p| DVec3::new(p.x, p.y, -1.0), Floor::Flat);
            assert_eq!(rim(&triangles), Vec::<[u32; 2]>::new(), "{hole:?}");
            let found = volume(&positions, &triangles);
            assert!((found - wanted).abs() < 1e-9 && found > 10.0, "{hole:?}: {found} of {wanted}");
            let floor = if hole.is_none() { 16 } else { surface };
            assert!(triangles.len() < surface + floor + 2 * 25, "{hole:?}: {} triangles", triangles.len());
            triangles.pop();
            assert_eq!(rim(&triangles).len(), 3, "a hole is seen");
        }
    }

    #[test]
    fn a_closed_surface_stays_as_it_is() {
        let mut triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        close(&mut positions, &mut triangles, &|p| p, Floor::Curved);
        assert_eq!((positions.len(), triangles.len()), (4, 4));
    }
}
