//! `select`, `resolve` and `emit` on the device against their CPU twins: sets and integers must be equal.

use crate::harness::{device, Bench};
use std::process::Command;
use terrane::verify::{random_views, Mismatches, VerifyReport, TOLERANCES};
use terrane_planet::draw::layout::PatchVertex;
use terrane_planet::draw::view::View;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::wake::Wake;
use terrane_planet::reference::select::morph_weight;

const VIEWS: usize = 12;

#[test]
fn gpu_stages_equal_their_twins() {
    let Some(context) = device() else { return };
    // The next test looks for this line.
    println!("subgroups of {} on {}", context.device_info().subgroup_size, context.device_info().driver);
    let mut bench = Bench::new(&context);
    let (mut all, mut mixed, mut oriented) = (VerifyReport::default(), 0, 0);
    let ground = bench.scene.planet().ground_radius();
    for (k, view) in random_views(&bench.scene, 3, VIEWS, &TOLERANCES).iter().enumerate() {
        let view = &if k % 2 == 1 { view.with_orientation(ground) } else { *view };
        oriented += usize::from(view.orientation.is_some());
        let report = bench.verifier.check(&mut bench.scene, &mut bench.headless, view).unwrap();
        assert_eq!((report.mismatches, report.cracks), (Mismatches::default(), 0), "view {k}: {:?}", view.camera);
        assert!(report.triangles > 100 && report.awake_vertices > 50, "view {k} proves nothing: {report:?}");
        all.add(&report);
        mixed += usize::from(bench.scene.settle(view).unwrap().leaves.iter().any(|leaf| leaf.coarser_sides != 0));
    }
    assert_eq!(all.sum.broken_promises(), [""; 0]);
    assert!(mixed > 0, "no view mixed levels");
    assert!(oriented > 0, "no view had an orientation term");
    let (seen, whole) = (all.sum.triangles_after_culling, all.sum.triangles);
    assert!(seen > 1000 && 2 * seen < whole, "{all:?}");
}

/// On lavapipe, the widths that its other vector sizes give.
#[test]
fn other_subgroup_widths_give_the_same_mesh() {
    let software = device().map(|context| context.device_info().driver == "llvmpipe");
    if software != Some(true) {
        println!("skipped: the subgroup width of this device is fixed");
        return;
    }
    for (bits, width) in [("128", 4), ("512", 16)] {
        let output = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "--nocapture", "twins::gpu_stages_equal_their_twins"])
            .env("LP_NATIVE_VECTOR_WIDTH", bits)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{bits} bits: {text}{errors}");
        assert!(text.contains(&format!("subgroups of {width} on")), "{bits} bits did not change the width: {text}");
    }
}

/// The first vertex of a view that is awake, not always awake, and has a morph weight that fits.
fn awake_vertex(bench: &mut Bench, view: &View, fits: impl Fn(f32) -> bool) -> (PatchId, usize) {
    for leaf in bench.scene.settle(view).unwrap().leaves {
        let vertices = &bench.verifier.patch_mut(leaf.id).unwrap().vertices;
        let could_sleep = |wakes: u32| wakes >> 16 < u32::from(Wake::ALWAYS.code());
        let weight = |v: &PatchVertex| morph_weight(&view.gpu, v, u32::from(leaf.coarser_sides));
        let found = vertices.iter().position(|v| could_sleep(v.grid_wake) && weight(v).is_some_and(&fits));
        if let Some(found) = found {
            return (leaf.id, found);
        }
    }
    panic!("no vertex is like that");
}

#[test]
fn one_wake_that_differs_on_the_cpu_is_noticed() {
    let Some(context) = device() else { return };
    let mut bench = Bench::new(&context);
    let view = random_views(&bench.scene, 3, 1, &TOLERANCES)[0];
    let (id, k) = awake_vertex(&mut bench, &view, |_| true);
    let vertex = &mut bench.verifier.patch_mut(id).unwrap().vertices[k];
    vertex.grid_wake &= 0xffff;
    vertex.parent_coarser_wake &= 0xffff;
    let found = bench.verifier.check(&mut bench.scene, &mut bench.headless, &view).unwrap().mismatches;
    assert_eq!((found.awake, found.counters, found.patches), (1, 1, 0));
    assert!(found.resolved > 0 && found.triangles > 0, "{found:?}");
}

#[test]
fn one_morph_weight_that_differs_on_the_cpu_is_noticed() {
    let Some(context) = device() else { return };
    let mut bench = Bench::new(&context);
    let view = random_views(&bench.scene, 3, 1, &TOLERANCES)[0];
    let (id, k) = awake_vertex(&mut bench, &view, |weight| (0.2..0.8).contains(&weight));
    // The next larger wake distance is a thousandth longer, which is a thirtieth of the geomorph.
    let vertex = &mut bench.verifier.patch_mut(id).unwrap().vertices[k];
    vertex.grid_wake += 1 << 16;
    vertex.parent_coarser_wake += 1 << 16;
    let found = bench.verifier.check(&mut bench.scene, &mut bench.headless, &view).unwrap().mismatches;
    assert_eq!(found, Mismatches { drawn_positions: 1, culled_triangles: found.culled_triangles, ..Mismatches::default() });
}

#[test]
fn a_mesh_that_differs_in_sight_is_noticed_after_culling() {
    let Some(context) = device() else { return };
    let mut bench = Bench::new(&context);
    let view = random_views(&bench.scene, 3, 1, &TOLERANCES)[0];
    for leaf in bench.scene.settle(&view).unwrap().leaves {
        let vertices = &mut bench.verifier.patch_mut(leaf.id).unwrap().vertices;
        for vertex in vertices.iter_mut().filter(|v| v.grid_wake >> 16 != u32::from(Wake::ALWAYS.code())) {
            vertex.grid_wake &= 0xffff;
        }
    }
    let found = bench.verifier.check(&mut bench.scene, &mut bench.headless, &view).unwrap().mismatches;
    assert!(found.culled_triangles > 0, "{found:?}");
}

#[test]
fn a_border_vertex_moved_on_one_side_is_a_crack() {
    let Some(context) = device() else { return };
    let mut bench = Bench::new(&context);
    let view = random_views(&bench.scene, 3, 1, &TOLERANCES)[0];
    let id = bench.scene.settle(&view).unwrap().leaves[0].id;
    let corner = bench.verifier.patch_mut(id).unwrap().vertices.iter_mut().find(|v| v.grid() == 0).unwrap();
    corner.position[0] += 1;
    let report = bench.verifier.check(&mut bench.scene, &mut bench.headless, &view).unwrap();
    assert!(report.cracks > 0, "{report:?}");
}
