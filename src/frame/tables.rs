//! What the CPU hands to the GPU for one frame: the patches to draw and the work of every stage.
//!
//! In: the cut and the resident patches. Out: [`FrameTables`]. One table-driven dispatch a stage serves all patches: hundreds of
//! small dispatches would cost more than the work itself (docs/design.md, "Stages on a software renderer").

use crate::scene::{ResidentMesh, Scene};
use glam::DVec3;
use std::ops::Range;
use terrane_planet::draw::cut::{is_visible, texture_distance, Cut, Leaf, TEXEL_PIXELS};
use terrane_planet::draw::layout::{PatchDraw, Task, EMIT_CHUNK, MAX_PATCHES, NO_SLOT, RESOLVE_CHUNK, SELECT_CHUNK};
use terrane_planet::draw::tree::PatchNode;
use terrane_planet::draw::view::View;

/// Something for each stage that works through tasks.
#[derive(Default)]
pub struct MeshTasks<T> {
    /// Of `select`.
    pub select: T,
    /// Of `resolve`.
    pub resolve: T,
    /// Of `emit`.
    pub emit: T,
}

/// The tables of one frame.
#[derive(Default)]
pub struct FrameTables {
    /// Patches to draw, in traversal order of the cut.
    pub patches: Vec<PatchDraw>,
    /// The leaf of each of them.
    pub leaves: Vec<Leaf>,
    /// Work of the mesh stages.
    pub tasks: MeshTasks<Vec<Task>>,
    /// Words of awake bits.
    pub awake_words: u32,
    /// Resolved vertices.
    pub vertices: u32,
    /// Triangles that emission looks at.
    pub triangles: u32,
    /// The eye that selection goes by, in lattice units.
    pub eye: DVec3,
}

impl FrameTables {
    /// Tables of a view. `whole` keeps patches that the camera cannot see.
    pub fn new(scene: &Scene, view: &View, cut: &Cut, whole: bool) -> FrameTables {
        let mut tables = FrameTables { eye: view.eye, ..FrameTables::default() };
        for leaf in cut.leaves.iter().take(MAX_PATCHES as usize) {
            let (Some(node), Some(patch)) = (scene.tree().get(leaf.id), scene.mesh(leaf.id)) else { continue };
            if whole || is_visible(scene.tree(), view, &node.space) {
                tables.add(scene, view, *leaf, node, patch);
            }
        }
        tables
    }

    fn add(&mut self, scene: &Scene, view: &View, leaf: Leaf, node: &PatchNode, patch: &ResidentMesh) {
        let work = patch.work(view);
        let metres = |level: u8| texture_distance(scene.tree(), view, level) * scene.tree().lattice.unit;
        let textures = scene.textures_of(view, leaf.id);
        let parent = textures.patch.parent();
        let fade = parent.map_or(f64::MAX, |p| metres(p.level));
        let finer = leaf.id.level - textures.patch.level;
        let texture_cell = 0.5f32.powi(finer.into());
        let corner = |own: u32, theirs: u32| (own - (theirs << finer)) as f32 * texture_cell * scene.tree().cells as f32;
        let number = self.patches.len() as u32;
        let mut grid_axis = [0.0; 3];
        grid_axis[leaf.id.face.grid_axes().0] = 1.0;
        self.patches.push(PatchDraw {
            vertices: words(patch.vertices_address()),
            triangles: words(patch.triangles_address()),
            vertex_count: work.vertices,
            awake_offset: self.awake_words,
            resolve_offset: self.vertices,
            coarser_sides: u32::from(leaf.coarser_sides),
            level: u32::from(leaf.id.level),
            slot: textures.slot,
            parent_slot: parent.and_then(|p| scene.slot(p)).unwrap_or(NO_SLOT),
            quarter: [textures.patch.x % 2, textures.patch.y % 2],
            texture_corner: [corner(leaf.id.x, textures.patch.x), corner(leaf.id.y, textures.patch.y)],
            texture_cell,
            fade_distance: fade as f32,
            texel_distance: (TEXEL_PIXELS * metres(textures.patch.level)) as f32,
            grid_axis,
            deviations: node.quarters.map(|quarter| (quarter.detail_wake * scene.tree().lattice.unit) as f32),
        });
        self.leaves.push(leaf);
        let MeshTasks { select, resolve, emit } = &mut self.tasks;
        add_tasks(select, number, 0..work.vertices, SELECT_CHUNK);
        add_tasks(resolve, number, 0..work.vertices, RESOLVE_CHUNK);
        work.triangles.iter().for_each(|run| add_tasks(emit, number, run.clone(), EMIT_CHUNK));
        self.awake_words += work.vertices.div_ceil(32);
        self.vertices += work.vertices;
        self.triangles += work.triangle_count();
    }
}

/// Divides a run of a patch's vertices or triangles among workgroups.
fn add_tasks(tasks: &mut Vec<Task>, patch_number: u32, run: Range<u32>, chunk: u32) {
    let end = |first: u32| run.end.min(first + chunk);
    tasks.extend(run.clone().step_by(chunk as usize).map(|first| Task { patch_number, first, end: end(first) }));
}

fn words(address: u64) -> [u32; 2] {
    [address as u32, (address >> 32) as u32]
}
