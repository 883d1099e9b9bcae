//! The measured-error simplifier of plain heightfields: half-edge collapses by rising error, down to the four corners.
//!
//! In: a heightfield. Out: the whole sequence of collapses, from which the surface at any number of faces follows. The error of
//! every collapse is measured at all samples below its new triangles; the queue is lazy, as in the builder of patches.

use crate::decimate::decimator::Decimator;
use crate::decimate::mesh::{Mesh, NONE};
use crate::decimate::queue::Queue;
use crate::decimate::samples::{Samples, MOST_SAMPLES_A_SIDE};
use crate::{Heightfield, TriangleSurface};
use thiserror::Error;

/// Share of the height range that the longest edge of the whole field adds to an order by error, so that flat ground coarsens
/// evenly instead of from one end.
const EVENNESS: f64 = 1e-6;

/// Samples along the side of the tiles that the queue keeps together; all about one fits a second-level cache.
const TILE: usize = 64;

/// Collapses between two reports of progress.
const PROGRESS_EVERY: usize = 1 << 14;

/// Why a heightfield cannot be simplified.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PlainError {
    /// A sample that is no number.
    #[error("no height at column {column}, row {row}; fill samples without data before simplifying")]
    NoData {
        /// Its column.
        column: usize,
        /// Its row.
        row: usize,
    },
    /// More samples a side than are counted.
    #[error("{columns} x {rows} samples, expected at most {MOST_SAMPLES_A_SIDE} a side")]
    TooLarge {
        /// Columns found.
        columns: usize,
        /// Rows found.
        rows: usize,
    },
}

/// A whole sequence of half-edge collapses over a heightfield. Vertices have the numbers of samples, `row * columns + column`.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfEdgeCollapses {
    /// Samples from west to east.
    pub columns: usize,
    /// Samples from north to south.
    pub rows: usize,
    /// Vertices in order of collapse: all but the four corners.
    pub order: Vec<u32>,
    /// The neighbour that each vertex collapsed into; itself if it never did.
    pub parent: Vec<u32>,
    /// Largest error at any sample below the triangles that each vertex's collapse made, in the unit of the heights; infinite for
    /// those that never did.
    pub error: Vec<f32>,
}

/// What may happen to a vertex.
#[derive(Clone, Copy, PartialEq, Eq)]
enum VertexKind {
    Inside,
    /// Collapses along its side only.
    Side,
    /// Never collapses.
    Corner,
}

/// What the queue knows of a vertex.
#[derive(Clone, Copy)]
struct Entry {
    key: f32,
    /// Largest key of the collapses that this vertex's own comes after, and once it is done its own.
    reached: f32,
    into: u32,
    queued: bool,
    fresh: bool,
}

struct Simplifier {
    decimator: Decimator,
    entries: Vec<Entry>,
    queue: Queue,
    /// Vertices that never collapse, beside the corners; none if empty.
    kept: Vec<bool>,
    /// Height that a cell of edge length adds to a key.
    evenness: f32,
    result: HalfEdgeCollapses,
}

/// Simplifies a heightfield down to its corners.
///
/// # Errors
/// As [`simplify_with`].
pub fn simplify(field: &Heightfield) -> Result<HalfEdgeCollapses, PlainError> {
    simplify_with(field, &mut |_| ())
}

/// Simplifies a heightfield down to its corners. `progress` is told now and then how many vertices have collapsed.
///
/// # Errors
/// For samples without data, and for more than [`MOST_SAMPLES_A_SIDE`] samples a side.
pub fn simplify_with(field: &Heightfield, progress: &mut dyn FnMut(usize)) -> Result<HalfEdgeCollapses, PlainError> {
    simplify_around(field, &[], progress)
}

/// The same, down to the corners and to some vertices that are kept: edges between these stay, too. `kept` has one entry a sample,
/// or none.
///
/// # Errors
/// As [`simplify_with`].
pub fn simplify_around(
    field: &Heightfield,
    kept: &[bool],
    progress: &mut dyn FnMut(usize),
) -> Result<HalfEdgeCollapses, PlainError> {
    let (columns, rows) = (field.columns(), field.rows());
    if columns.max(rows) > MOST_SAMPLES_A_SIDE {
        return Err(PlainError::TooLarge { columns, rows });
    }
    if let Some(sample) = field.heights().iter().position(|h| !h.is_finite()) {
        return Err(PlainError::NoData { column: sample % columns, row: sample / columns });
    }
    let mut simplifier = Simplifier::new(field);
    simplifier.kept = kept.to_vec();
    simplifier.run(progress);
    Ok(simplifier.result)
}

impl Simplifier {
    fn new(field: &Heightfield) -> Simplifier {
        let (columns, rows) = (field.columns(), field.rows());
        let count = columns * rows;
        let line = |length: usize| (0..length).map(|k| k as f64).collect();
        let samples = Samples::new(line(columns), line(rows), field.heights().iter().map(|&h| f64::from(h)));
        let low = field.heights().iter().copied().fold(f32::INFINITY, f32::min);
        let high = field.heights().iter().copied().fold(f32::NEG_INFINITY, f32::max);
        // Any positive number does on ground that is flat as a whole.
        let range = if high > low { f64::from(high) - f64::from(low) } else { 1.0 };
        let result = HalfEdgeCollapses {
            columns,
            rows,
            order: Vec::with_capacity(count),
            parent: (0..count as u32).collect(),
            error: vec![f32::INFINITY; count],
        };
        Simplifier {
            decimator: Decimator::new(samples, columns, rows),
            entries: vec![Entry { key: 0.0, reached: 0.0, into: NONE, queued: false, fresh: false }; count],
            queue: Queue::new(),
            kept: Vec::new(),
            evenness: (EVENNESS * range / columns.max(rows) as f64) as f32,
            result,
        }
    }

    fn run(&mut self, progress: &mut dyn FnMut(usize)) {
        (0..self.entries.len() as u32).for_each(|v| self.enqueue(v));
        let mut told = 0;
        while let Some(v) = self.queue.pop() {
            self.entries[v as usize].queued = false;
            if self.decimator.is_alive(v) {
                self.visit(v);
            }
            let done = self.result.order.len();
            if done >= told + PROGRESS_EVERY {
                progress(done);
                told = done;
            }
        }
        // The queue goes tile by tile; what depends on each other already stands in order.
        let entries = &self.entries;
        self.result.order.sort_by(|&a, &b| entries[a as usize].reached.total_cmp(&entries[b as usize].reached));
    }

    fn tile(&self, v: u32) -> u32 {
        let (column, row) = (v as usize % self.result.columns, v as usize / self.result.columns);
        (row / TILE * self.result.columns.div_ceil(TILE) + column / TILE) as u32
    }

    /// Puts a vertex into the queue unless it is there.
    fn enqueue(&mut self, v: u32) {
        let stays = self.result.kind(v) == VertexKind::Corner || self.kept.get(v as usize) == Some(&true);
        if !self.entries[v as usize].queued && !stays {
            let entry = &mut self.entries[v as usize];
            entry.queued = true;
            let key = entry.key;
            self.queue.push(key, self.tile(v), v);
        }
    }

    /// Collapses a vertex if it is its turn, or puts it back if its key has risen. One that sees no way waits for its ring to change.
    fn visit(&mut self, v: u32) {
        self.decimator.gather(v);
        if !self.entries[v as usize].fresh {
            let Some((into, key)) = self.rank(v) else { return };
            let entry = &mut self.entries[v as usize];
            *entry = Entry { key: key.max(entry.key), into, fresh: true, ..*entry };
            if !self.queue.is_due(key) {
                return self.enqueue(v);
            }
        }
        self.perform_collapse(v);
    }

    fn rank(&mut self, v: u32) -> Option<(u32, f32)> {
        let side = self.result.kind(v) == VertexKind::Side;
        let ring = &self.decimator.star.ring;
        let ends = [ring[0], ring[ring.len() - 1]];
        let best = self.decimator.rank(|p| !side || ends.contains(&p))?;
        Some((best.into, best.error + self.evenness * self.decimator.star.longest_edge()))
    }

    fn perform_collapse(&mut self, v: u32) {
        let into = self.entries[v as usize].into;
        let error = self.decimator.measure(into, |_, own, depth| (depth - own).abs());
        self.result.error[v as usize] = error as f32;
        self.result.parent[v as usize] = into;
        self.result.order.push(v);
        let entry = &mut self.entries[v as usize];
        entry.reached = entry.reached.max(error as f32);
        let reached = entry.reached;
        self.decimator.collapse(v, into);
        for k in 0..self.decimator.star.ring.len() {
            let r = self.decimator.star.ring[k];
            let entry = &mut self.entries[r as usize];
            entry.fresh = false;
            entry.reached = entry.reached.max(reached);
            self.enqueue(r);
        }
    }
}

impl HalfEdgeCollapses {
    /// Faces of the full grid.
    pub fn most_faces(&self) -> usize {
        2 * (self.columns - 1) * (self.rows - 1)
    }

    /// How many collapses, from the start, leave at most so many faces (all of them, for fewer than two).
    pub fn collapses_to(&self, faces: usize) -> usize {
        let mut left = self.most_faces();
        let still_more = |&v: &u32| {
            let more = left > faces;
            left -= self.faces_of(v);
            more
        };
        self.order.iter().copied().take_while(still_more).count()
    }

    /// Faces that are left after so many collapses.
    pub fn faces_after(&self, collapses: usize) -> usize {
        self.most_faces() - self.order[..collapses].iter().map(|&v| self.faces_of(v)).sum::<usize>()
    }

    /// Faces that the collapse of a vertex removes.
    fn faces_of(&self, v: u32) -> usize {
        match self.kind(v) {
            VertexKind::Inside => 2,
            VertexKind::Side | VertexKind::Corner => 1,
        }
    }

    fn kind(&self, v: u32) -> VertexKind {
        let (i, j) = (v as usize % self.columns, v as usize / self.columns);
        let at_end = |k: usize, length: usize| k == 0 || k == length - 1;
        match (at_end(i, self.columns), at_end(j, self.rows)) {
            (false, false) => VertexKind::Inside,
            (true, true) => VertexKind::Corner,
            _ => VertexKind::Side,
        }
    }

    /// The surface after so many collapses, in the coordinates of [`Heightfield::position`].
    ///
    /// # Panics
    /// For another heightfield than was simplified, or more collapses than there are.
    pub fn surface(&self, field: &Heightfield, collapses: usize) -> TriangleSurface {
        assert_eq!((self.columns, self.rows), (field.columns(), field.rows()));
        let mut root: Vec<u32> = (0..self.parent.len() as u32).collect();
        for &v in self.order[..collapses].iter().rev() {
            root[v as usize] = root[self.parent[v as usize] as usize];
        }
        let mut number = vec![NONE; root.len()];
        let mut surface = TriangleSurface::default();
        for face in Mesh::grid(self.columns, self.rows).faces() {
            // Rows run south in samples and north in space, which turns triangles around.
            let [a, c, b] = face.map(|v| root[v as usize]);
            if a != b && b != c && c != a {
                surface.faces.push([a, b, c].map(|v| number_of(v, &mut number, &mut surface.positions, field)));
            }
        }
        surface
    }
}

fn number_of(v: u32, number: &mut [u32], positions: &mut Vec<glam::DVec3>, field: &Heightfield) -> u32 {
    let known = &mut number[v as usize];
    if *known == NONE {
        *known = positions.len() as u32;
        positions.push(field.position(v as usize));
    }
    *known
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> Heightfield {
        let at = |k: usize| height((k % columns) as f64, (k / columns) as f64) as f32;
        Heightfield::new(columns, rows, (0..columns * rows).map(at).collect()).unwrap()
    }

    fn hills(columns: usize, rows: usize) -> Heightfield {
        field(columns, rows, |x, y| (x * 0.7).sin() * 3.0 + (y * 0.45 + x * 0.2).cos() * 5.0 + (x * y * 0.05).sin())
    }

    #[test]
    fn all_vertices_but_the_corners_collapse() {
        for (columns, rows) in [(2, 2), (2, 9), (3, 3), (17, 17), (40, 23)] {
            for flat in [false, true] {
                let field = if flat { field(columns, rows, |_, _| 4.0) } else { hills(columns, rows) };
                let collapses = simplify(&field).unwrap();
                assert_eq!(collapses.order.len(), columns * rows - 4, "{columns} x {rows}");
                assert_eq!(collapses.surface(&field, collapses.order.len()).faces.len(), 2);
            }
        }
    }

    #[test]
    fn the_measured_error_is_at_most_the_recorded_one() {
        let field = hills(40, 33);
        let collapses = simplify(&field).unwrap();
        for faces in [2000, 500, 100, 2] {
            let count = collapses.collapses_to(faces);
            let surface = collapses.surface(&field, count);
            assert!(surface.faces.len() <= faces && surface.faces.len() + 2 > faces);
            let measured = surface.deviation(&field);
            let recorded = collapses.order[..count].iter().map(|&v| collapses.error[v as usize]).fold(0.0, f32::max);
            assert_eq!(measured.uncovered, 0);
            assert!(measured.max <= f64::from(recorded) * (1.0 + 1e-6) + 1e-6, "{} > {recorded}", measured.max);
        }
    }

    #[test]
    fn flat_ground_coarsens_evenly() {
        let field = field(33, 33, |_, _| 0.0);
        let collapses = simplify(&field).unwrap();
        let surface = collapses.surface(&field, collapses.collapses_to(200));
        let longest = surface.faces.iter().flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]);
        let length = |(a, b): (u32, u32)| surface.positions[a as usize].distance(surface.positions[b as usize]);
        let longest = longest.map(length).fold(0.0, f64::max);
        assert!(longest < 13.0, "an edge of {longest} cells among 200 faces on 32 x 32 cells");
    }

    #[test]
    fn missing_samples_are_refused() {
        let mut heights = vec![1.0; 9];
        heights[5] = f32::NAN;
        let field = Heightfield::new(3, 3, heights).unwrap();
        assert_eq!(simplify(&field), Err(PlainError::NoData { column: 2, row: 1 }));
    }
}
