//! A published planet: whatever a planet file answers, its folder answers in the same bytes; what is not what was published is asked for again,
//! or refused by name; and a change of the ground publishes what it changed.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::Arc;
use std::time::Duration;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::edits::{add, finish};
use terrane_planet::planet::Planet;
use terrane_planet::published::{
    publish, FetchError, FolderObjects, Freshness, ObjectName, Objects, Otherwise, PublishError, PublishedPlanet,
    PublishedRecords, Publishing,
};
use terrane_planet::recipe::{Edit, Recipe, Shape};
use terrane_planet::store::{records, Part, PlanetFile, Records, StoreError};

/// Cells enough for meshes of two chunks, and levels enough for shards below shards.
const CELLS: u32 = 32;
const LEVELS: u8 = 3;

fn baked(path: &Path) -> Planet {
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml");
    let planet = Planet::from_recipe(Recipe::load(&recipe).unwrap(), CELLS).unwrap();
    let mut file = PlanetFile::create_or_resume(path, &planet.header()).unwrap();
    let plan = BakePlan::new(planet.recipe.radius, LEVELS, None).unwrap();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    planet
}

fn go(file: &Path, folder: &Path) -> Publishing {
    publish(&PlanetFile::open(file).unwrap(), folder, false, &|_, _| (), &AtomicBool::new(false)).unwrap()
}

fn awaited(objects: impl Objects + 'static) -> PublishedRecords {
    let planet = PublishedPlanet::open(Box::new(objects)).unwrap();
    PublishedRecords::new(Arc::new(planet), Otherwise::wait())
}

fn names(folder: &Path) -> BTreeSet<PathBuf> {
    let entries = |folder: &Path| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect::<Vec<_>>();
    entries(&folder.join("objects")).iter().flat_map(|folder| entries(folder)).collect()
}

/// What becomes of the answer to the question of a number.
type Answer = fn(Freshness, usize, Vec<u8>) -> Result<Vec<u8>, FetchError>;

/// A folder at the end of a line that does what it is told.
struct Line {
    objects: FolderObjects,
    asked: Arc<AtomicUsize>,
    answer: Answer,
}

impl Objects for Line {
    fn place(&self) -> &Path {
        self.objects.place()
    }

    fn manifest(&self) -> Result<Vec<u8>, FetchError> {
        self.objects.manifest()
    }

    fn read(&self, object: ObjectName, range: Range<u64>, from: Freshness) -> Result<Vec<u8>, FetchError> {
        let number = self.asked.fetch_add(1, Ordering::Relaxed);
        (self.answer)(from, number, self.objects.read(object, range, from)?)
    }
}

#[test]
fn a_folder_answers_what_its_planet_file_answers_and_nothing_is_written_twice() {
    let home = tempfile::tempdir().unwrap();
    let (path, folder) = (home.path().join("tiny.planet"), home.path().join("out"));
    let planet = baked(&path);
    let first = go(&path, &folder);
    assert_eq!((first.patches, first.kept, first.removed), (6 + 24 + 96 + 384, 0, 0));
    assert_eq!(first.bytes, names(&folder).iter().map(|path| path.metadata().unwrap().len()).sum::<u64>());
    let file = PlanetFile::open(&path).unwrap();
    let published = PublishedPlanet::open(Box::new(FolderObjects::new(&folder))).unwrap();
    assert_eq!(published.header(), file.header());
    let index: Vec<_> = file.index().unwrap().iter().map(|record| (record.id, record.facts)).collect();
    assert!(published.index(&|_| ()).unwrap() == index);
    let far = PublishedRecords::new(Arc::new(published), Otherwise::wait());
    for (id, facts) in index {
        assert_eq!(far.facts(id).unwrap(), Some(facts));
        for part in [Part::Geometry, Part::Texture] {
            assert!(
                far.bytes(id, part, 0..usize::MAX).unwrap() == Records::bytes(&file, id, part, 0..usize::MAX).unwrap(),
                "{id}"
            );
        }
        for enough in [true, false] {
            let mesh = |records: &dyn Records| records::mesh(records, id, &|_, _| enough).unwrap();
            assert!(mesh(&far) == mesh(&file), "{id}");
        }
    }
    let absent = PatchId::containing(glam::DVec3::ONE, LEVELS + 1);
    assert!(far.facts(absent).unwrap().is_none() && far.bytes(absent, Part::Geometry, 0..9).unwrap().is_none());
    let before = names(&folder);
    let again = go(&path, &folder);
    assert_eq!((again.written, again.kept, again.bytes), (0, first.written, first.bytes));
    assert_eq!(names(&folder), before);
    // Publishing goes on where it was stopped, and finds what is cut short.
    let cut = before.iter().find(|path| path.metadata().unwrap().len() > 100).unwrap();
    std::fs::OpenOptions::new().write(true).open(cut).unwrap().set_len(50).unwrap();
    assert_eq!(go(&path, &folder).written, 1);
    let stopped = publish(&file, &home.path().join("none"), false, &|_, _| (), &AtomicBool::new(true));
    assert!(matches!(stopped, Err(PublishError::Stopped)) && !home.path().join("none/planet.json").exists());
    let text = planet.recipe.text.replace("name = \"Tiny\"", "name = \"Other\"");
    let other = Recipe::from_toml(&text, "other", Path::new("")).unwrap();
    let other = Planet::from_recipe(other, CELLS).unwrap();
    let other = PlanetFile::create_or_resume(&home.path().join("other.planet"), &other.header()).unwrap();
    let refused = publish(&other, &folder, false, &|_, _| (), &AtomicBool::new(false)).unwrap_err().to_string();
    assert!(refused.contains("Tiny is published there; publish Other into another folder"), "{refused}");
}

#[test]
fn an_edit_publishes_the_shards_that_it_changed_and_leaves_the_others() {
    let home = tempfile::tempdir().unwrap();
    let (path, folder) = (home.path().join("tiny.planet"), home.path().join("out"));
    let planet = baked(&path);
    let all = go(&path, &folder);
    let before = names(&folder);
    let mut file = PlanetFile::open_to_edit(&path).unwrap();
    let shape = Shape::Crater { depth_m: 200.0, ground_m: None };
    let edit = Edit { latitude_deg: 35.0, longitude_deg: 45.0, radius_m: 500.0, shape };
    let changed = add(&mut file, &planet, edit).unwrap();
    finish(&mut file, &changed.planet, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    drop(file);
    let Publishing { written, written_bytes, kept, removed, .. } = go(&path, &folder);
    // The patches that it touches and their parents, whose facts it changes: data and directories of their shards, and the recipe.
    assert!((3..=30).contains(&written) && written + kept == all.written, "{written} written, {kept} kept");
    assert!(written_bytes * 5 < all.bytes, "{written_bytes} of {}", all.bytes);
    assert!(removed == 0 && names(&folder).is_superset(&before));
    let file = PlanetFile::open(&path).unwrap();
    let swept = publish(&file, &folder, true, &|_, _| (), &AtomicBool::new(false)).unwrap();
    assert_eq!((swept.written, swept.removed), (0, written));
    assert_eq!(names(&folder).len() as u64, all.written);
    let far = awaited(FolderObjects::new(&folder));
    let deepest = PatchId::containing(terrane_planet::globe::sphere::direction_at(35.0, 45.0), LEVELS);
    assert!(records::mesh(&far, deepest, &|_, _| false).unwrap().unwrap().mesh == file.mesh(deepest).unwrap());
}

#[test]
fn bytes_that_are_not_what_was_published_are_asked_for_again_or_refused_by_name() {
    let home = tempfile::tempdir().unwrap();
    let (path, folder) = (home.path().join("tiny.planet"), home.path().join("out"));
    baked(&path);
    go(&path, &folder);
    let root = PatchId::roots().next().unwrap();
    let whole = PlanetFile::open(&path).unwrap().mesh(root).unwrap();
    let line = |answer: Answer| {
        let asked = Arc::new(AtomicUsize::new(0));
        (Line { objects: FolderObjects::new(&folder), asked: asked.clone(), answer }, asked)
    };
    // What a cache between garbles is right at the origin.
    let (objects, asked) = line(|from, _, mut bytes| {
        if from == Freshness::Any {
            bytes[0] ^= 1;
        }
        Ok(bytes)
    });
    let planet = Arc::new(PublishedPlanet::open(Box::new(objects)).unwrap());
    let far = PublishedRecords::new(planet.clone(), Otherwise::wait());
    assert!(records::mesh(&far, root, &|_, _| false).unwrap().unwrap().mesh == whole);
    let (fetched, asked) = (planet.fetched(), asked.load(Ordering::Relaxed));
    assert_eq!((fetched.refused, 2 * fetched.segments), (fetched.segments, asked as u64));
    // An origin that garbles is no use, and says where.
    let (objects, _) = line(|_, number, mut bytes| {
        if number > 0 && bytes.len() > 600 {
            bytes.pop();
        }
        Ok(bytes)
    });
    let error = records::mesh(&awaited(objects), root, &|_, _| false).unwrap_err().to_string();
    assert!(error.contains("the directory of +X/0/0/0") || error.contains("segment 1 of 2 of the geometry of patch"), "{error}");
    assert!(error.contains("gave 3 times bytes that are not those that were published"), "{error}");
    // Who waits gets his answer when the line is back; who builds is told at once that there is none.
    let flaky = |_, number, bytes| if number % 3 == 1 { Err(FetchError::Unreachable("no line".into())) } else { Ok(bytes) };
    assert!(records::mesh(&awaited(line(flaky).0), root, &|_, _| false).unwrap().unwrap().mesh == whole);
    let dead = |_, number, bytes| if number > 0 { Err(FetchError::Unreachable("no line".into())) } else { Ok(bytes) };
    let planet = Arc::new(PublishedPlanet::open(Box::new(line(dead).0)).unwrap());
    let builder = PublishedRecords::new(planet.clone(), Otherwise::Build);
    assert!(builder.facts(root).unwrap().is_none() && builder.bytes(root, Part::Geometry, 0..9).unwrap().is_none());
    assert_eq!(planet.fetched().failed, 1);
    let stopped =
        PublishedRecords::new(planet, Otherwise::Wait { stop: Arc::new(AtomicBool::new(true)), patience: Duration::MAX });
    assert!(matches!(stopped.facts(root), Err(StoreError::Remote { .. })));
    // Nothing but a planet.json of this version is taken for one.
    let text = std::fs::read_to_string(folder.join("planet.json")).unwrap();
    for (wrong, reason) in [
        ("{}".to_owned(), "not a planet.json of a published planet"),
        (
            text.replace("\"terrane_layout\": 1", "\"terrane_layout\": 2"),
            "layout 2, expected 1; it was published by a newer Terrane",
        ),
        (text.replace("\"format\": 7", "\"format\": 6"), "format 6, expected 7; it was published by an older Terrane"),
        (text.replace("\"patches\"", "\"pitches\""), "missing field `patches`"),
        (text.replace("\"cells\": 32", "\"cells\": 4294967295"), "4294967295 cells along a patch side"),
    ] {
        std::fs::write(folder.join("planet.json"), &wrong).unwrap();
        let error = PublishedPlanet::open(Box::new(FolderObjects::new(&folder))).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
}
