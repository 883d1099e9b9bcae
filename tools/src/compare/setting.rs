//! What all methods draw from: the stored patches of one planet, their grids, and the patches that a view asks for.

use glam::{DVec3, IVec3};
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};
use terrane_planet::draw::cut::{cut, cut_by, distance_to_box, finest_cut, is_visible, Leaf};
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::draw::tree::{PatchNode, PatchTree, QuarterNode};
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::patch::{PatchId, MAX_LEVEL};
use terrane_planet::ground::WarpedGrid;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::store::StoreError;

/// Reads a patch.
pub(crate) type Source = Box<dyn FnMut(PatchId) -> Result<PatchMesh, StoreError> + Send>;

/// One planet's stored patches.
pub(crate) struct Setting {
    /// What is known of them without reading them.
    pub(crate) tree: PatchTree,
    /// Patches of the finest surface.
    finest: HashSet<PatchId>,
    source: Mutex<Source>,
    positions: PatchCache<Vec<IVec3>>,
}

impl Setting {
    /// The patches of a tree, and how to read them.
    pub(crate) fn new(tree: PatchTree, source: Source) -> Setting {
        let finest = finest_cut(&tree, &|_| true).leaves.iter().map(|leaf| leaf.id).collect();
        Setting { tree, finest, source: Mutex::new(source), positions: PatchCache::new() }
    }

    /// Reads a patch.
    pub(crate) fn read(&self, id: PatchId) -> Result<PatchMesh, StoreError> {
        (self.source.lock().unwrap_or_else(PoisonError::into_inner))(id)
    }

    /// Lattice positions of a patch's full grid by grid number, kept once read (200 kB a patch of 128 cells).
    pub(crate) fn positions(&self, id: PatchId) -> Result<Arc<Vec<IVec3>>, StoreError> {
        self.positions.get(id, || {
            let mesh = self.read(id)?;
            let mut positions = vec![IVec3::ZERO; mesh.vertices.len()];
            for vertex in PatchVertex::of_patch(&mesh, &self.tree.lattice) {
                positions[vertex.grid() as usize] = IVec3::from_array(vertex.position);
            }
            Ok(positions)
        })
    }

    /// The position of the finest surface in a direction.
    pub(crate) fn finest(&self, direction: DVec3) -> Result<Option<DVec3>, StoreError> {
        let above = |level: &u8| self.finest.contains(&PatchId::containing(direction, *level));
        let Some(level) = (0..=MAX_LEVEL).find(above) else { return Ok(None) };
        let id = PatchId::containing(direction, level);
        let positions = self.positions(id)?;
        let (columns, row) = (self.tree.cells as usize, self.tree.cells as usize + 1);
        let (a, b) = id.face.coordinates(direction);
        let cell = |c: f64, tile: u32| {
            let along = ((c + 1.0) / 2.0 * f64::from(1u32 << level) - f64::from(tile)) * columns as f64;
            (along.max(0.0) as usize).min(columns - 1)
        };
        let (i, j) = (cell(a, id.x), cell(b, id.y));
        let corners = [0, 1, row, row + 1].map(|k| positions[j * row + i + k].as_dvec3());
        let triangles = cell_triangles((i + j) % 2 == 1).map(|t| t.map(|k| corners[k]));
        // How far the ray turns about the edges, the least of the three, tells which of the two it passes.
        let least = |[a, b, c]: &[DVec3; 3]| {
            [(b, c), (c, a), (a, b)].map(|(p, q)| direction.dot(p.cross(*q))).into_iter().fold(f64::MAX, f64::min)
        };
        let [a, b, c] = if least(&triangles[0]) >= least(&triangles[1]) { triangles[0] } else { triangles[1] };
        let normal = (b - a).cross(c - a);
        Ok(Some(direction * (normal.dot(a) / normal.dot(direction))))
    }

    /// The view of a camera with a tolerance in pixels, drawing every triangle.
    pub(crate) fn view(&self, camera: &Camera, tolerance: f64) -> View {
        View::new(*camera, &self.tree.lattice, self.tree.cells, tolerance).without_culling()
    }

    /// Patches of a cut of which something may be in view.
    pub(crate) fn visible_leaves(&self, view: &View, rule: CutRule) -> Vec<Leaf> {
        let stored = |_| true;
        let mut leaves = match rule {
            CutRule::AsDrawn => cut(&self.tree, view, &stored),
            CutRule::Detail => {
                let urgency = |_, node: &PatchNode| {
                    let of = |q: &QuarterNode| distance_to_box(view, &q.space.bounds) / (view.scale * q.detail_wake);
                    node.quarters.iter().map(of).fold(f64::INFINITY, f64::min)
                };
                cut_by(&self.tree, &urgency, &stored)
            }
        }
        .leaves;
        leaves.retain(|leaf| self.tree.get(leaf.id).is_some_and(|node| is_visible(&self.tree, view, &node.space)));
        leaves
    }
}

/// Triangles of a grid cell with its corners in rows, as `grid_triangles` has them.
fn cell_triangles(falling: bool) -> [[usize; 3]; 2] {
    if falling {
        [[0, 1, 2], [1, 3, 2]]
    } else {
        [[0, 1, 3], [0, 3, 2]]
    }
}

/// For whose sake patches split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CutRule {
    /// As the run time does.
    AsDrawn,
    /// For the error of what is seen alone, not for closure or the size of a texel.
    Detail,
}

impl CutRule {
    /// In words, with `tolerance` times the knob as the cut's tolerance.
    pub(crate) fn describe(self, tolerance: f64) -> String {
        let rule = match self {
            CutRule::AsDrawn => "the run time's cut",
            CutRule::Detail => "cut by error",
        };
        if tolerance == 1.0 {
            rule.into()
        } else {
            format!("{rule}, tolerance × {tolerance}")
        }
    }
}

/// What a method makes of each patch, made when first asked for.
pub(crate) struct PatchCache<T> {
    known: Mutex<HashMap<PatchId, Arc<T>>>,
}

impl<T> PatchCache<T> {
    /// An empty one.
    pub(crate) fn new() -> PatchCache<T> {
        PatchCache { known: Mutex::new(HashMap::new()) }
    }

    /// What was made of a patch, or `make` makes it now. Two threads may both make it: it is the same.
    pub(crate) fn get<E>(&self, id: PatchId, make: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        if let Some(known) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&id) {
            return Ok(known.clone());
        }
        let made = Arc::new(make()?);
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(id, made.clone());
        Ok(made)
    }
}

/// The samples of a patch in the gnomonic plane of its face, where the reciprocal of depth is affine on every triangle.
pub(crate) struct Plane {
    row: usize,
    columns: Vec<f64>,
    rows: Vec<f64>,
    /// 1 / distance along the face's normal.
    depth: Vec<f64>,
    /// Distance from the planet's centre.
    radius: Vec<f64>,
}

impl Plane {
    /// The plane of a patch with the given lattice positions, by grid number.
    pub(crate) fn new(id: PatchId, cells: u32, positions: &[IVec3]) -> Plane {
        let warped = WarpedGrid::new(id, 0..=cells as i32, cells);
        let row = cells as usize + 1;
        let normal = id.face.normal_axis();
        let radius: Vec<f64> = positions.iter().map(|p| p.as_dvec3().length()).collect();
        let along = |k: usize| warped.direction(k % row, k / row)[normal].abs();
        let depth = radius.iter().enumerate().map(|(k, r)| 1.0 / (r * along(k))).collect();
        Plane { row, columns: warped.columns, rows: warped.rows, depth, radius }
    }

    /// Largest radial distance in lattice units of the samples under a triangle of samples from it.
    pub(crate) fn deviation(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|v| (v as usize % self.row, v as usize / self.row));
        let position = |(i, j): (usize, usize)| (self.columns[i], self.rows[j]);
        let [(ax, ay), (bx, by), (cx, cy)] = [position(a), position(b), position(c)];
        let area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if area == 0.0 {
            return 0.0;
        }
        let slack = -1e-9;
        let [qa, qb, qc] = triangle.map(|v| self.depth[v as usize]);
        let mut worst = 0.0f64;
        for j in a.1.min(b.1).min(c.1)..=a.1.max(b.1).max(c.1) {
            for i in a.0.min(b.0).min(c.0)..=a.0.max(b.0).max(c.0) {
                let (x, y) = position((i, j));
                let u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area;
                let v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area;
                let w = 1.0 - u - v;
                if u.min(v).min(w) >= slack {
                    let k = j * self.row + i;
                    let depth = u * qa + v * qb + w * qc;
                    worst = worst.max((depth - self.depth[k]).abs() * self.radius[k] / depth);
                }
            }
        }
        worst
    }
}

/// Radians of a radial error over the distance it is seen from, in pixels of the picture's middle.
pub(crate) fn pixels(error: f64, distance: f64, camera: &Camera) -> f64 {
    error / distance.max(f64::MIN_POSITIVE) / camera.pixel_angle()
}

/// Whether a ball lies wholly outside the frustum of a view.
pub(crate) fn outside(view: &View, centre: DVec3, radius: f64) -> bool {
    view.planes.iter().any(|plane| plane.dot(centre - view.eye) > radius)
}
