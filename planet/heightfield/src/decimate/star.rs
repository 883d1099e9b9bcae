//! The neighbourhood of one vertex, gathered once and then asked what each collapse would cost.
//!
//! In: mesh and samples around a vertex. Out: the neighbour that it can collapse into with the least error. Candidates are
//! *ranked* in single precision relative to the vertex, eight samples at a time; what is chosen is measured again in double
//! precision before anything relies on it ([`super::fan`]).

use super::lanes::{Doubles, Singles, LANES};
use super::mesh::{Mesh, NONE};
use super::samples::{Sample, Samples};
use multiversion::multiversion;

/// Least doubled area, in grid cells, of a triangle that a collapse may create.
pub const LEAST_AREA: f64 = 0.05;

/// Eight samples. Spare lanes have no number, and hold the vertex.
#[derive(Clone, Copy)]
pub struct Chunk {
    /// Columns.
    pub x: Doubles,
    /// Rows.
    pub y: Doubles,
    /// What is approximated, at each.
    pub q: Doubles,
    /// Sample numbers.
    pub numbers: [u32; LANES],
}

const EMPTY: Chunk =
    Chunk { x: Doubles([0.0; LANES]), y: Doubles([0.0; LANES]), q: Doubles([0.0; LANES]), numbers: [NONE; LANES] };

/// The same relative to the vertex.
#[derive(Clone, Copy)]
struct Near {
    x: Singles,
    y: Singles,
    q: Singles,
}

/// The ring relative to the vertex, twice and a few lanes more: the ring from any neighbour on is one slice, and so are the
/// eight neighbours that come some steps after eight others.
#[derive(Default)]
struct Ring {
    x: Vec<f32>,
    y: Vec<f32>,
    q: Vec<f32>,
}

impl Ring {
    fn fill(&mut self, samples: &Samples, ring: &[u32], origin: &Sample) {
        for numbers in [&mut self.x, &mut self.y, &mut self.q] {
            numbers.clear();
        }
        for &r in ring {
            let sample = samples.at(r);
            self.x.push((sample.x - origin.x) as f32);
            self.y.push((sample.y - origin.y) as f32);
            self.q.push((sample.q - origin.q) as f32);
        }
        for numbers in [&mut self.x, &mut self.y, &mut self.q] {
            numbers.extend_from_within(..);
            numbers.extend([0.0; LANES]);
        }
    }

    fn length_squared(&self, k: usize) -> f32 {
        self.x[k] * self.x[k] + self.y[k] * self.y[k]
    }
}

/// A possible collapse.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The neighbour to collapse into.
    pub into: u32,
    /// Largest difference of depths between the new triangles and the samples below them.
    pub error: f32,
    /// What the caller's measure between samples gave for it, in the caller's unit.
    pub between: f64,
}

/// The first side of a fan's triangle, and the affine function on it. One more, with the last side, ends the fan.
#[derive(Clone, Copy, Default)]
struct Spoke {
    x: f32,
    y: f32,
    slope: [f32; 2],
}

/// The neighbours in a ring that a collapse into its vertex `p` joins to `p` by a new edge: all but those beside `p`.
pub fn opposite(ring: &[u32], p: u32) -> impl Iterator<Item = u32> + '_ {
    let at = ring.iter().position(|&r| r == p);
    let steps = move |k: usize| at.map_or(0, |at| k.abs_diff(at));
    ring.iter().enumerate().filter(move |&(k, _)| steps(k) > 1 && steps(k) != ring.len() - 1).map(|(_, &r)| r)
}

/// A gathered star. Reused, so that nothing is allocated between collapses.
#[derive(Default)]
pub struct Star {
    /// Outgoing edges, counter-clockwise.
    pub edges: Vec<u32>,
    /// Neighbours, counter-clockwise.
    pub ring: Vec<u32>,
    /// Whether the ring closes (it does not on the boundary).
    pub closed: bool,
    /// As many as were ever needed; the first `count` are in use.
    chunks: Vec<Chunk>,
    count: usize,
    origin: Sample,
    near: Vec<Near>,
    positions: Ring,
    /// For every neighbour the error at the vertex alone, infinite if it does not see the whole ring.
    at_vertex: Vec<f32>,
    spokes: Vec<Spoke>,
}

impl Star {
    /// Gathers the neighbourhood of a living vertex.
    pub fn gather(&mut self, mesh: &Mesh, samples: &Samples, v: u32) {
        self.closed = mesh.walk(v, &mut self.edges, &mut self.ring);
        self.origin = samples.at(v);
        self.count = 0;
        self.add(v, self.origin);
        for k in 0..self.edges.len() {
            let mut s = mesh.first_sample(self.edges[k]);
            while s != NONE {
                let (sample, following) = samples.at_and_next(s);
                self.add(s, sample);
                s = following;
            }
        }
        while !self.count.is_multiple_of(LANES) {
            self.add(NONE, self.origin);
        }
        self.positions.fill(samples, &self.ring, &self.origin);
    }

    /// The samples below the star, the vertex itself first.
    pub fn below(&self) -> &[Chunk] {
        &self.chunks[..self.count / LANES]
    }

    #[inline(always)]
    fn add(&mut self, number: u32, sample: Sample) {
        let (c, lane) = (self.count / LANES, self.count % LANES);
        if c == self.chunks.len() {
            self.chunks.push(EMPTY);
        }
        let chunk = &mut self.chunks[c];
        (chunk.x.0[lane], chunk.y.0[lane], chunk.q.0[lane]) = (sample.x, sample.y, sample.q);
        chunk.numbers[lane] = number;
        self.count += 1;
    }

    /// Length of the longest edge in the plane, in cells.
    pub fn longest_edge(&self) -> f32 {
        (0..self.ring.len()).map(|k| self.positions.length_squared(k)).fold(0.0, f32::max).sqrt()
    }

    /// The neighbour among those allowed whose collapse has the least error; `None` if none of them sees the whole ring. `between` measures
    /// the error between samples for the ring and a neighbour, in a unit that is `unit` in depth; the larger error counts.
    pub fn rank(&mut self, allowed: impl Fn(u32) -> bool, between: impl Fn(&[u32], u32) -> f64, unit: f64) -> Option<Candidate> {
        let count = self.ring.len();
        if count < 3 {
            return None;
        }
        self.near.clear();
        bring_near(&self.origin, &self.chunks[..self.count / LANES], &mut self.near);
        self.at_vertex.clear();
        errors_at_vertex(&self.positions, count, &mut self.at_vertex);
        for (error, &p) in self.at_vertex.iter_mut().zip(&self.ring) {
            if !allowed(p) {
                *error = f32::INFINITY;
            }
        }
        let mut best: Option<Candidate> = None;
        // Least error at the vertex first: it is nearly always the best, and the others then need no look.
        while let Some(k) = self.least_at_vertex() {
            let limit = best.map_or(f32::INFINITY, |b| b.error);
            if self.at_vertex[k] >= limit {
                break;
            }
            self.at_vertex[k] = f32::INFINITY;
            open_fan(&self.positions, k..k + count, &mut self.spokes);
            let apex = [self.positions.x[k], self.positions.y[k], self.positions.q[k]];
            if let Some(error) = largest_error(apex, &self.spokes, &mut self.near, limit) {
                let between = between(&self.ring, self.ring[k]);
                let error = error.max((between * unit) as f32);
                if error < limit {
                    best = Some(Candidate { into: self.ring[k], error, between });
                }
            }
        }
        best
    }

    /// The neighbour of least error at the vertex that is left, the nearest of equals.
    fn least_at_vertex(&self) -> Option<usize> {
        let mut least: Option<usize> = None;
        for (k, &error) in self.at_vertex.iter().enumerate() {
            let better = match least {
                None => error < f32::INFINITY,
                Some(l) if error == self.at_vertex[l] => self.positions.length_squared(k) < self.positions.length_squared(l),
                Some(l) => error < self.at_vertex[l],
            };
            if better {
                least = Some(k);
            }
        }
        least
    }
}

/// Takes samples relative to the vertex, in single precision.
#[cfg_attr(not(terrane_no_avx512), multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2")))]
#[cfg_attr(terrane_no_avx512, multiversion(targets("x86_64+avx2")))]
fn bring_near(origin: &Sample, chunks: &[Chunk], near: &mut Vec<Near>) {
    let relative = |numbers: Doubles, origin: f64| (numbers - Doubles::splat(origin)).to_singles();
    near.extend(chunks.iter().map(|chunk| Near {
        x: relative(chunk.x, origin.x),
        y: relative(chunk.y, origin.y),
        q: relative(chunk.q, origin.q),
    }));
}

/// Errors at the vertex (the origin) once it has collapsed into each of its `count` neighbours, infinite for those that do not see
/// the whole ring. Eight neighbours together: the next corner of all eight fans is the next eight neighbours of the ring.
#[cfg_attr(not(terrane_no_avx512), multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2")))]
#[cfg_attr(terrane_no_avx512, multiversion(targets("x86_64+avx2")))]
fn errors_at_vertex(ring: &Ring, count: usize, errors: &mut Vec<f32>) {
    let least_area = Singles::splat(LEAST_AREA as f32);
    let infinite = Singles::splat(f32::INFINITY);
    for first in (0..count).step_by(LANES) {
        let at = |k: usize| [&ring.x, &ring.y, &ring.q].map(|numbers| Singles::load(numbers, k));
        let apex = at(first);
        let from_apex = |p: [Singles; 3]| [p[0] - apex[0], p[1] - apex[1]];
        let cross = |a: [Singles; 2], b: [Singles; 2]| a[0] * b[1] - a[1] * b[0];
        let origin = [apex[0], apex[1]];
        let mut corner = at(first + 1);
        let mut a = from_apex(corner);
        let mut from_a = cross(origin, a);
        let mut inside = Singles::splat(f32::NEG_INFINITY);
        let (mut weighted, mut total) = (Singles::splat(0.0), Singles::splat(1.0));
        let mut hidden = Singles::splat(0.0);
        for step in 2..count {
            let next = at(first + step);
            let b = from_apex(next);
            let (from_b, area) = (cross(origin, b), cross(a, b));
            hidden = area.more_than(least_area).select(hidden, infinite);
            // The vertex lies in the triangle that it is furthest inside of; from_a and -from_b are its weights of b and a.
            let depth = from_a.min(Singles::splat(0.0) - from_b);
            let deeper = depth.more_than(inside);
            inside = deeper.select(depth, inside);
            weighted = deeper.select((next[2] - apex[2]) * from_a - (corner[2] - apex[2]) * from_b, weighted);
            total = deeper.select(area, total);
            (corner, a, from_a) = (next, b, from_b);
        }
        for lane in 0..LANES.min(count - first) {
            let error = (apex[2].0[lane] + weighted.0[lane] / total.0[lane]).abs();
            errors.push(if hidden.0[lane] > 0.0 { f32::INFINITY } else { error });
        }
    }
}

/// Fills `spokes` with the fan from the first of a stretch of the ring over the others.
fn open_fan(ring: &Ring, stretch: std::ops::Range<usize>, spokes: &mut Vec<Spoke>) {
    let (x, y, q) = (&ring.x[stretch.clone()], &ring.y[stretch.clone()], &ring.q[stretch]);
    let from_apex = |k: usize| [x[k] - x[0], y[k] - y[0], q[k] - q[0]];
    spokes.clear();
    let mut a = from_apex(1);
    for k in 2..x.len() {
        let b = from_apex(k);
        let scale = 1.0 / (a[0] * b[1] - a[1] * b[0]);
        let slope = [(a[2] * b[1] - b[2] * a[1]) * scale, (b[2] * a[0] - a[2] * b[0]) * scale];
        spokes.push(Spoke { x: a[0], y: a[1], slope });
        a = b;
    }
    spokes.push(Spoke { x: a[0], y: a[1], slope: [0.0; 2] });
}

/// Largest error of a fan over all samples, or `None` once it reaches `limit`. The chunk that was worst moves to the front, where
/// it stops the next candidate early.
#[cfg_attr(not(terrane_no_avx512), multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2")))]
#[cfg_attr(terrane_no_avx512, multiversion(targets("x86_64+avx2")))]
fn largest_error(apex: [f32; 3], spokes: &[Spoke], chunks: &mut [Near], limit: f32) -> Option<f32> {
    let (mut worst, mut worst_chunk) = (0.0f32, 0);
    for (c, chunk) in chunks.iter().enumerate() {
        let largest = errors(apex, spokes, chunk).largest();
        if largest >= limit {
            chunks.swap(0, c);
            return None;
        }
        if largest > worst {
            (worst, worst_chunk) = (largest, c);
        }
    }
    chunks.swap(0, worst_chunk);
    Some(worst)
}

/// Errors of eight samples: each belongs to the triangle whose two sides from the apex it is furthest inside of.
#[inline(always)]
fn errors(apex: [f32; 3], spokes: &[Spoke], chunk: &Near) -> Singles {
    let (x, y) = (chunk.x - Singles::splat(apex[0]), chunk.y - Singles::splat(apex[1]));
    let cross = |spoke: &Spoke| Singles::splat(spoke.x) * y - Singles::splat(spoke.y) * x;
    let mut from_a = cross(&spokes[0]);
    let mut inside = Singles::splat(f32::NEG_INFINITY);
    let (mut sx, mut sy) = (Singles::splat(0.0), Singles::splat(0.0));
    for pair in spokes.windows(2) {
        let from_b = cross(&pair[1]);
        let depth = from_a.min(Singles::splat(0.0) - from_b);
        let deeper = depth.more_than(inside);
        inside = deeper.select(depth, inside);
        sx = deeper.select(Singles::splat(pair[0].slope[0]), sx);
        sy = deeper.select(Singles::splat(pair[0].slope[1]), sy);
        from_a = from_b;
    }
    (Singles::splat(apex[2]) + sx * x + sy * y - chunk.q).abs()
}
