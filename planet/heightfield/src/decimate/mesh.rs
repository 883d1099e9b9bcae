//! Triangle connectivity as directed edges (Campagna, Kobbelt and Seidel 1998): face adjacency that supports half-edge
//! collapses in constant time and without allocation.
//!
//! Directed edge `4 t + i` (i = 0, 1, 2) runs from corner i of triangle t to the next corner. Vertices on the boundary keep the
//! outgoing edge that has no opposite, so that walking counter-clockwise from it meets the whole star.

/// No edge, vertex, triangle or sample.
pub const NONE: u32 = u32::MAX;

/// The edge after `e` around its triangle.
#[inline(always)]
pub fn next(e: u32) -> u32 {
    if e & 3 == 2 {
        e - 2
    } else {
        e + 1
    }
}

/// The edge before `e` around its triangle.
#[inline(always)]
pub fn previous(e: u32) -> u32 {
    if e & 3 == 0 {
        e + 2
    } else {
        e - 1
    }
}

/// A triangle and what is known about it, in half a cache line: walks around a vertex touch nothing else.
#[derive(Clone, Copy, Debug)]
struct Triangle {
    /// Start vertices of its directed edges; [`NONE`] once it is removed. The fourth is unused.
    corner: [u32; 4],
    /// The directed edges the other way, [`NONE`] on the boundary. The fourth is the first removed sample below the triangle.
    opposite: [u32; 4],
}

/// A manifold triangle mesh with boundary over a grid.
pub struct Mesh {
    triangles: Vec<Triangle>,
    /// One outgoing edge of every living vertex (on the boundary: the one without opposite).
    outgoing: Vec<u32>,
}

impl Mesh {
    /// The full grid of `columns` × `rows` vertices. Diagonals alternate; with an even number of cells a side, those of the
    /// four corner cells pass through the corner (docs/design.md, "Borders", builder rule 1). Vertex (i, j) has number
    /// `j columns + i`.
    pub fn grid(columns: usize, rows: usize) -> Mesh {
        let (across, along) = (columns - 1, rows - 1);
        let mut mesh = Mesh { triangles: Vec::with_capacity(2 * across * along), outgoing: vec![NONE; columns * rows] };
        for j in 0..along {
            for i in 0..across {
                let cell = GridCell { across, along, i, j };
                mesh.triangles.extend(cell.triangles(columns));
            }
        }
        for e in (0..mesh.triangles.len() as u32).flat_map(|t| 4 * t..4 * t + 3) {
            let outgoing = &mut mesh.outgoing[mesh.triangles[(e >> 2) as usize].corner[(e & 3) as usize] as usize];
            if *outgoing == NONE || mesh.triangles[(e >> 2) as usize].opposite[(e & 3) as usize] == NONE {
                *outgoing = e;
            }
        }
        mesh
    }

    /// Start vertex of a directed edge, [`NONE`] if its triangle is gone.
    #[inline(always)]
    pub fn corner(&self, e: u32) -> u32 {
        self.triangles[(e >> 2) as usize].corner[(e & 3) as usize]
    }

    /// End vertex of a directed edge.
    #[inline(always)]
    pub fn end(&self, e: u32) -> u32 {
        self.corner(next(e))
    }

    /// The directed edge the other way, [`NONE`] on the boundary.
    #[inline(always)]
    pub fn opposite(&self, e: u32) -> u32 {
        self.triangles[(e >> 2) as usize].opposite[(e & 3) as usize]
    }

    /// One outgoing edge of a vertex, [`NONE`] if it is gone.
    #[inline(always)]
    pub fn outgoing(&self, v: u32) -> u32 {
        self.outgoing[v as usize]
    }

    /// First removed sample below the triangle of an edge.
    #[inline(always)]
    pub fn first_sample(&self, e: u32) -> u32 {
        self.triangles[(e >> 2) as usize].opposite[3]
    }

    /// Sets the first removed sample below the triangle of an edge.
    #[inline(always)]
    pub fn set_first_sample(&mut self, e: u32, sample: u32) {
        self.triangles[(e >> 2) as usize].opposite[3] = sample;
    }

    /// Corners of the living triangles.
    pub fn faces(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().filter(|t| t.corner[0] != NONE).map(|t| [t.corner[0], t.corner[1], t.corner[2]])
    }

    /// Outgoing edges of a vertex, counter-clockwise.
    pub fn star(&self, v: u32) -> Star<'_> {
        let first = self.outgoing[v as usize];
        Star { mesh: self, first, at: first }
    }

    /// Fills `star` with the outgoing edges of `v` and `ring` with its neighbours, both counter-clockwise; true if they close.
    #[inline]
    pub fn walk(&self, v: u32, star: &mut Vec<u32>, ring: &mut Vec<u32>) -> bool {
        star.clear();
        ring.clear();
        let first = self.outgoing[v as usize];
        let mut e = first;
        loop {
            star.push(e);
            ring.push(self.end(e));
            let back = previous(e);
            e = self.opposite(back);
            if e == first {
                return true;
            }
            if e == NONE {
                ring.push(self.corner(back));
                return false;
            }
        }
    }

    /// Half-edge collapse of `v` into its neighbour `p`; `star` holds all outgoing edges of `v` ([`Mesh::walk`]). The triangles
    /// that contained both are gone, the others now belong to `p`: `star` keeps their edges, in the same order. The caller
    /// answers for the link condition: in a plane it holds whenever p sees the whole ring of v.
    pub fn collapse(&mut self, v: u32, p: u32, star: &mut Vec<u32>) {
        let (first, last) = (star[0], star[star.len() - 1]);
        let boundary = self.opposite(first) == NONE;
        for &e in star.iter() {
            if self.end(e) == p {
                self.close_left(e);
            } else if self.corner(previous(e)) == p {
                self.close_right(e, boundary && e == last, first);
            }
        }
        star.retain(|&e| {
            let triangle = &mut self.triangles[(e >> 2) as usize];
            let gone = triangle.corner[..3].contains(&p);
            if gone {
                triangle.corner = [NONE; 4];
            } else {
                triangle.corner[(e & 3) as usize] = p;
            }
            !gone
        });
        self.outgoing[v as usize] = NONE;
    }

    /// Joins the two outer edges of the triangle (v, p, x) whose edge v → p is `e`.
    fn close_left(&mut self, e: u32) {
        let (px, xv) = (next(e), previous(e));
        let (x, p) = (self.corner(xv) as usize, self.corner(px) as usize);
        let (vx, xp) = (self.opposite(xv), self.opposite(px));
        self.join(vx, xp);
        if self.outgoing[x] == xv {
            self.outgoing[x] = xp;
        }
        let leaves_from_here = self.outgoing[p] == px || self.outgoing[p] == self.opposite(e);
        if vx != NONE && leaves_from_here {
            self.outgoing[p] = vx;
        }
    }

    /// Joins the two outer edges of the triangle (v, y, p) whose edge v → y is `e`.
    fn close_right(&mut self, e: u32, on_boundary: bool, first: u32) {
        let yp = next(e);
        let (y, p) = (self.corner(yp) as usize, self.corner(previous(e)) as usize);
        let (yv, py) = (self.opposite(e), self.opposite(yp));
        self.join(yv, py);
        if self.outgoing[y] == yp {
            self.outgoing[y] = yv;
        }
        if on_boundary {
            self.outgoing[p] = first;
        }
    }

    fn join(&mut self, a: u32, b: u32) {
        if a != NONE {
            self.triangles[(a >> 2) as usize].opposite[(a & 3) as usize] = b;
        }
        if b != NONE {
            self.triangles[(b >> 2) as usize].opposite[(b & 3) as usize] = a;
        }
    }
}

/// A square of the grid and its column and row.
struct GridCell {
    across: usize,
    along: usize,
    i: usize,
    j: usize,
}

impl GridCell {
    /// The two triangles with their neighbours.
    fn triangles(&self, columns: usize) -> [Triangle; 2] {
        let cell = (self.j * self.across + self.i) as u32;
        let (lower, upper) = (8 * cell, 8 * cell + 4);
        let below = if self.j > 0 { upper - 8 * self.across as u32 } else { NONE };
        let above = if self.j + 1 < self.along { lower + 8 * self.across as u32 } else { NONE };
        let left = if self.i > 0 { lower - 8 } else { NONE };
        let right = if self.i + 1 < self.across { lower + 8 } else { NONE };
        let edge = |base: u32, e: u32| if base == NONE { NONE } else { base + e };
        let [first, second] = cell_corners(columns, self.i, self.j).map(|[a, b, c]| [a, b, c, NONE]);
        // Edges: a neighbour below or above is reached through its top or bottom edge, which depends on its own parity only.
        if (self.i + self.j).is_multiple_of(2) {
            // (a b d), (a d c); left and right cells are odd: (a b c), (b d c), their sides are edges 0 of the upper and 2 of the lower.
            [
                Triangle { corner: first, opposite: [edge(below, 1), edge(right, 2), upper, NONE] },
                Triangle { corner: second, opposite: [lower + 2, edge(above, 0), edge(left, 4), NONE] },
            ]
        } else {
            // (a b c), (b d c); left and right cells are even: their right side is edge 1 of the lower, their left edge 2 of the upper.
            [
                Triangle { corner: first, opposite: [edge(below, 1), upper + 2, edge(left, 1), NONE] },
                Triangle { corner: second, opposite: [edge(right, 6), edge(above, 0), lower + 1, NONE] },
            ]
        }
    }
}

/// Triangles of the full grid, two a cell, row by row.
pub fn grid_triangles(cells: u32) -> Vec<[u32; 3]> {
    let cells = cells as usize;
    let mut triangles = Vec::with_capacity(2 * cells * cells);
    for j in 0..cells {
        for i in 0..cells {
            triangles.extend(cell_corners(cells + 1, i, j));
        }
    }
    triangles
}

/// Corners of the two triangles of cell (i, j) of a grid. In even cells the diagonal rises from (i, j), in odd ones it falls towards
/// (i + 1, j); either way the first triangle has the bottom edge and the second one the top edge.
pub fn cell_corners(columns: usize, i: usize, j: usize) -> [[u32; 3]; 2] {
    let a = (j * columns + i) as u32;
    let (b, c, d) = (a + 1, a + columns as u32, a + columns as u32 + 1);
    if (i + j).is_multiple_of(2) {
        [[a, b, d], [a, d, c]]
    } else {
        [[a, b, c], [b, d, c]]
    }
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
        let following = self.mesh.opposite(previous(e));
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
        for e in (0..mesh.triangles.len() as u32).flat_map(|t| 4 * t..4 * t + 3) {
            let a = mesh.corner(e);
            if a == NONE {
                continue;
            }
            triangles += u32::from(e % 4 == 0);
            match mesh.opposite(e) {
                NONE => {
                    assert_eq!(mesh.outgoing(a), e, "boundary vertex {a} starts at its boundary edge");
                    edges += 2;
                }
                f => {
                    assert_eq!((mesh.corner(f), mesh.end(f)), (mesh.end(e), a));
                    assert_eq!(mesh.opposite(f), e);
                    edges += 1;
                }
            }
        }
        let living: Vec<u32> = (0..mesh.outgoing.len() as u32).filter(|&v| mesh.outgoing(v) != NONE).collect();
        for &v in &living {
            assert_eq!(mesh.corner(mesh.outgoing(v)), v);
        }
        assert_eq!(living.len() as i32 - edges / 2 + triangles as i32, 1);
    }

    #[test]
    fn the_grid_has_the_triangles_of_the_drawn_one() {
        let mesh = Mesh::grid(5, 5);
        assert!(mesh.faces().eq(grid_triangles(4)));
        for (columns, rows) in [(2, 2), (2, 3), (3, 2), (4, 7), (5, 5)] {
            validate(&Mesh::grid(columns, rows));
        }
    }

    #[test]
    fn rings_are_counter_clockwise_and_complete() {
        let mesh = Mesh::grid(5, 5);
        let (mut star, mut ring) = (Vec::new(), Vec::new());
        assert!(mesh.walk(12, &mut star, &mut ring));
        assert!(ring.len() == 4 || ring.len() == 8);
        assert!(!mesh.walk(2, &mut star, &mut ring));
        assert_eq!((ring[0], *ring.last().unwrap()), (3, 1));
    }

    #[test]
    fn collapses_inside_and_along_the_border_keep_the_mesh_valid() {
        let mut mesh = Mesh::grid(5, 5);
        let (mut star, mut ring) = (Vec::new(), Vec::new());
        for (v, p) in [(12, 6), (2, 3), (10, 5), (22, 23), (14, 19), (11, 6), (7, 6)] {
            mesh.walk(v, &mut star, &mut ring);
            assert!(ring.contains(&p), "{v} {p}");
            mesh.collapse(v, p, &mut star);
            validate(&mesh);
        }
    }
}
