//! The neighbourhood of one vertex, gathered once and then asked what each collapse would cost.
//!
//! In: mesh and samples around a vertex. Out: the neighbour that it can collapse into with the least error. Candidates are
//! *ranked* in single precision relative to the vertex, eight samples at a time; what is chosen is measured again in double
//! precision before anything relies on it ([`super::fan`]).

use super::mesh::{Mesh, NONE};
use super::samples::Samples;
use multiversion::multiversion;

/// Least doubled area, in grid cells, of a triangle that a collapse may create.
pub const LEAST_AREA: f64 = 0.05;

/// Samples evaluated together.
const LANES: usize = 8;

/// Samples relative to the vertex; spare places repeat the first one.
#[derive(Clone, Copy)]
struct Chunk {
    x: [f32; LANES],
    y: [f32; LANES],
    q: [f32; LANES],
}

/// A place relative to the vertex.
#[derive(Clone, Copy, Default)]
struct Place {
    x: f32,
    y: f32,
    q: f32,
}

impl Place {
    #[inline(always)]
    fn minus(self, other: Place) -> Place {
        Place { x: self.x - other.x, y: self.y - other.y, q: self.q - other.q }
    }

    #[inline(always)]
    fn length_squared(self) -> f32 {
        self.x * self.x + self.y * self.y
    }

    #[inline(always)]
    fn cross(self, other: Place) -> f32 {
        self.x * other.y - self.y * other.x
    }
}

/// A possible collapse.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The neighbour to collapse into.
    pub into: u32,
    /// Largest difference of depths between the new triangles and the samples below them.
    pub error: f32,
}

/// One side of the next triangle of a fan, and the affine function on the triangle after it.
#[derive(Clone, Copy, Default)]
struct Spoke {
    x: f32,
    y: f32,
    slope: [f32; 2],
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
    /// The samples below the star, the vertex itself first.
    pub below: Vec<u32>,
    /// The ring twice, so that the ring from any neighbour on is one slice.
    places: Vec<Place>,
    chunks: Vec<Chunk>,
    /// Neighbours that see the whole ring: error at the vertex alone, squared distance, place in the ring.
    open: Vec<(f32, f32, u32)>,
    spokes: Vec<Spoke>,
}

impl Star {
    /// Gathers the neighbourhood of a living vertex.
    pub fn gather(&mut self, mesh: &Mesh, samples: &Samples, v: u32) {
        self.closed = mesh.walk(v, &mut self.edges, &mut self.ring);
        self.below.clear();
        self.below.push(v);
        for &e in &self.edges {
            let mut s = mesh.first_sample(e);
            while s != NONE {
                self.below.push(s);
                s = samples.next(s);
            }
        }
    }

    /// The neighbour among those allowed whose collapse has the least error; `None` if none of them sees the whole ring.
    pub fn rank(&mut self, samples: &Samples, allowed: impl Fn(u32) -> bool) -> Option<Candidate> {
        self.place(samples);
        self.open.clear();
        for k in 0..self.ring.len() {
            if allowed(self.ring[k]) {
                if let Some(error) = error_at_vertex(&self.places[k..k + self.ring.len()]) {
                    self.open.push((error, self.places[k].length_squared(), k as u32));
                }
            }
        }
        // Least error at the vertex first: it is nearly always the best, and the others then stop early. Of equals the nearest.
        self.open.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut best: Option<Candidate> = None;
        for &(at_vertex, _, k) in &self.open {
            let limit = best.map_or(f32::INFINITY, |b| b.error);
            if at_vertex >= limit {
                break;
            }
            let ring = &self.places[k as usize..k as usize + self.ring.len()];
            if let Some(error) = fan_error(ring, &mut self.chunks, &mut self.spokes, limit) {
                best = Some(Candidate { into: self.ring[k as usize], error });
            }
        }
        best
    }

    /// Length of the ranked star's longest edge in the plane, in cells.
    pub fn longest_edge(&self) -> f32 {
        self.places.iter().map(|p| p.length_squared()).fold(0.0, f32::max).sqrt()
    }

    /// Brings ring and samples into single precision relative to the vertex.
    fn place(&mut self, samples: &Samples) {
        let origin = samples.at(self.below[0]);
        let relative = |s: u32| {
            let sample = samples.at(s);
            Place { x: (sample.x - origin.x) as f32, y: (sample.y - origin.y) as f32, q: (sample.q - origin.q) as f32 }
        };
        self.places.clear();
        self.places.extend(self.ring.iter().map(|&r| relative(r)));
        self.places.extend_from_within(..);
        self.chunks.clear();
        for group in self.below.chunks(LANES) {
            let mut chunk = Chunk { x: [0.0; LANES], y: [0.0; LANES], q: [0.0; LANES] };
            for (lane, &s) in group.iter().enumerate() {
                let place = relative(s);
                (chunk.x[lane], chunk.y[lane], chunk.q[lane]) = (place.x, place.y, place.q);
            }
            self.chunks.push(chunk);
        }
    }
}

/// Error at the vertex itself (the origin) once it has collapsed into the first of the ring, or `None` where that does not see
/// all of the ring.
#[inline(always)]
fn error_at_vertex(ring: &[Place]) -> Option<f32> {
    let apex = ring[0];
    let mut a = ring[1].minus(apex);
    let mut found = 0.0;
    let mut inside = f32::NEG_INFINITY;
    for place in &ring[2..] {
        let b = place.minus(apex);
        let area = a.cross(b);
        if area <= LEAST_AREA as f32 {
            return None;
        }
        // The vertex lies in the triangle that it is furthest inside of; barycentric weights of a and b.
        let (wb, wa) = (-(a.x * apex.y - a.y * apex.x), -(apex.x * b.y - apex.y * b.x));
        if wa.min(wb) > inside {
            inside = wa.min(wb);
            found = apex.q + (a.q * wa + b.q * wb) / area;
        }
        a = b;
    }
    Some(found.abs())
}

/// Largest error of the fan from the first of the ring over all samples, or `None` once it reaches `limit`. The chunk that was
/// worst moves to the front, where it stops the next candidate early.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq+avx512bw", "x86_64+avx2"))]
fn fan_error(ring: &[Place], chunks: &mut [Chunk], spokes: &mut Vec<Spoke>, limit: f32) -> Option<f32> {
    let apex = ring[0];
    spokes.clear();
    for pair in ring[1..].windows(2) {
        let (a, b) = (pair[0].minus(apex), pair[1].minus(apex));
        let scale = 1.0 / a.cross(b);
        let slope = [(a.q * b.y - b.q * a.y) * scale, (b.q * a.x - a.q * b.x) * scale];
        spokes.push(Spoke { x: a.x, y: a.y, slope });
    }
    let (first, last) = (ring[1].minus(apex), ring[ring.len() - 1].minus(apex));
    let wide = first.cross(last) <= 0.0;
    let (mut worst, mut worst_chunk) = (0.0f32, 0);
    for (c, chunk) in chunks.iter().enumerate() {
        let errors = if wide { errors_of_wide_fan(apex, spokes, last, chunk) } else { errors_of_fan(apex, spokes, chunk) };
        let largest = errors.iter().copied().fold(0.0, f32::max);
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

/// Errors of eight samples below a fan narrower than half a turn: a sample belongs to the last spoke that it is left of.
#[inline(always)]
fn errors_of_fan(apex: Place, spokes: &[Spoke], chunk: &Chunk) -> [f32; LANES] {
    let (mut x, mut y) = (chunk.x, chunk.y);
    let (mut sx, mut sy) = ([spokes[0].slope[0]; LANES], [spokes[0].slope[1]; LANES]);
    for lane in 0..LANES {
        x[lane] -= apex.x;
        y[lane] -= apex.y;
    }
    for spoke in &spokes[1..] {
        for lane in 0..LANES {
            let left = spoke.x * y[lane] - spoke.y * x[lane] >= 0.0;
            sx[lane] = if left { spoke.slope[0] } else { sx[lane] };
            sy[lane] = if left { spoke.slope[1] } else { sy[lane] };
        }
    }
    let mut errors = [0.0; LANES];
    for lane in 0..LANES {
        errors[lane] = (apex.q + sx[lane] * x[lane] + sy[lane] * y[lane] - chunk.q[lane]).abs();
    }
    errors
}

/// The same for any fan: a sample belongs to the triangle whose two sides it is furthest inside of.
#[inline(always)]
fn errors_of_wide_fan(apex: Place, spokes: &[Spoke], last: Place, chunk: &Chunk) -> [f32; LANES] {
    let mut errors = [0.0; LANES];
    for lane in 0..LANES {
        let (x, y) = (chunk.x[lane] - apex.x, chunk.y[lane] - apex.y);
        let (mut inside, mut slope) = (f32::NEG_INFINITY, [0.0; 2]);
        for (k, spoke) in spokes.iter().enumerate() {
            let end = spokes.get(k + 1).map_or([last.x, last.y], |s| [s.x, s.y]);
            let depth = (spoke.x * y - spoke.y * x).min(x * end[1] - y * end[0]);
            if depth > inside {
                (inside, slope) = (depth, spoke.slope);
            }
        }
        errors[lane] = (apex.q + slope[0] * x + slope[1] * y - chunk.q[lane]).abs();
    }
    errors
}
