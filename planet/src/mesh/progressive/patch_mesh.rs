//! A built patch: what the builder hands to the planet file and the planet file to the run time.

use super::patch_facts::PatchFacts;
use crate::globe::patch::{PatchId, Side, MAX_LEVEL};
use crate::ground::{Ground, HeightGrid};
use crate::mesh::border::BorderLine;
use crate::mesh::border_rules::BorderRules;
use crate::mesh::builder::{build, Faults, Hierarchy};
use crate::mesh::certificate::KAPPA_BUILD;
use crate::mesh::surface::Surface;
use crate::mesh::wake::Wake;

/// One vertex of the progressive mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vertex {
    /// Grid position: j (cells + 1) + i.
    pub grid: u16,
    /// Height above the datum in lattice units.
    pub height: i32,
    /// Wake next to neighbours of the same or a finer level.
    pub wake: Wake,
    /// Coarser wake: that next to a coarser neighbour.
    pub coarser_wake: Wake,
    /// Vertex index of the vertex it collapses into; always before its own, except for vertices that never
    /// collapse, which name themselves.
    pub parent: u16,
}

impl Vertex {
    /// The larger of the two wakes: vertices are stored by falling value of this.
    pub fn largest_wake(&self) -> Wake {
        self.wake.max(self.coarser_wake)
    }
}

/// The progressive mesh of one patch.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchMesh {
    /// Which patch.
    pub id: PatchId,
    /// Grid cells a side.
    pub cells: u32,
    /// All vertices by falling wake.
    pub vertices: Vec<Vertex>,
    /// What else is known of it.
    pub facts: PatchFacts,
}

impl PatchMesh {
    /// Builds a patch from its height samples. A pure function of terrain and patch id.
    pub fn build(ground: &Ground, grid: &HeightGrid) -> (PatchMesh, Faults) {
        let surface = Surface::new(ground, grid);
        PatchMesh::of_surface(ground, grid, &surface, facts(ground, grid, &surface))
    }

    /// Builds a patch whose surface and facts are known.
    pub fn of_surface(ground: &Ground, grid: &HeightGrid, surface: &Surface, facts: PatchFacts) -> (PatchMesh, Faults) {
        let rules = BorderRules::new(ground, grid, KAPPA_BUILD);
        let hierarchy = build(surface, rules, KAPPA_BUILD);
        let vertices = in_wake_order(surface, &hierarchy);
        (PatchMesh { id: grid.id, cells: ground.cells, vertices, facts }, hierarchy.faults)
    }

    /// Number of vertices that never collapse.
    pub fn always_awake(&self) -> usize {
        self.vertices.iter().take_while(|v| v.largest_wake() == Wake::ALWAYS).count()
    }
}

/// What is known of a patch from its samples alone.
pub fn facts(ground: &Ground, grid: &HeightGrid, surface: &Surface) -> PatchFacts {
    let low = surface.heights.iter().copied().min().unwrap_or(0);
    let high = surface.heights.iter().copied().max().unwrap_or(0);
    let child_wake = child_wake(ground, grid);
    PatchFacts { bounds: surface.bounds, heights: [low, high], child_wake, quarters: surface.quarters }
}

/// Largest wake that a vertex of the children has on this patch's sides where this patch has none.
fn child_wake(ground: &Ground, grid: &HeightGrid) -> f64 {
    let id = grid.id;
    if id.level == MAX_LEVEL {
        return 0.0;
    }
    let wake = |side| BorderLine::of_side(id, side).child_wake(ground, grid, id.level, KAPPA_BUILD);
    Side::ALL.into_iter().map(wake).fold(0.0, f64::max)
}

fn in_wake_order(surface: &Surface, hierarchy: &Hierarchy) -> Vec<Vertex> {
    let count = surface.len();
    let mut collapsed_at = vec![u32::MAX; count];
    for (step, &v) in hierarchy.order.iter().enumerate() {
        collapsed_at[v as usize] = step as u32;
    }
    let largest_wake = |v: u32| hierarchy.wake[v as usize].max(hierarchy.coarser_wake[v as usize]);
    let mut order: Vec<u32> = (0..count as u32).collect();
    // Of equal wakes the one that collapsed later comes first, so that parents always precede their children.
    order.sort_by_key(|&v| std::cmp::Reverse((largest_wake(v), collapsed_at[v as usize], std::cmp::Reverse(v))));
    let mut index_of = vec![0u16; count];
    for (k, &v) in order.iter().enumerate() {
        index_of[v as usize] = k as u16;
    }
    let vertex = |&v: &u32| Vertex {
        grid: v as u16,
        height: surface.heights[v as usize],
        wake: hierarchy.wake[v as usize],
        coarser_wake: hierarchy.coarser_wake[v as usize],
        parent: index_of[hierarchy.parent[v as usize] as usize],
    };
    order.iter().map(vertex).collect()
}
