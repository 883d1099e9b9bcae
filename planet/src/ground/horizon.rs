//! Shadows and ambient light of the relief: how high the ground around every vertex of a patch rises towards the sun, and how much of
//! the sky it leaves. Horizon mapping (Max 1988) along the one azimuth that counts, from the terrain and never from the mesh.
//!
//! In: the surroundings of a patch and of its ancestors, and the sun. Out: [`HorizonMap`]. What lies up to 8 cells away is looked up in
//! samples as dense as the patch's own, what lies up to 16 in those of its parent's density, and so on: which samples count follows from
//! the distance alone, so that neighbours of one level agree where they meet.

use super::surroundings::{Surroundings, MARGIN};
use super::Ground;
use crate::globe::patch::PatchId;
use glam::DVec3;
use std::sync::Arc;

/// Cells away, in a patch's own density.
const NEAR: [f32; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

/// Cells away in every coarser density: the next octave of distance.
const FAR: [f32; 6] = [4.5, 5.1, 5.7, 6.4, 7.2, 8.0];

/// Coarser densities that are looked up for every vertex; those beyond change so slowly that every fourth vertex will do.
const FINE_LEVELS: usize = 2;

/// Vertices between those that look far.
const COARSE_STEP: usize = 4;

/// Azimuths around a vertex along which the sky is measured, and cells away in the patch's own density and in coarser ones.
const SKY_AZIMUTHS: usize = 8;
const SKY_NEAR: [f32; 3] = [2.0, 4.0, 7.0];
const SKY_FAR: [f32; 2] = [5.0, 7.0];
/// Densities in which it is.
const SKY_LEVELS: usize = 4;

/// Coarsest level that is looked up: whole faces have no straight lines.
const COARSEST: u8 = 2;

/// Radians beyond which no mountain of a planet's size stands out any more.
const FARTHEST: f64 = 0.12;

/// Vertices looked up for at a time.
const RUN: usize = 16;

/// Horizon angles and ambient occlusion at the vertices of a patch, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct HorizonMap {
    /// Sine of the elevation of the horizon towards the sun: ground there hides whatever is lower. Below 0 where the ground falls away.
    pub horizon: Vec<f32>,
    /// Share of the light of an even sky that reaches level ground, 0 to 1.
    pub sky: Vec<f32>,
}

impl HorizonMap {
    /// The map of a patch. `sun` is a unit vector; `around` gives the surroundings of the patch and of its ancestors.
    pub fn new(ground: &Ground, id: PatchId, sun: DVec3, around: &mut dyn FnMut(PatchId) -> Arc<Surroundings>) -> HorizonMap {
        let chain = Chain::new(ground, id, around);
        let row = ground.cells as usize + 1;
        let every: Vec<usize> = (0..row).collect();
        let coarse: Vec<usize> = (0..=row.div_ceil(COARSE_STEP)).map(|k| (COARSE_STEP * k).min(row - 1)).collect();
        let (mut far, mut open) = (Vec::new(), Vec::new());
        for &y in &coarse {
            let vertices = chain.vertices(&coarse, y);
            far.extend(chain.steepest(&vertices, &towards(&vertices, |_| sun), &chain.far()));
            open.extend(chain.sky(&vertices));
        }
        let (far, open) = (Coarse { values: far, side: coarse.len() }, Coarse { values: open, side: coarse.len() });
        let near = chain.near();
        let mut map = HorizonMap { horizon: Vec::with_capacity(row * row), sky: Vec::with_capacity(row * row) };
        for y in 0..row {
            let vertices = chain.vertices(&every, y);
            for (x, near) in chain.steepest(&vertices, &towards(&vertices, |_| sun), &near).into_iter().enumerate() {
                let tangent = near.max(far.at(x, y));
                map.horizon.push(tangent / (1.0 + tangent * tangent).sqrt());
                map.sky.push(open.at(x, y));
            }
        }
        map
    }
}

/// Values at every [`COARSE_STEP`]th vertex, row by row.
struct Coarse {
    values: Vec<f32>,
    side: usize,
}

impl Coarse {
    /// Between them, bilinearly.
    fn at(&self, x: usize, y: usize) -> f32 {
        let (column, line) = (x / COARSE_STEP, y / COARSE_STEP);
        let (u, v) = ((x % COARSE_STEP) as f32 / COARSE_STEP as f32, (y % COARSE_STEP) as f32 / COARSE_STEP as f32);
        let at = |x: usize, y: usize| self.values[y.min(self.side - 1) * self.side + x.min(self.side - 1)];
        let (low, high) = ([at(column, line), at(column + 1, line)], [at(column, line + 1), at(column + 1, line + 1)]);
        let (low, high) = (low[0] + (low[1] - low[0]) * u, high[0] + (high[1] - high[0]) * u);
        low + (high - low) * v
    }
}

/// A vertex and how its surroundings lie in the grid.
struct GridVertex {
    /// Cells from the patch's first corner.
    grid: [f32; 2],
    height: f32,
    up: DVec3,
    /// How the direction changes from cell to cell along both sides.
    axes: [DVec3; 2],
}

/// A way from a vertex: cells along both sides a cell of distance, and that distance in radians.
#[derive(Clone, Copy)]
struct Way {
    step: [f32; 2],
    radians: f32,
}

/// Ways along the ground towards where each vertex looks.
fn towards(vertices: &[GridVertex], target: impl Fn(&GridVertex) -> DVec3) -> Vec<Way> {
    vertices.iter().map(|vertex| vertex.towards(target(vertex))).collect()
}

impl GridVertex {
    /// The way along the ground towards a direction; any if it is straight above.
    fn towards(&self, target: DVec3) -> Way {
        let tangent = target - self.up * target.dot(self.up);
        let tangent = tangent.try_normalize().unwrap_or(self.axes[0].normalize());
        let [a, b] = self.axes;
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        let (at, bt) = (a.dot(tangent), b.dot(tangent));
        let determinant = aa * bb - ab * ab;
        let (p, q) = ((bb * at - ab * bt) / determinant, (aa * bt - ab * at) / determinant);
        let cells = (p * p + q * q).sqrt();
        Way { step: [(p / cells) as f32, (q / cells) as f32], radians: (1.0 / cells) as f32 }
    }
}

/// A look-up: in which of the chain's densities, and how many of its cells away.
type Distance = (usize, f32);

/// The ground around a patch and around its ancestors, the patch's own first.
struct Chain {
    surroundings: Vec<Arc<Surroundings>>,
    /// Where the patch's first corner lies in each of them, in cells, and how many of the patch's cells one of theirs is.
    corners: Vec<([f32; 2], f32)>,
    /// Metres.
    radius: f32,
}

impl Chain {
    fn new(ground: &Ground, id: PatchId, around: &mut dyn FnMut(PatchId) -> Arc<Surroundings>) -> Chain {
        let cell = std::f64::consts::FRAC_PI_2 / f64::from(ground.cells) / f64::from(1u32 << id.level);
        let radius = (ground.lattice.radius * ground.lattice.unit) as f32;
        let mut chain = Chain { surroundings: Vec::new(), corners: Vec::new(), radius };
        let mut at = Some(id);
        while let Some(ancestor) = at {
            let up = id.level - ancestor.level;
            let scale = f64::from(1u32 << up);
            if up > 0 && (ancestor.level < COARSEST || cell * scale * f64::from(NEAR[NEAR.len() - 1]) / 2.0 > FARTHEST) {
                break;
            }
            let corner = |own: u32, theirs: u32| f64::from(own - (theirs << up)) * f64::from(ground.cells) / scale;
            chain.surroundings.push(around(ancestor));
            chain.corners.push(([corner(id.x, ancestor.x) as f32, corner(id.y, ancestor.y) as f32], scale as f32));
            at = ancestor.parent();
        }
        chain
    }

    /// The vertices in some columns of a row.
    fn vertices(&self, columns: &[usize], y: usize) -> Vec<GridVertex> {
        let own = &self.surroundings[0];
        let row = y + MARGIN as usize;
        let vertex = |&x: &usize| {
            let column = x + MARGIN as usize;
            let direction = |column: usize, row: usize| own.warped.direction(column, row);
            let along = (direction(column + 1, row) - direction(column - 1, row)) * 0.5;
            let across = (direction(column, row + 1) - direction(column, row - 1)) * 0.5;
            let height = own.metres[row * own.side + column];
            GridVertex { grid: [x as f32, y as f32], height, up: direction(column, row), axes: [along, across] }
        };
        columns.iter().map(vertex).collect()
    }

    /// Where every vertex looks for its horizon.
    fn near(&self) -> Vec<Distance> {
        let own = NEAR.iter().map(|&cells| (0, cells));
        own.chain(self.coarser(1..FINE_LEVELS + 1, &FAR)).collect()
    }

    /// Where every [`COARSE_STEP`]th looks.
    fn far(&self) -> Vec<Distance> {
        self.coarser(FINE_LEVELS + 1..usize::MAX, &FAR).collect()
    }

    fn coarser<'a>(&self, densities: std::ops::Range<usize>, cells: &'a [f32]) -> impl Iterator<Item = Distance> + 'a {
        let most = self.surroundings.len();
        (densities.start.min(most)..densities.end.min(most)).flat_map(move |k| cells.iter().map(move |&cells| (k, cells)))
    }

    /// Tangent of the elevation of the steepest of what each vertex sees along its way; -1 where it looks nowhere.
    fn steepest(&self, vertices: &[GridVertex], ways: &[Way], distances: &[Distance]) -> Vec<f32> {
        let mut steepest = vec![-1.0; vertices.len()];
        let runs = vertices.chunks(RUN).zip(ways.chunks(RUN));
        for ((vertices, ways), steepest) in runs.zip(steepest.chunks_mut(RUN)) {
            let run = Run::new(vertices, ways, self.radius);
            let mut found = [f32::MIN; RUN];
            for &(k, cells) in distances {
                raise(&self.surroundings[k], self.corners[k], &run, cells, &mut found);
            }
            for (steepest, found) in steepest.iter_mut().zip(found).filter(|_| !distances.is_empty()) {
                *steepest = found;
            }
        }
        steepest
    }

    /// Share of an even sky's light: the mean over azimuths of the squared cosine of the horizon's elevation.
    fn sky(&self, vertices: &[GridVertex]) -> Vec<f32> {
        let distances: Vec<Distance> =
            SKY_NEAR.iter().map(|&cells| (0, cells)).chain(self.coarser(1..SKY_LEVELS, &SKY_FAR)).collect();
        let mut sky = vec![0.0; vertices.len()];
        for k in 0..SKY_AZIMUTHS {
            let angle = k as f64 * std::f64::consts::TAU / SKY_AZIMUTHS as f64;
            let (sin, cos) = angle.sin_cos();
            let ways = towards(vertices, |vertex| {
                let east = vertex.axes[0].normalize();
                east * cos + vertex.up.cross(east) * sin
            });
            for (sky, tangent) in sky.iter_mut().zip(self.steepest(vertices, &ways, &distances)) {
                let tangent = tangent.max(0.0);
                *sky += 1.0 / (1.0 + tangent * tangent) / SKY_AZIMUTHS as f32;
            }
        }
        sky
    }
}

/// Vertices and their ways, field by field.
struct Run {
    x: [f32; RUN],
    y: [f32; RUN],
    height: [f32; RUN],
    step_x: [f32; RUN],
    step_y: [f32; RUN],
    /// Per metre: over the length of a cell.
    per_cell: [f32; RUN],
    /// Half of the radians of a cell.
    half: [f32; RUN],
}

impl Run {
    fn new(vertices: &[GridVertex], ways: &[Way], radius: f32) -> Run {
        let zero = [0.0; RUN];
        let mut run = Run { x: zero, y: zero, height: zero, step_x: zero, step_y: zero, per_cell: zero, half: zero };
        for (i, (vertex, way)) in vertices.iter().zip(ways).enumerate() {
            ([run.x[i], run.y[i]], run.height[i]) = (vertex.grid, vertex.height);
            [run.step_x[i], run.step_y[i]] = way.step;
            (run.per_cell[i], run.half[i]) = (1.0 / (radius * way.radians), 0.5 * way.radians);
        }
        run
    }
}

/// Raises to the tangents of the elevations at which vertices see the ground so many cells away along their ways.
#[cfg_attr(
    not(terrane_no_avx512),
    multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))
)]
#[cfg_attr(terrane_no_avx512, multiversion::multiversion(targets("x86_64+avx2")))]
fn raise(around: &Surroundings, ([first_x, first_y], scale): ([f32; 2], f32), run: &Run, cells: f32, found: &mut [f32; RUN]) {
    let (margin, most) = (MARGIN as f32, (around.side - 2) as f32);
    let (per_scale, per_distance, distance) = (1.0 / scale, 1.0 / (cells * scale), cells * scale);
    let (mut u, mut v, mut at) = ([0.0f32; RUN], [0.0f32; RUN], [0i32; RUN]);
    for i in 0..RUN {
        let x = (first_x + run.x[i] * per_scale + run.step_x[i] * cells + margin).clamp(0.0, most);
        let y = (first_y + run.y[i] * per_scale + run.step_y[i] * cells + margin).clamp(0.0, most);
        let (column, row) = (x as i32, y as i32);
        (u[i], v[i]) = (x - column as f32, y - row as f32);
        at[i] = row * around.side as i32 + column;
    }
    let mut corners = [[0.0f32; RUN]; 4];
    for i in 0..RUN {
        let at = at[i] as usize;
        let (low, high) = (&around.metres[at..at + 2], &around.metres[at + around.side..at + around.side + 2]);
        (corners[0][i], corners[1][i], corners[2][i], corners[3][i]) = (low[0], low[1], high[0], high[1]);
    }
    for i in 0..RUN {
        let [a, b, c, d] = [corners[0][i], corners[1][i], corners[2][i], corners[3][i]];
        let (low, high) = (a + (b - a) * u[i], c + (d - c) * u[i]);
        let height = low + (high - low) * v[i];
        let tangent = (height - run.height[i]) * (run.per_cell[i] * per_distance) - run.half[i] * distance;
        found[i] = found[i].max(tangent);
    }
}
