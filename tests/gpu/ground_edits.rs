//! Edits of the ground of a scene that draws: what is drawn after is what the edited file shows when it is opened, every frame until then is
//! whole, and whatever goes wrong, the file is whole.

use crate::harness::device;
use crate::history::{show, Shown};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::Arc;
use std::time::{Duration, Instant};
use terrane::frame::Look;
use terrane::headless::Headless;
use terrane::measure::live::LiveFlight;
use terrane::scene::{CacheOptions, EditRequest, EditState, OnDemand, Scene, SceneError, SceneOptions, Scope};
use terrane::vulkan::Context;
use terrane_planet::draw::view::{Camera, View};
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::edits::finish;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{Edit, Recipe, Shape};
use terrane_planet::store::slow::Delay;
use terrane_planet::store::PlanetFile;

const SIZE: [u32; 2] = [160, 90];

/// Levels that the file holds of the whole planet, and the finest that is built.
const STORED: u8 = 2;
const FINEST: u8 = 5;

const LOOK: Look = Look::daylight(DVec3::new(0.8, 0.6, 0.0));

/// Where the ground changes: off the middle of a face, beside the sides of several patches.
const SITE: DVec3 = DVec3::new(1.0, 0.51, 0.24);

/// Longest time that an edit of these small planets may take.
const LIMIT: Duration = Duration::from_secs(120);

fn tiny() -> Planet {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("planet/recipes/tiny.toml");
    Planet::from_recipe(Recipe::load(&recipe).unwrap(), 16).unwrap()
}

fn file(folder: &Path, planet: &Planet) -> PathBuf {
    let path = folder.join("edited.planet");
    let mut file = PlanetFile::create_or_resume(&path, &planet.header()).unwrap();
    let plan = BakePlan::new(planet.recipe.radius, STORED, None).unwrap();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    path
}

fn options(planet: &Planet, scope: Scope, builds: bool) -> SceneOptions {
    let spacing_m = 1.01 * planet.lattice.unit * planet.lattice.sample_spacing(planet.cells, FINEST);
    let cache = Some(CacheOptions { bytes: u64::MAX, side: None });
    SceneOptions { on_demand: builds.then_some(OnDemand { spacing_m, cache }), scope, ..SceneOptions::default() }
}

fn edit(shape: Shape, radius_m: f64) -> Edit {
    let (latitude_deg, longitude_deg) = latitude_longitude(SITE.normalize());
    Edit { latitude_deg, longitude_deg, radius_m, shape }
}

fn crater() -> Edit {
    edit(Shape::Crater { depth_m: 120.0, ground_m: None }, 400.0)
}

/// From beside the site, so that the picture shows it and what is around it.
fn camera(planet: &Planet, altitude: f64) -> Camera {
    let position = planet.position_above((SITE + DVec3::new(0.0, 0.02, 0.01)).normalize(), altitude);
    Camera::looking(position, 200.0, -35.0, 0.9, SIZE)
}

fn view_of(planet: &Planet) -> impl Fn(Camera) -> View {
    let (lattice, cells) = (planet.lattice, planet.cells);
    move |camera| View::new(camera, &lattice, cells, 1.0)
}

/// What a scene shows of a view once nothing is missing.
fn settled(context: &Arc<Context>, scene: &mut Scene, view: &View) -> Shown {
    scene.set_sun(LOOK.sun);
    let cut = scene.settle(view).unwrap();
    assert!(!scene.edits().is_busy());
    show(scene, &mut Headless::new(context, SIZE.into()).unwrap(), view, &cut)
}

fn differences(a: &Shown, b: &Shown) -> (usize, usize) {
    let apart = a.triangles.symmetric_difference(&b.triangles).count();
    (apart, a.pixels.chunks(4).zip(b.pixels.chunks(4)).filter(|(a, b)| a != b).count())
}

/// Waits until nothing is done for edits any more.
fn wait(scene: &mut Scene, view: &View) {
    let begun = Instant::now();
    while scene.edits().state != EditState::Idle {
        assert!(begun.elapsed() < LIMIT, "{:?}", scene.edits());
        scene.update(view, 64).unwrap();
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The file has the bytes of a bake of its recipe, once what was left of an edit is built.
fn check_file(path: &Path) -> usize {
    let mut file = PlanetFile::open_to_edit(path).unwrap();
    let planet = Planet::from_header(file.header()).unwrap();
    finish(&mut file, &planet, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    let records = file.index().unwrap();
    assert!(records.len() >= BakePlan::new(planet.recipe.radius, STORED, None).unwrap().patches.len());
    for record in records.iter().filter(|record| record.has_mesh()) {
        let (mesh, texture, _) = planet.build(record.id);
        assert!(file.mesh(record.id).unwrap() == mesh, "{}", record.id);
        assert!(!record.has_texture() || file.texture(record.id).unwrap() == texture, "{}", record.id);
    }
    planet.recipe.edits.len()
}

#[test]
fn an_edited_scene_shows_what_the_edited_file_shows_when_it_is_opened() {
    let Some(context) = device() else { return };
    let planet = tiny();
    for (scope, builds) in [(Scope::Flight, true), (Scope::Flight, false), (Scope::Still, true), (Scope::Whole, true)] {
        let folder = tempfile::tempdir().unwrap();
        let path = file(folder.path(), &planet);
        let options = options(&planet, scope, builds);
        let view = view_of(&planet)(camera(&planet, 1500.0));
        let open = || Scene::open(&context, &path, options.clone()).unwrap();
        let mut scene = open();
        let original = settled(&context, &mut scene, &view);
        assert!(original.triangles.len() > 200, "{} triangles prove little", original.triangles.len());
        scene.edit(EditRequest::Apply(crater())).unwrap();
        let edited = settled(&context, &mut scene, &view);
        let (apart, pixels) = differences(&edited, &original);
        assert!(apart > 10 && pixels > 500, "{scope:?}: {apart} triangles, {pixels} pixels changed");
        assert_eq!((scene.edits().undoable, scene.edits().redoable, scene.planet().recipe.edits.len()), (1, 0, 1));
        assert_eq!(differences(&settled(&context, &mut open(), &view), &edited), (0, 0), "{scope:?} {builds}");
        scene.edit(EditRequest::Undo).unwrap();
        assert_eq!(differences(&settled(&context, &mut scene, &view), &original), (0, 0), "{scope:?} {builds}");
        assert_eq!((scene.edits().undoable, scene.edits().redoable), (0, 1));
        assert_eq!(differences(&settled(&context, &mut open(), &view), &original), (0, 0), "{scope:?} {builds}");
        scene.edit(EditRequest::Redo).unwrap();
        assert_eq!(differences(&settled(&context, &mut scene, &view), &edited), (0, 0), "{scope:?} {builds}");
        assert_eq!((scene.edits().undoable, scene.edits().redoable), (1, 0));
        wait(&mut scene, &view);
        assert_eq!(PlanetFile::open(&path).unwrap().pending().unwrap(), []);
        drop(scene);
        assert_eq!(check_file(&path), 1);
    }
}

#[test]
fn a_file_at_the_end_of_a_line_is_edited_like_one_at_hand() {
    let Some(context) = device() else { return };
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let path = file(folder.path(), &planet);
    let delay = Some(Delay { latency: Duration::from_millis(5), bytes_per_second: 2e7 });
    let at_hand = options(&planet, Scope::Flight, true);
    let view = view_of(&planet)(camera(&planet, 1500.0));
    let mut far = Scene::open(&context, &path, SceneOptions { delay, ..at_hand.clone() }).unwrap();
    // Before anything but the first picture is there.
    far.update(&view, 64).unwrap();
    far.edit(EditRequest::Apply(crater())).unwrap();
    let edited = settled(&context, &mut far, &view);
    assert_eq!(far.planet().recipe.edits, [crater()]);
    let mut anew = Scene::open(&context, &path, at_hand).unwrap();
    assert_eq!(differences(&settled(&context, &mut anew, &view), &edited), (0, 0));
}

#[test]
fn every_frame_of_an_edit_is_whole_and_of_one_ground() {
    let Some(context) = device() else { return };
    let planet = tiny();
    for (name, gpu_bytes) in [("roomy", u64::MAX), ("tight", 0)] {
        let folder = tempfile::tempdir().unwrap();
        let path = file(folder.path(), &planet);
        let options = SceneOptions { gpu_bytes, ..options(&planet, Scope::Flight, true) };
        let mut scene = Scene::open(&context, &path, options).unwrap();
        let mut headless = Headless::new(&context, SIZE.into()).unwrap();
        let view = view_of(&planet);
        scene.set_sun(LOOK.sun);
        scene.settle(&view(camera(&planet, 2000.0))).unwrap();
        let mut flight = LiveFlight::new(&context, &mut scene, &mut headless, 0.02);
        let requests = [EditRequest::Apply(crater()), EditRequest::Undo, EditRequest::Redo];
        let mut waited = 0;
        for (turn, request) in requests.into_iter().enumerate() {
            flight.scene_mut().edit(request).unwrap();
            let begun = Instant::now();
            // The viewer moves meanwhile, and patches come and go.
            for k in 0.. {
                assert!(begun.elapsed() < LIMIT, "{name}: {:?}", flight.scene().edits());
                let altitude = 2000.0 - 40.0 * f64::from(k.min(30)) - 100.0 * turn as f64;
                let before = flight.scene().planet().recipe.edits.len();
                let (_, seen, cut) = flight.frame(camera(&planet, altitude), &view, &LOOK).unwrap();
                let faults = flight.faults(&seen, &cut, &LOOK).unwrap();
                assert_eq!(faults.total(), 0, "{name}, turn {turn}, frame {k}: {faults:?}");
                waited += usize::from(flight.scene().planet().recipe.edits.len() == before);
                if !flight.scene().edits().is_busy() {
                    break;
                }
            }
            assert!(flight.scene().edits().latest.is_some_and(|time| time <= begun.elapsed()));
        }
        assert!(waited > 6, "{name}: only {waited} frames were drawn while edits were under way");
        let seen = view(camera(&planet, 900.0));
        let found = settled(&context, &mut scene, &seen);
        let mut anew = Scene::open(&context, &path, SceneOptions { gpu_bytes, ..options_of(&planet) }).unwrap();
        if gpu_bytes > 0 {
            assert_eq!(differences(&settled(&context, &mut anew, &seen), &found), (0, 0));
        }
        let (used, most) = scene.gpu_bytes();
        assert!(used <= most, "{name}: {used} of {most} bytes");
    }
}

fn options_of(planet: &Planet) -> SceneOptions {
    options(planet, Scope::Flight, true)
}

#[test]
fn an_edit_that_cannot_be_leaves_file_and_picture_as_they_were() {
    let Some(context) = device() else { return };
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let path = file(folder.path(), &planet);
    let view = view_of(&planet)(camera(&planet, 1500.0));
    let stored = options(&planet, Scope::Flight, false);
    let mut scene = Scene::open(&context, &path, stored).unwrap();
    let original = settled(&context, &mut scene, &view);
    let bytes = std::fs::read(&path).unwrap();
    assert!(matches!(scene.edit(EditRequest::Undo), Err(SceneError::Edit(_))));
    assert!(matches!(scene.edit(EditRequest::Redo), Err(SceneError::NothingToRedo)));
    let wrong = Edit { radius_m: -1.0, ..crater() };
    let said = scene.edit(EditRequest::Apply(wrong)).unwrap_err().to_string();
    assert!(said.contains("`radius_m`: found -1"), "{said}");
    let failing = |scene: &mut Scene, edit, expected: &str| {
        scene.edit(EditRequest::Apply(edit)).unwrap();
        assert!(matches!(scene.edit(EditRequest::Apply(edit)), Err(SceneError::EditUnderWay)));
        assert_eq!(differences(&settled(&context, scene, &view), &original), (0, 0), "{expected}");
        let EditState::Failed { message } = scene.edits().state else { panic!("{:?}", scene.edits()) };
        assert!(message.contains(expected), "{message} lacks {expected}");
        assert_eq!((scene.edits().undoable, scene.edits().redoable), (0, 0));
    };
    failing(&mut scene, edit(Shape::Raise { by_m: 90_000.0 }, 400.0), "make it less deep or high");
    let mode = |readonly| {
        let mut permissions = std::fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(readonly);
        std::fs::set_permissions(&path, permissions).unwrap();
    };
    mode(true);
    failing(&mut scene, crater(), "read-only");
    mode(false);
    assert!(std::fs::read(&path).unwrap() == bytes, "the file has changed");
    // Nobody edits from under others: what this scene draws is no longer what the file holds.
    let mut elsewhere = Scene::open(&context, &path, options(&planet, Scope::Flight, true)).unwrap();
    elsewhere.edit(EditRequest::Apply(crater())).unwrap();
    elsewhere.settle(&view).unwrap();
    drop(elsewhere);
    scene.edit(EditRequest::Apply(crater())).unwrap();
    wait_for_failure(&mut scene, &view, "was edited since it was opened");
    drop(scene);
    assert_eq!(check_file(&path), 1);
}

fn wait_for_failure(scene: &mut Scene, view: &View, expected: &str) {
    let begun = Instant::now();
    while scene.edits().is_busy() {
        assert!(begun.elapsed() < LIMIT);
        scene.update(view, 64).unwrap();
    }
    let EditState::Failed { message } = scene.edits().state else { panic!("{:?}", scene.edits()) };
    assert!(message.contains(expected), "{message} lacks {expected}");
}

#[test]
fn a_scene_that_is_closed_during_an_edit_leaves_the_file_whole() {
    let Some(context) = device() else { return };
    let planet = tiny();
    let view = view_of(&planet)(camera(&planet, 1500.0));
    let mut edits = Vec::new();
    for frames in [0, 1, 2, 5, 20] {
        for builds in [true, false] {
            let folder = tempfile::tempdir().unwrap();
            let path = file(folder.path(), &planet);
            let mut scene = Scene::open(&context, &path, options(&planet, Scope::Flight, builds)).unwrap();
            scene.update(&view, 64).unwrap();
            scene.edit(EditRequest::Apply(crater())).unwrap();
            for _ in 0..frames {
                scene.update(&view, 64).unwrap();
                std::thread::sleep(Duration::from_millis(3));
            }
            drop(scene);
            edits.push(check_file(&path));
        }
    }
    assert!(edits.iter().all(|&count| count <= 1), "{edits:?}");
}
