//! Decimation by edge collapse, cheapest first (Hoppe 1996; Garland and Heckbert 1997), for any [`CollapseCost`]. In: a
//! heightfield's full mesh. Out: the collapses, first to last, down to the two triangles of its corners. n log n steps for n
//! vertices.
//!
//! The queue is updated lazily: edges whose ends have changed are queued again, and what was queued before is recognised by
//! its stamps and dropped. Edges that cannot collapse wait until a vertex of their ends' rings has changed.

use super::cost::{Candidate, CollapseCost};
use super::mesh::{FaceMesh, NONE};
use super::outline::Outline;
use super::split::VertexSplit;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Least area of a triangle seen from above, in cells: below, its normal is noise.
const LEAST_AREA: f64 = 1e-3;

/// An edge in the queue.
struct Entry {
    cost: f64,
    /// Squared length of the edge: between equal costs, as on level ground, the shortest goes first.
    length: f64,
    ends: [u32; 2],
    /// Which of the edge's candidates, from the cheapest.
    rank: usize,
    /// Stamps of the ends when it was queued.
    stamps: [u32; 2],
    position: DVec3,
}

impl Ord for Entry {
    /// The cheapest is the greatest; equal ones go by length and number.
    fn cmp(&self, other: &Entry) -> Ordering {
        let order = other.cost.total_cmp(&self.cost).then_with(|| other.length.total_cmp(&self.length));
        order.then_with(|| (other.ends, other.rank).cmp(&(self.ends, self.rank)))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Entry) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Entry) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

/// A decimation under way.
pub(super) struct Decimation<C> {
    /// The mesh as it stands.
    pub(super) mesh: FaceMesh,
    /// Collapses so far.
    pub(super) collapses: Vec<VertexSplit>,
    cost: C,
    outline: Outline,
    queue: BinaryHeap<Entry>,
    /// Changes of every vertex.
    stamps: Vec<u32>,
    /// Vertices with an edge that could not collapse.
    waiting: Vec<bool>,
    ring: Vec<u32>,
}

impl<C: CollapseCost> Decimation<C> {
    /// A decimation with all edges queued.
    pub(super) fn new(mesh: FaceMesh, outline: Outline, cost: C) -> Decimation<C> {
        let vertices = mesh.positions.len();
        let (stamps, waiting) = (vec![0; vertices], vec![false; vertices]);
        let (collapses, queue, ring) = (Vec::with_capacity(vertices), BinaryHeap::new(), Vec::new());
        let mut decimation = Decimation { mesh, collapses, cost, outline, queue, stamps, waiting, ring };
        for vertex in 0..vertices as u32 {
            decimation.queue_edges(vertex, |other| other > vertex);
        }
        decimation
    }

    /// Collapses edges until none is left that can. Calls `progress` with the collapses so far, now and then.
    pub(super) fn run(&mut self, progress: &mut dyn FnMut(usize)) {
        while let Some(entry) = self.queue.pop() {
            let [a, b] = entry.ends;
            if entry.stamps != [a, b].map(|v| self.stamps[v as usize]) || self.mesh.face_of[a as usize] == NONE {
                continue;
            }
            match VertexSplit::of_edge(&self.mesh, a, b, entry.position) {
                Ok(split) if !split.inverts(&self.mesh, LEAST_AREA) => {
                    self.collapse(&split);
                    if self.collapses.len().is_multiple_of(1024) {
                        progress(self.collapses.len());
                    }
                }
                // Another position may do where this one turns a triangle over.
                Ok(_) if self.queue_edge(a, b, entry.rank + 1) => {}
                _ => [a, b].into_iter().for_each(|v| self.waiting[v as usize] = true),
            }
        }
    }

    fn collapse(&mut self, split: &VertexSplit) {
        split.ecol(&mut self.mesh);
        self.cost.merge(split.vs, split.vu);
        self.outline.merge(split.vs, split.vu);
        self.collapses.push(*split);
        self.stamps[split.vs as usize] += 1;
        self.stamps[split.vu as usize] += 1;
        self.queue_edges(split.vs, |_| true);
        let mut ring = std::mem::take(&mut self.ring);
        self.mesh.ring(split.vs, &mut ring);
        for &vertex in &ring {
            if std::mem::take(&mut self.waiting[vertex as usize]) {
                self.queue_edges(vertex, |other| other != split.vs);
            }
        }
        self.ring = ring;
    }

    /// Queues the edges from a vertex to those of its ring that `take` names.
    fn queue_edges(&mut self, vertex: u32, take: impl Fn(u32) -> bool) {
        let mut ring = Vec::with_capacity(8);
        self.mesh.ring(vertex, &mut ring);
        for other in ring.into_iter().filter(|&other| take(other)) {
            self.queue_edge(vertex.min(other), vertex.max(other), 0);
        }
    }

    /// Queues an edge with its candidate of some rank; false if it has none.
    fn queue_edge(&mut self, a: u32, b: u32, rank: usize) -> bool {
        let ends = [a, b];
        let positions = ends.map(|v| self.mesh.positions[v as usize]);
        let Some(room) = self.outline.room(ends, positions) else { return false };
        let mut candidates = self.cost.candidates(ends, positions, room);
        candidates.sort_by(|x, y| x.cost.total_cmp(&y.cost));
        let Some(&Candidate { cost, position }) = candidates.get(rank) else { return false };
        let stamps = ends.map(|v| self.stamps[v as usize]);
        self.queue.push(Entry { cost, length: positions[0].distance_squared(positions[1]), ends, rank, stamps, position });
        true
    }
}
