//! Edits of a planet file's ground: an edited file has the bytes of a bake of the edited recipe, wherever the edit lies; an undone edit
//! leaves the bytes of before; an unfinished edit leaves no patch of the old ground.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use glam::{DVec3, IVec3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::OnceLock;
use terrane_planet::globe::patch::{PatchId, Side};
use terrane_planet::globe::random::Random;
use terrane_planet::globe::sphere::{direction, latitude_longitude, ONE};
use terrane_planet::ground::surroundings::sample_surroundings;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::edits::{add, finish, mean_height, undo, Changed, EditError, Touched};
use terrane_planet::planet::{Planet, PlanetError};
use terrane_planet::recipe::{Edit, Recipe, Shape};
use terrane_planet::store::Region;
use terrane_planet::store::{BakedPatch, PatchRecord, PlanetFile, StoreError};

const CELLS: u32 = 8;
const LEVELS: u8 = 2;
const CRATER: Shape = Shape::Crater { depth_m: 90.0, ground_m: None };

fn tiny() -> Recipe {
    Recipe::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml")).unwrap()
}

fn edit_at(site: DVec3, radius_m: f64, shape: Shape) -> Edit {
    let (latitude_deg, longitude_deg) = latitude_longitude(site);
    Edit { latitude_deg, longitude_deg, radius_m, shape }
}

fn go(file: &mut PlanetFile, planet: &Planet, plan: &BakePlan) {
    bake(file, &planet.terrain, &planet.terrain, plan, 2, &|_| {}, &AtomicBool::new(false)).unwrap();
}

fn baked(path: &Path, planet: &Planet, plan: &BakePlan) -> PlanetFile {
    let mut file = PlanetFile::create_or_resume(path, &planet.header()).unwrap();
    go(&mut file, planet, plan);
    file
}

/// The unedited planet, baked once.
fn original() -> &'static Path {
    static FILE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = FILE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("original.planet");
        let planet = Planet::from_recipe(tiny(), CELLS).unwrap();
        baked(&path, &planet, &BakePlan::new(planet.recipe.radius, LEVELS, None).unwrap());
        (folder, path)
    });
    path
}

/// A copy of the unedited planet, opened to be edited.
fn copy(folder: &Path) -> PlanetFile {
    let path = folder.join("edited.planet");
    std::fs::copy(original(), &path).unwrap();
    PlanetFile::open_to_edit(&path).unwrap()
}

fn planet_of(file: &PlanetFile) -> Planet {
    Planet::from_header(file.header()).unwrap()
}

fn build_all(file: &mut PlanetFile, planet: &Planet) -> usize {
    finish(file, planet, 2, &|_| {}, &AtomicBool::new(false)).unwrap().built
}

fn make(file: &mut PlanetFile, edit: Edit) -> Changed {
    let changed = add(file, &planet_of(file), edit).unwrap();
    build_all(file, &changed.planet);
    changed
}

fn undo_last(file: &mut PlanetFile) -> Result<Changed, EditError> {
    let planet = planet_of(file);
    undo(file, &planet)
}

type Rows = HashMap<PatchId, (PatchRecord, Vec<u8>, Vec<u8>)>;

fn rows(file: &PlanetFile) -> Rows {
    let row = |r: PatchRecord| (r.id, (r, file.geometry_record(r.id).unwrap(), file.texture_record(r.id).unwrap()));
    file.index().unwrap().into_iter().map(row).collect()
}

fn differing(a: &Rows, b: &Rows) -> Vec<PatchId> {
    assert_eq!(a.len(), b.len(), "patches are missing");
    a.iter().filter(|(id, row)| b.get(id) != Some(row)).map(|(&id, _)| id).collect()
}

fn sites() -> Vec<(&'static str, DVec3)> {
    let corner = |x: i32, y: i32, z: i32| direction(IVec3::new(x, y, z));
    vec![
        ("a patch's middle", corner(ONE, ONE / 8, ONE / 8)),
        ("a patch's corner", corner(ONE, ONE / 4, ONE / 2)),
        ("beside a patch's side", corner(ONE / 4 + ONE / 1000, ONE, ONE / 8)),
        ("a face's edge", corner(ONE, -ONE, ONE / 3)),
        ("a face's corner", corner(-ONE, ONE, -ONE)),
        ("beside a face's corner", corner(ONE, ONE - ONE / 300, ONE - ONE / 90)),
        ("the north pole", DVec3::Z),
        ("the south pole", DVec3::NEG_Z),
    ]
}

#[test]
fn edited_files_equal_bakes_of_the_edited_recipe() {
    let shapes =
        [Shape::Crater { depth_m: 90.0, ground_m: Some(50.0) }, Shape::Flatten { height_m: 333.0 }, Shape::Raise { by_m: -60.0 }];
    let mut beyond = 0;
    for (k, (name, site)) in sites().into_iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = copy(folder.path());
        let before = rows(&file);
        let edit = edit_at(site, [900.0, 1200.0, 1500.0][k % 3], shapes[(k + k / 3) % 3]);
        let changed = make(&mut file, edit);
        let fresh_planet = Planet::from_recipe(changed.planet.recipe.clone(), CELLS).unwrap();
        assert_eq!(changed.planet.header(), fresh_planet.header());
        assert_eq!(changed.planet.terrain.lowest_dry(), fresh_planet.terrain.lowest_dry());
        let plan = BakePlan::new(fresh_planet.recipe.radius, LEVELS, None).unwrap();
        let fresh = rows(&baked(&folder.path().join("fresh.planet"), &fresh_planet, &plan));
        let edited = rows(&file);
        assert_eq!(differing(&edited, &fresh), [], "{name}: {edit}");
        assert_eq!(file.pending().unwrap(), []);
        let reached = differing(&before, &fresh);
        assert!(!reached.is_empty() && reached.len() <= changed.touched, "{name}: {} of {}", reached.len(), changed.touched);
        assert!(changed.touched < 60, "{name}: {} patches touched", changed.touched);
        // Patches whose own ground the edit does not reach, but the samples around it that gutters and borders need.
        let far = |id: &&PatchId| id.centre().angle_between(site) * 30e3 > edit.reach_m() + 38e3 / f64::from(1u32 << id.level);
        beyond += reached.iter().filter(far).count();
        let changed = undo_last(&mut file).unwrap();
        assert_eq!(changed.planet.recipe.text, tiny().text, "{name}");
        build_all(&mut file, &changed.planet);
        assert_eq!(differing(&rows(&file), &before), [], "{name}: undone");
    }
    assert!(beyond > 0, "no edit reached past the patches it lies in: margins were not tested");
}

#[test]
fn the_comparison_finds_a_patch_that_was_not_rebuilt() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = copy(folder.path());
    let before = rows(&file);
    make(&mut file, edit_at(DVec3::new(1.0, 0.3, 0.2).normalize(), 900.0, CRATER));
    let edited = rows(&file);
    for id in differing(&edited, &before) {
        let mut stale = edited.clone();
        stale.insert(id, before[&id].clone());
        assert_eq!(differing(&stale, &edited), [id]);
    }
}

#[test]
fn what_an_edit_does_not_touch_keeps_its_bytes() {
    let plain = Planet::from_recipe(tiny(), CELLS).unwrap();
    let mut random = Random::new(5);
    let (mut same, mut others, mut in_vain) = (0, 0, 0);
    for k in 0..60 {
        let face_edge = DVec3::new(1.0, 1.0 + 0.1 * (random.unit() - 0.5), 2.0 * random.unit() - 1.0);
        let site = if k % 2 == 0 { face_edge.normalize() } else { random.direction() };
        let edit = edit_at(site, 1500.0 * random.unit().powi(4) + 1.0, Shape::Raise { by_m: 200.0 });
        let reach = Touched::new(&edit, plain.recipe.radius, CELLS);
        let edited = Planet::from_recipe(plain.recipe.with_edit(&edit).unwrap(), CELLS).unwrap();
        for level in 0..7 {
            let at = PatchId::containing(site, level);
            let around = Side::ALL.map(|side| at.neighbour(side));
            for id in around.into_iter().chain([at]) {
                let [before, after] = [&plain, &edited].map(|planet| {
                    let (mesh, texture, _) = planet.build(id);
                    (mesh, texture, sample_surroundings(&planet.ground(), id))
                });
                let [patch, surroundings] = [(&before.0, &before.1) == (&after.0, &after.1), before.2 == after.2];
                assert!(reach.touches(id) || patch, "{id} by {edit}");
                assert!(reach.touches_around(id) || surroundings, "surroundings of {id} by {edit}");
                *(if !patch {
                    &mut others
                } else if reach.touches(id) {
                    &mut in_vain
                } else {
                    &mut same
                }) += 1;
            }
        }
    }
    assert!(same > 200 && others > 200, "{same} kept their bytes, {others} did not, {in_vain} were touched and did");
}

#[test]
fn deep_regions_and_coarse_grids_keep_no_stale_patch() {
    let folder = tempfile::tempdir().unwrap();
    for (cells, site) in [(8, DVec3::ONE.normalize()), (16, direction(IVec3::new(ONE / 2, ONE, ONE / 64)))] {
        let planet = Planet::from_recipe(tiny(), cells).unwrap();
        let region = Region { direction: site, radius_m: 20.0, to_level: 8 };
        let plan = BakePlan::new(planet.recipe.radius, 0, Some(region)).unwrap();
        let mut file = baked(&folder.path().join(format!("{cells}.planet")), &planet, &plan);
        for (offset, radius_m) in [(0.0, 20.0), (3e-3, 60.0)] {
            let edit = edit_at((site + DVec3::new(0.0, offset, 0.0)).normalize(), radius_m, CRATER);
            let changed = make(&mut file, edit);
            let fresh_planet = Planet::from_recipe(changed.planet.recipe, cells).unwrap();
            let fresh = rows(&baked(&folder.path().join(format!("{cells} {offset}.planet")), &fresh_planet, &plan));
            assert_eq!(differing(&rows(&file), &fresh), [], "{cells} cells: {edit}");
        }
    }
}

#[test]
fn several_edits_are_undone_in_reverse_order() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = copy(folder.path());
    let site = DVec3::new(0.2, -1.0, 0.4).normalize();
    let mut texts = vec![file.header().recipe.clone()];
    for shape in [CRATER, Shape::Flatten { height_m: -20.0 }, Shape::Raise { by_m: 5.5 }] {
        make(&mut file, edit_at(site, 400.0, shape));
        texts.push(file.header().recipe.clone());
    }
    assert_eq!(planet_of(&file).recipe.edits.len(), 3);
    while let Some(expected) = texts.pop() {
        assert_eq!(file.header().recipe, expected);
        assert_eq!(planet_of(&file).recipe.undoable_edits(), texts.len());
        assert_eq!(PlanetFile::open(file.path()).unwrap().header(), file.header());
        match undo_last(&mut file) {
            Ok(_) => assert!(!texts.is_empty()),
            Err(error) => assert!(texts.is_empty() && matches!(error, EditError::NoEdit { .. }), "{error}"),
        }
    }
}

#[test]
fn an_edit_stopped_half_way_leaves_patches_of_one_ground() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = copy(folder.path());
    let all = rows(&file).len();
    let planet = planet_of(&file);
    let changed = add(&mut file, &planet, edit_at(DVec3::X, 900.0, CRATER)).unwrap();
    let stop = AtomicBool::new(false);
    let some = |p: terrane_planet::planet::bake::Progress| stop.store(p.built >= 3, Ordering::Relaxed);
    let summary = finish(&mut file, &changed.planet, 1, &some, &stop).unwrap();
    assert!(summary.interrupted);
    let left = file.pending().unwrap();
    assert_eq!(left.len(), changed.touched - changed.faces - summary.built);
    assert!(PatchId::roots().all(|root| file.contains(root).unwrap()), "a whole face is missing");
    let reader = PlanetFile::open(file.path()).unwrap();
    assert!(left.iter().all(|&id| !reader.contains(id).unwrap()), "a reader sees the ground of before");
    assert_eq!(reader.index().unwrap().len(), all - left.len());
    // A bake into an unfinished file finishes its edit first.
    let mut again = PlanetFile::create_or_resume(file.path(), &changed.planet.header()).unwrap();
    go(&mut again, &changed.planet, &BakePlan::new(30e3, 0, None).unwrap());
    assert_eq!(again.pending().unwrap(), []);
    let plan = BakePlan::new(30e3, LEVELS, None).unwrap();
    let fresh = rows(&baked(&folder.path().join("fresh.planet"), &changed.planet, &plan));
    assert_eq!(differing(&rows(&again), &fresh), []);
}

#[test]
fn whoever_opened_the_file_before_an_edit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = copy(folder.path());
    let old_planet = planet_of(&file);
    let mut keeper = PlanetFile::create_or_resume(file.path(), &old_planet.header()).unwrap();
    let reader = PlanetFile::open(file.path()).unwrap();
    let id = PatchId::containing(DVec3::X, 2);
    assert!(reader.contains(id).unwrap());
    make(&mut file, edit_at(DVec3::X, 900.0, CRATER));
    assert!(!reader.contains(id).unwrap(), "an old reader is given patches of the new ground");
    assert!(matches!(reader.mesh(id), Err(StoreError::Changed { .. })));
    assert!(matches!(reader.index(), Err(StoreError::Changed { .. })));
    let (mesh, texture, _) = old_planet.build(PatchId::containing(DVec3::X, 5));
    let stale = BakedPatch::new(&mesh, &texture).unwrap();
    assert!(matches!(keeper.cache(std::slice::from_ref(&stale), &[], &[], 1, u64::MAX), Err(StoreError::Changed { .. })));
    assert!(matches!(keeper.put(&[stale]), Err(StoreError::Changed { .. })));
    let error = PlanetFile::create_or_resume(file.path(), &old_planet.header()).unwrap_err();
    assert!(matches!(error, StoreError::Edited { .. }), "{error}");
}

#[test]
fn an_edit_removes_cached_patches_of_the_old_ground() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = copy(folder.path());
    let planet = planet_of(&file);
    let [near, far] = [DVec3::X, DVec3::NEG_X].map(|site| PatchId::containing(site, 5));
    let cached = [near, far].map(|id| {
        let (mesh, texture, _) = planet.build(id);
        BakedPatch::new(&mesh, &texture).unwrap()
    });
    file.cache(&cached, &[], &[], 1, u64::MAX).unwrap();
    make(&mut file, edit_at(DVec3::X, 900.0, CRATER));
    assert_eq!([near, far].map(|id| file.contains(id).unwrap()), [false, true]);
    let left: u64 = [&cached[1].geometry, &cached[1].texture].iter().map(|b| b.len() as u64).sum();
    assert_eq!(file.cached_bytes().unwrap(), left);
}

#[test]
fn bad_edits_leave_the_file_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = copy(folder.path());
    let before = std::fs::read(file.path()).unwrap();
    let planet = planet_of(&file);
    let good = edit_at(DVec3::X, 100.0, CRATER);
    let cases = [
        (Edit { radius_m: 0.0, ..good }, "`radius_m`: found 0"),
        (Edit { radius_m: f64::NAN, ..good }, "`radius_m`: found NaN"),
        (Edit { radius_m: 10_001.0, ..good }, "from 0.1 to 10000"),
        (Edit { latitude_deg: 90.1, ..good }, "`latitude_deg`: found 90.1"),
        (Edit { longitude_deg: f64::INFINITY, ..good }, "`longitude_deg`: found inf"),
        (Edit { shape: Shape::Crater { depth_m: -1.0, ground_m: None }, ..good }, "`depth_m`: found -1"),
        (Edit { shape: Shape::Raise { by_m: 50_000.0 }, ..good }, "edit 1 (raise at 0, 0"),
        (Edit { shape: Shape::Crater { depth_m: 20_000.0, ground_m: None }, ..good }, "make it less deep or high"),
    ];
    for (edit, message) in cases {
        let error = add(&mut file, &planet, edit).err().expect("a bad edit");
        assert!(error.to_string().contains(message), "{error} lacks {message}");
    }
    assert!(matches!(undo(&mut file, &planet), Err(EditError::NoEdit { .. })));
    assert!(std::fs::read(file.path()).unwrap() == before, "bytes changed");
    add(&mut file, &planet, good).unwrap();
    assert!(std::fs::read(file.path()).unwrap() != before, "the comparison sees nothing");
}

#[test]
fn edits_keep_the_lattice_and_the_height_range() {
    let with = |shape| {
        let planet = Planet::from_recipe(tiny(), CELLS).unwrap();
        Planet::from_recipe(planet.recipe.with_edit(&edit_at(DVec3::Y, 2000.0, shape)).unwrap(), CELLS)
    };
    let plain = Planet::from_recipe(tiny(), CELLS).unwrap();
    let room = plain.lattice.highest() - plain.terrain.height_range().1;
    for share in [-0.35, 0.9] {
        let planet = with(Shape::Raise { by_m: share * room }).unwrap();
        assert_eq!(planet.lattice, plain.lattice);
        let height = planet.terrain.height(DVec3::Y);
        let range = planet.terrain.height_range();
        assert!((height - plain.terrain.height(DVec3::Y) - share * room).abs() < 1e-6 && range.0 <= height && height <= range.1);
        let mesh = planet.build(PatchId::containing(DVec3::Y, 6)).0;
        assert!(f64::from(mesh.facts.heights[0]) + planet.lattice.radius > planet.ground_radius());
    }
    assert!(matches!(with(Shape::Raise { by_m: 1.01 * room }), Err(PlanetError::EditTooHigh { number: 1, .. })));
}

#[test]
fn a_site_is_flattened_to_its_mean_height() {
    let planet = Planet::from_recipe(tiny(), CELLS).unwrap();
    let mean = mean_height(&planet, 12.0, 34.0, 800.0);
    let around: Vec<f64> = [(12.0, 34.0), (12.5, 34.0), (12.0, 33.5), (11.3, 34.4)]
        .map(|(lat, lon)| planet.terrain.height(terrane_planet::globe::sphere::direction_at(lat, lon)))
        .to_vec();
    let (low, high) = around.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    assert!((low - 200.0..high + 200.0).contains(&mean), "{mean} m, beside {around:?}");
    let flat = Edit { latitude_deg: 12.0, longitude_deg: 34.0, radius_m: 800.0, shape: Shape::Flatten { height_m: mean } };
    let flattened = Planet::from_recipe(planet.recipe.with_edit(&flat).unwrap(), CELLS).unwrap();
    assert!((mean_height(&flattened, 12.0, 34.0, 500.0) - mean).abs() < 1e-3);
}

#[test]
fn hand_written_edits_are_read_and_not_undone() {
    let edit = edit_at(DVec3::X, 100.0, CRATER);
    let text = format!(
        "{}\n[[edit]] # a crater\nkind = 'crater'\nlatitude_deg = 0\nlongitude_deg = 0\nradius_m = 1e2\ndepth_m = 90\n",
        tiny().text
    );
    let recipe = Recipe::from_toml(&text, "t.toml", Path::new(".")).unwrap();
    assert_eq!(recipe.edits, [edit]);
    assert!(recipe.without_last_edit().unwrap().is_none());
    assert_eq!((recipe.undoable_edits(), recipe.with_edit(&edit).unwrap().undoable_edits()), (0, 1));
    let more = recipe.with_edit(&edit).unwrap();
    assert_eq!(more.without_last_edit().unwrap().unwrap().text, text);
    for (from, to, expected) in [
        ("'crater'", "'dome'", "`edit[0].kind`: found string \"dome\""),
        ("1e2", "0", "`edit[0].radius_m`: found integer 0, expected a number from 0.1 to 10000"),
        ("depth_m = 90", "height_m = 90", "`edit[0].depth_m`: found nothing"),
        ("depth_m = 90", "depth_m = 90\nby_m = 1", "`edit[0].by_m`: found an unknown key"),
    ] {
        let error = Recipe::from_toml(&text.replace(from, to), "t.toml", Path::new(".")).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
