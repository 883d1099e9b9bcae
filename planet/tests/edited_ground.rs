//! The surface of an edited file: patches that were built again beside patches that were not. It is watertight by position bits, no
//! triangle is flipped, and no awake vertex has an asleep one that it needs.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::whole_planet::{self, draw, of_meshes, views_over};
use glam::DVec3;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use terrane_planet::draw::cut::cut;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::edits::{add, finish};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{Edit, Recipe, Shape};
use terrane_planet::store::PlanetFile;
use terrane_planet::store::Region;
use terrane_planet::verify::SurfaceReport;

const CELLS: u32 = 16;

/// A corner of three faces: the file holds its finest patches around it, and the edits lie on it and beside it.
fn corner() -> DVec3 {
    DVec3::ONE.normalize()
}

fn edits() -> [Edit; 3] {
    let at = |offset: [f64; 3], radius_m, shape| {
        let (latitude_deg, longitude_deg) = latitude_longitude(corner() + DVec3::from_array(offset));
        Edit { latitude_deg, longitude_deg, radius_m, shape }
    };
    [
        at([0.0, 0.0, 0.0], 600.0, Shape::Crater { depth_m: 400.0, ground_m: None }),
        at([0.0, 0.06, -0.06], 900.0, Shape::Flatten { height_m: 300.0 }),
        at([-0.05, 0.01, 0.04], 500.0, Shape::Raise { by_m: 250.0 }),
    ]
}

fn baked(path: &Path) -> (PlanetFile, Planet) {
    let recipe = Recipe::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml")).unwrap();
    let planet = Planet::from_recipe(recipe, CELLS).unwrap();
    let region = Region { direction: corner(), radius_m: 1500.0, to_level: 5 };
    let plan = BakePlan::new(planet.recipe.radius, 1, Some(region)).unwrap();
    let mut file = PlanetFile::create_or_resume(path, &planet.header()).unwrap();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| {}, &AtomicBool::new(false)).unwrap();
    (file, planet)
}

/// Cracks in some views of a file's patches; with `must_be_clean`, any fault fails the test.
fn cracks(patches: &whole_planet::Planet, planet: &Planet, must_be_clean: bool) -> usize {
    let mut cracks = 0;
    for (k, view) in views_over(patches, &|d| planet.terrain.height(d), 40).iter().enumerate() {
        let (report, violations) = draw(patches, view, &cut(&patches.tree, view, &|_| true), false);
        let clean = SurfaceReport { triangles: report.triangles, ..Default::default() };
        assert!(!must_be_clean || (report, violations) == (clean, 0), "view {k}: {report:?}, {violations}: {:?}", view.camera);
        cracks += report.cracks;
    }
    cracks
}

#[test]
fn edited_ground_is_watertight() {
    let folder = tempfile::tempdir().unwrap();
    let (mut file, mut planet) = baked(&folder.path().join("a.planet"));
    let mesh = |file: &PlanetFile, id: PatchId| file.mesh(id).unwrap();
    let ids: Vec<PatchId> = file.index().unwrap().iter().map(|r| r.id).collect();
    let before: Vec<_> = ids.iter().map(|&id| mesh(&file, id)).collect();
    for edit in edits() {
        planet = add(&mut file, &planet, edit).unwrap().planet;
        finish(&mut file, &planet, 2, &|_| {}, &AtomicBool::new(false)).unwrap();
    }
    let after: Vec<_> = ids.iter().map(|&id| mesh(&file, id)).collect();
    let rebuilt: Vec<usize> = (0..ids.len()).filter(|&k| before[k] != after[k]).collect();
    assert!(rebuilt.len() > 20 && rebuilt.len() < ids.len(), "{} of {} patches differ", rebuilt.len(), ids.len());
    cracks(&of_meshes(planet.lattice, CELLS, after.iter().cloned()), &planet, true);
    // The negative control: one of the finest patches under the crater is that of the unedited file.
    let stale = rebuilt.into_iter().rfind(|&k| ids[k] == PatchId::containing(corner(), 5)).unwrap();
    let mixed = after.iter().enumerate().map(|(k, mesh)| if k == stale { before[k].clone() } else { mesh.clone() });
    assert!(cracks(&of_meshes(planet.lattice, CELLS, mixed), &planet, false) > 0, "the crack test cannot fail");
}
