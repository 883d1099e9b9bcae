//! The vertices and triangles that a view leaves out before selection: none that would be drawn, and so many that the work is in
//! proportion to what is drawn.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::TestField;
use crate::whole_planet::{planet, views, Planet};
use terrane_planet::draw::cut::{cut, is_visible, Leaf};
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::View;
use terrane_planet::draw::work::Work;
use terrane_planet::reference::emit::emit;
use terrane_planet::reference::resolve::resolve;
use terrane_planet::reference::select::{select, Selected};

const FIELD: TestField = TestField { radius: 30_000.0, roughness: 0.05, ridged: true, seed: 5 };

/// Number of awake vertices and sorted triangles that a view draws of a patch, when only the vertices and triangles of `work` are read.
fn drawn(view: &View, leaf: &Leaf, patch: &LoadedPatch, work: &Work) -> (usize, Vec<[u32; 3]>) {
    let vertices = &patch.vertices[..work.vertices as usize];
    let Selected { awake, drawn_positions } = select(&view.gpu, vertices, u32::from(leaf.coarser_sides));
    let mut triangles = emit(&view.gpu, &patch.triangles(work), &resolve(vertices, &awake), &drawn_positions);
    triangles.sort_unstable();
    (awake.iter().map(|word| word.count_ones() as usize).sum(), triangles)
}

/// All vertices, and all triangles of the full grid.
fn everything(patch: &LoadedPatch) -> Work {
    let (cells, vertices) = (patch.mesh.cells, patch.vertices.len() as u32);
    Work { vertices, triangles: std::iter::once(0..2 * cells * cells).collect() }
}

/// How many patches of all views are drawn differently when only the vertices and triangles of `looked_at` are read.
fn differing(planet: &Planet, views: &[View], looked_at: &dyn Fn(&View, &LoadedPatch) -> Work) -> usize {
    let mut differing = 0;
    for view in views {
        for leaf in cut(&planet.tree, view, &|_| true).leaves {
            let patch = &planet.patches[&leaf.id].0;
            let work = looked_at(view, patch);
            differing += usize::from(drawn(view, &leaf, patch, &work) != drawn(view, &leaf, patch, &everything(patch)));
        }
    }
    differing
}

#[test]
fn what_is_left_out_is_not_drawn() {
    let planet = planet(&FIELD, 32);
    let views = views(&planet, &FIELD, 30);
    assert_eq!(differing(&planet, &views, &|view, patch| patch.reach.work(view)), 0);
    let too_little = |view: &View, patch: &LoadedPatch| patch.reach.work(&View { reach: 0.7 * view.reach, ..*view });
    assert!(differing(&planet, &views[..6], &too_little) > 0, "the comparison cannot fail");
}

#[test]
fn the_work_follows_what_is_drawn() {
    let planet = planet(&FIELD, 16);
    let [mut awake, mut prefix, mut kept, mut processed, mut divided] = [0; 5];
    for view in views(&planet, &FIELD, 40) {
        for leaf in cut(&planet.tree, &view, &|_| true).leaves {
            if is_visible(&planet.tree, &view, &planet.tree.get(leaf.id).unwrap().space) {
                let patch = &planet.patches[&leaf.id].0;
                let work = patch.reach.work(&view);
                let (vertices, triangles) = drawn(&view, &leaf, patch, &work);
                awake += vertices;
                kept += triangles.len();
                prefix += work.vertices as usize;
                processed += work.triangle_count() as usize;
                divided += usize::from(work.triangles.len() > 1);
            }
        }
    }
    assert!(prefix <= 2 * awake && processed <= 2 * kept, "{prefix} for {awake} vertices, {processed} for {kept} triangles");
    assert!(divided > 0, "no patch used more than one level");
}
