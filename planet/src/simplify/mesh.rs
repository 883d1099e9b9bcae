//! Triangle connectivity as directed edges (Campagna, Kobbelt and Seidel 1998): face adjacency that supports half-edge
//! collapses in constant time and without allocation.
//!
//! Directed edge `3 t + i` runs from corner i of triangle t to corner i + 1. Vertices on the boundary keep the outgoing edge
//! that has no opposite, so that walking counter-clockwise from it meets the whole star.

/// No edge, vertex, triangle or sample.
pub const NONE: u32 = u32::MAX;

/// The edge after `e` around its triangle.
#[inline]
pub fn next(e: u32) -> u32 {
    if e % 3 == 2 {
        e - 2
    } else {
        e + 1
    }
}

/// The edge before `e` around its triangle.
#[inline]
pub fn previous(e: u32) -> u32 {
    if e.is_multiple_of(3) {
        e + 2
    } else {
        e - 1
    }
}

/// A manifold triangle mesh with boundary.
pub struct Mesh {
    /// Start vertex of every directed edge, three a triangle. Removed triangles hold [`NONE`].
    pub corner: Vec<u32>,
    /// The directed edge the other way, or [`NONE`] on the boundary.
    pub opposite: Vec<u32>,
    /// One outgoing edge of every living vertex (on the boundary: the one without opposite).
    pub outgoing: Vec<u32>,
}

impl Mesh {
    /// The full grid of `cells` × `cells` squares. Diagonals alternate so that those of the four corner cells pass through the
    /// patch corner (TRIALS section 3, rule 1). `cells` must be even. Vertex (i, j) has number j (cells + 1) + i.
    pub fn grid(cells: u32) -> Mesh {
        let triangles = grid_triangles(cells);
        let corner: Vec<u32> = triangles.iter().flatten().copied().collect();
        Mesh::from_corners(corner, ((cells + 1) * (cells + 1)) as usize)
    }

    fn from_corners(corner: Vec<u32>, vertices: usize) -> Mesh {
        let mut opposite = vec![NONE; corner.len()];
        let mut by_vertex: Vec<Vec<u32>> = vec![Vec::new(); vertices];
        for e in 0..corner.len() as u32 {
            by_vertex[corner[e as usize] as usize].push(e);
        }
        let mut outgoing = vec![NONE; vertices];
        for e in 0..corner.len() as u32 {
            let (a, b) = (corner[e as usize], corner[next(e) as usize]);
            let back = by_vertex[b as usize].iter().copied().find(|&f| corner[next(f) as usize] == a);
            opposite[e as usize] = back.unwrap_or(NONE);
            if outgoing[a as usize] == NONE || back.is_none() {
                outgoing[a as usize] = e;
            }
        }
        Mesh { corner, opposite, outgoing }
    }

    /// Number of triangle slots, living or removed.
    pub fn triangle_slots(&self) -> usize {
        self.corner.len() / 3
    }

    /// Outgoing edges of a vertex, counter-clockwise.
    pub fn star(&self, v: u32) -> Star<'_> {
        let first = self.outgoing[v as usize];
        Star { mesh: self, first, at: first }
    }

    /// Fills `ring` with the neighbours of `v`, counter-clockwise; true if they form a closed loop.
    pub fn ring(&self, v: u32, ring: &mut Vec<u32>) -> bool {
        ring.clear();
        let first = self.outgoing[v as usize];
        if first == NONE {
            return false;
        }
        let mut e = first;
        loop {
            ring.push(self.corner[next(e) as usize]);
            let back = previous(e);
            e = self.opposite[back as usize];
            if e == NONE {
                ring.push(self.corner[back as usize]);
                return false;
            }
            if e == first {
                return true;
            }
        }
    }

    /// Whether `a` and `b` share an edge.
    pub fn adjacent(&self, a: u32, b: u32) -> bool {
        self.star(a).any(|e| self.corner[next(e) as usize] == b || self.corner[previous(e) as usize] == b)
    }

    /// Half-edge collapse of `v` into its neighbour `p`. The caller has checked the link condition. Returns nothing: the
    /// triangles that contained both are gone, the others of `v`'s star now belong to `p`.
    pub fn collapse(&mut self, v: u32, p: u32, star: &mut Vec<u32>) {
        star.clear();
        star.extend(self.star(v));
        let (first, last) = (star[0], star[star.len() - 1]);
        let boundary = self.opposite[first as usize] == NONE;
        for &e in star.iter() {
            if self.corner[next(e) as usize] == p {
                self.close_left(e);
            } else if self.corner[previous(e) as usize] == p {
                self.close_right(e, boundary && e == last, first);
            }
        }
        for &e in star.iter() {
            let t = e / 3 * 3;
            let gone = (t..t + 3).any(|f| self.corner[f as usize] == p);
            if gone {
                (t..t + 3).for_each(|f| self.corner[f as usize] = NONE);
            } else {
                self.corner[e as usize] = p;
            }
        }
        self.outgoing[v as usize] = NONE;
    }

    /// Joins the two outer edges of the triangle (v, p, x) whose edge v → p is `e`.
    fn close_left(&mut self, e: u32) {
        let (px, xv) = (next(e), previous(e));
        let x = self.corner[xv as usize];
        let p = self.corner[px as usize];
        let (vx, xp) = (self.opposite[xv as usize], self.opposite[px as usize]);
        self.join(vx, xp);
        if self.outgoing[x as usize] == xv {
            self.outgoing[x as usize] = xp;
        }
        let leaves_from_here = self.outgoing[p as usize] == px || self.outgoing[p as usize] == self.opposite[e as usize];
        if vx != NONE && leaves_from_here {
            self.outgoing[p as usize] = vx;
        }
    }

    /// Joins the two outer edges of the triangle (v, y, p) whose edge v → y is `e`.
    fn close_right(&mut self, e: u32, on_boundary: bool, first: u32) {
        let yp = next(e);
        let y = self.corner[yp as usize];
        let p = self.corner[previous(e) as usize];
        let (yv, py) = (self.opposite[e as usize], self.opposite[yp as usize]);
        self.join(yv, py);
        if self.outgoing[y as usize] == yp {
            self.outgoing[y as usize] = yv;
        }
        if on_boundary {
            self.outgoing[p as usize] = first;
        }
    }

    fn join(&mut self, a: u32, b: u32) {
        if a != NONE {
            self.opposite[a as usize] = b;
        }
        if b != NONE {
            self.opposite[b as usize] = a;
        }
    }
}

/// Triangles of the full grid, two a cell, row by row.
pub fn grid_triangles(cells: u32) -> Vec<[u32; 3]> {
    let row = cells + 1;
    let mut triangles = Vec::with_capacity((2 * cells * cells) as usize);
    for y in 0..cells {
        for x in 0..cells {
            let (a, b, c, d) = (y * row + x, y * row + x + 1, (y + 1) * row + x, (y + 1) * row + x + 1);
            let pair = if (x + y) % 2 == 0 { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] };
            triangles.extend(pair);
        }
    }
    triangles
}

/// Iterator over the outgoing edges of a vertex.
pub struct Star<'a> {
    mesh: &'a Mesh,
    first: u32,
    at: u32,
}

impl Iterator for Star<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let e = self.at;
        if e == NONE {
            return None;
        }
        let following = self.mesh.opposite[previous(e) as usize];
        self.at = if following == self.first { NONE } else { following };
        Some(e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every edge has its opposite, every star its outgoing edge, and the Euler characteristic is that of a disc.
    fn validate(mesh: &Mesh) {
        let mut edges = 0;
        let mut triangles = 0;
        for e in 0..mesh.corner.len() as u32 {
            let (a, b) = (mesh.corner[e as usize], mesh.corner[next(e) as usize]);
            if a == NONE {
                continue;
            }
            triangles += u32::from(e % 3 == 0);
            match mesh.opposite[e as usize] {
                NONE => {
                    assert_eq!(mesh.outgoing[a as usize], e, "boundary vertex {a} starts at its boundary edge");
                    edges += 2;
                }
                f => {
                    assert_eq!((mesh.corner[f as usize], mesh.corner[next(f) as usize]), (b, a));
                    assert_eq!(mesh.opposite[f as usize], e);
                    edges += 1;
                }
            }
        }
        let living: Vec<u32> = (0..mesh.outgoing.len() as u32).filter(|&v| mesh.outgoing[v as usize] != NONE).collect();
        for &v in &living {
            assert_eq!(mesh.corner[mesh.outgoing[v as usize] as usize], v);
        }
        assert_eq!(living.len() as i32 - edges / 2 + triangles as i32, 1);
    }

    #[test]
    fn rings_are_counter_clockwise_and_complete() {
        let mesh = Mesh::grid(4);
        let mut ring = Vec::new();
        assert!(mesh.ring(12, &mut ring));
        assert!(ring.len() == 4 || ring.len() == 8);
        assert!(!mesh.ring(2, &mut ring));
        assert_eq!((ring[0], *ring.last().unwrap()), (3, 1));
        validate(&mesh);
    }

    #[test]
    fn collapses_inside_and_along_the_border_keep_the_mesh_valid() {
        let mut mesh = Mesh::grid(4);
        let mut star = Vec::new();
        for (v, p) in [(12, 6), (2, 3), (10, 5), (22, 23), (14, 19), (11, 6), (7, 6)] {
            assert!(mesh.adjacent(v, p), "{v} {p}");
            mesh.collapse(v, p, &mut star);
            validate(&mesh);
        }
    }
}
