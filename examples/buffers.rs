//! The buffers of a view's mesh, for a renderer of your own: positions relative to the camera, and indices. No GPU is needed.
//!
//! `cargo run --release --example buffers -- [OUT.obj]`

use std::io::{BufWriter, Write};
use std::path::PathBuf;
use terrane_planet::draw::camera_path::Keyframe;
use terrane_planet::draw::loaded_patch::LoadedPatch;
use terrane_planet::draw::view::View;
use terrane_planet::draw::view_line::Stand;
use terrane_planet::export::view_surface;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::progressive::PatchMesh;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).map_or_else(|| std::env::temp_dir().join("terrane-buffers.obj"), PathBuf::from);
    let planet = Planet::from_recipe(shipped::load("tiny")?, 128)?;

    // Patches of levels 0 and 1. They are pure functions of recipe and id: built here, read from a planet file elsewhere.
    let roots: Vec<PatchId> = PatchId::roots().collect();
    let ids = roots.iter().copied().chain(roots.iter().filter_map(|id| id.children()).flatten());
    let meshes: Vec<PatchMesh> = ids.map(|id| planet.build(id).0).collect();
    let tree = planet.tree(meshes.iter().map(|mesh| (mesh.id, mesh.facts)));

    // A view from 20 km, with an error of at most one pixel in a picture of 1280 × 720.
    let keyframe = Keyframe {
        time_s: 0.0,
        latitude: 20.0,
        longitude: 30.0,
        stand: Stand::Altitude(20e3),
        heading: 0.0,
        pitch: -60.0,
        fov: 50.0,
    };
    let view = View::new(planet.camera_at(&keyframe, [1280, 720]), &planet.lattice, planet.cells, 1.0);

    // Its triangles, welded over all patches: integers on the lattice, and three indices each.
    let surface = view_surface(&tree, &view, false, |id| {
        let mesh = meshes.iter().find(|mesh| mesh.id == id).ok_or("a patch of the tree")?;
        Ok::<_, &str>(LoadedPatch::new(mesh.clone(), &planet.lattice))
    })?;

    // Relative to the camera single precision is enough: subtract in f64 (or as integers), then round.
    let relative = |position: &glam::IVec3| ((position.as_dvec3() - view.eye) * planet.lattice.unit).as_vec3();
    let positions: Vec<glam::Vec3> = surface.positions.iter().map(relative).collect();
    let indices: &[[u32; 3]] = &surface.triangles;
    println!("{} patches, {} positions of 12 bytes, {} triangles", surface.parts.len(), positions.len(), indices.len());

    let mut file = BufWriter::new(std::fs::File::create(&out)?);
    for p in &positions {
        writeln!(file, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in indices {
        writeln!(file, "f {} {} {}", a + 1, b + 1, c + 1)?;
    }
    file.flush()?;
    println!("{}", out.display());
    Ok(())
}
