//! Patches of which the planet file holds a part: facts, or facts and textures, until someone builds the rest.

use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::mesh::survey::Survey;
use terrane_planet::planet::bake::{bake, BakePlan, BakeSummary};
use terrane_planet::planet::edits::{add, finish};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{Edit, Recipe, Shape};
use terrane_planet::store::record::RECORD_VERSION;
use terrane_planet::store::{geometry, imagery, BakedPatch, PlanetFile, RecordError, StoreError, FORMAT_VERSION};

const CELLS: u32 = 8;

struct Site {
    folder: tempfile::TempDir,
    planet: Planet,
}

impl Site {
    fn new() -> Site {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml");
        let planet = Planet::from_recipe(Recipe::load(&path).unwrap(), CELLS).unwrap();
        Site { folder: tempfile::tempdir().unwrap(), planet }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("a.planet")
    }

    fn open(&self) -> PlanetFile {
        PlanetFile::create_or_resume(&self.path(), &self.planet.header()).unwrap()
    }

    fn bake(&self, file: &mut PlanetFile, levels: u8) -> BakeSummary {
        let plan = BakePlan::new(self.planet.recipe.radius, levels, None).unwrap();
        bake(file, &self.planet.terrain, &self.planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap()
    }

    fn whole(&self, id: PatchId) -> BakedPatch {
        let (mesh, texture, _) = self.planet.build(id);
        BakedPatch::new(&mesh, &texture).unwrap()
    }

    fn surveyed(&self, id: PatchId) -> BakedPatch {
        BakedPatch::in_part(id, &Survey::new(&self.planet.ground(), id).facts, CELLS, None, None).unwrap()
    }

    fn textured(&self, id: PatchId) -> BakedPatch {
        let ground = self.planet.ground();
        let survey = Survey::new(&ground, id);
        BakedPatch::in_part(id, &survey.facts, CELLS, None, Some(&survey.texture(&ground, &self.planet.terrain))).unwrap()
    }
}

/// Some patches of level 2.
fn ids() -> Vec<PatchId> {
    let children = |id: PatchId| id.children().unwrap();
    PatchId::roots().flat_map(children).flat_map(children).step_by(7).take(6).collect()
}

fn cache(file: &mut PlanetFile, patches: &[BakedPatch], now: i64) {
    file.cache(patches, &[], &[], now, u64::MAX).unwrap();
}

fn bytes_of(patch: &BakedPatch) -> u64 {
    (patch.geometry.len() + patch.texture.len()) as u64
}

/// Which parts a file has of a patch: facts, texture, mesh.
fn parts(file: &PlanetFile, id: PatchId) -> [bool; 3] {
    let (texture, mesh) = (file.contains_texture(id).unwrap(), file.contains(id).unwrap());
    let absent = |error: &StoreError| matches!(error, StoreError::Absent { id: named, .. } if *named == id);
    assert_eq!(file.texture(id).as_ref().err().map(absent), (!texture).then_some(true));
    assert_eq!(file.mesh(id).as_ref().err().map(absent), (!mesh).then_some(true));
    assert_eq!(file.geometry_record(id).is_ok(), mesh);
    [file.facts(id).unwrap().is_some(), texture, mesh]
}

#[test]
fn what_is_known_of_a_patch_comes_back_without_its_mesh() {
    let (site, ids) = (Site::new(), ids());
    let mut file = site.open();
    let patches = [site.surveyed(ids[0]), site.textured(ids[1]), site.whole(ids[2])];
    cache(&mut file, &patches, 1);
    for file in [&file, &PlanetFile::open(&site.path()).unwrap()] {
        assert_eq!(parts(file, ids[0]), [true, false, false]);
        assert_eq!(parts(file, ids[1]), [true, true, false]);
        assert_eq!(parts(file, ids[2]), [true, true, true]);
        assert_eq!(parts(file, ids[3]), [false, false, false]);
        for id in &ids[..3] {
            assert_eq!(file.facts(*id).unwrap(), Some(site.planet.build(*id).0.facts));
        }
        assert!(file.texture(ids[1]).unwrap() == site.planet.build(ids[1]).1);
        let mut index = file.index().unwrap();
        index.sort_by_key(|r| ids.iter().position(|id| *id == r.id));
        assert_eq!(index, patches.each_ref().map(|p| p.record));
        let known = |of: fn(&terrane_planet::store::PatchRecord) -> bool| index.iter().map(of).collect::<Vec<_>>();
        assert_eq!((known(|r| r.has_mesh()), known(|r| r.has_texture())), (vec![false, false, true], vec![false, true, true]));
        assert_eq!(file.ids().unwrap().into_iter().collect::<Vec<_>>(), [ids[2]]);
    }
}

#[test]
fn facts_that_no_builder_makes_are_not_stored() {
    let (site, id) = (Site::new(), ids()[0]);
    let mut facts = site.surveyed(id).record.facts;
    facts.child_wake = f64::NAN;
    assert!(matches!(BakedPatch::in_part(id, &facts, CELLS, None, None), Err(RecordError::Measure(_))));
    let texture = site.planet.build(id).1;
    let facts = site.surveyed(id).record.facts;
    assert!(matches!(BakedPatch::in_part(id, &facts, 16, None, Some(&texture)), Err(RecordError::Short { .. })));
}

/// Every order in which the parts may arrive leads to the same row, and none of them loses what is there.
#[test]
fn rows_are_completed_part_by_part() {
    let (site, id) = (Site::new(), ids()[0]);
    let stages = [site.surveyed(id), site.textured(id), site.whole(id)];
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    for order in orders {
        let other = Site::new();
        let mut file = other.open();
        for (now, k) in order.into_iter().enumerate() {
            cache(&mut file, &stages[k..=k], now as i64);
            let most = *order[..=now].iter().max().unwrap();
            let index = PlanetFile::open(&other.path()).unwrap().index().unwrap();
            assert_eq!(index, [stages[most].record], "{order:?} at {now}");
            assert_eq!(file.cached_bytes().unwrap(), bytes_of(&stages[most]).max(256));
        }
        assert_eq!(file.geometry_record(id).unwrap(), stages[2].geometry);
        assert_eq!(file.texture_record(id).unwrap(), stages[2].texture);
    }
    // Also within one transaction.
    let mut file = site.open();
    cache(&mut file, &stages, 1);
    assert_eq!(file.index().unwrap(), [stages[2].record]);
    assert_eq!(file.cached_bytes().unwrap(), bytes_of(&stages[2]));
}

#[test]
fn a_bake_completes_what_was_surveyed_and_keeps_it() {
    let (site, ids) = (Site::new(), ids());
    let mut file = site.open();
    cache(&mut file, &[site.surveyed(ids[0]), site.textured(ids[1]), site.whole(ids[2])], 1);
    let summary = site.bake(&mut file, 2);
    assert_eq!((summary.planned, summary.skipped, summary.built), (126, 1, 125));
    file.cache(&[], &[], &[], 2, 0).unwrap();
    assert_eq!((file.cached_bytes().unwrap(), file.ids().unwrap().len()), (0, 126));
    assert!(ids[..3].iter().all(|&id| file.mesh(id).unwrap() == site.planet.build(id).0));
    // What is there to stay is not cached by a later flight.
    cache(&mut file, &[site.surveyed(ids[0]), site.whole(ids[1])], 3);
    assert_eq!(file.cached_bytes().unwrap(), 0);
}

#[test]
fn parts_of_patches_are_not_kept_as_patches() {
    let (site, ids) = (Site::new(), ids());
    let mut file = site.open();
    cache(&mut file, &[site.surveyed(ids[0]), site.whole(ids[1])], 1);
    file.keep(&ids[..3]).unwrap();
    file.cache(&[], &[], &[], 2, 0).unwrap();
    assert_eq!([0, 1, 2].map(|k| file.facts(ids[k]).unwrap().is_some()), [false, true, false]);
}

#[test]
fn a_full_cache_lets_go_of_parts_too() {
    let (site, ids) = (Site::new(), ids());
    let mut file = site.open();
    let patches = [site.surveyed(ids[0]), site.textured(ids[1]), site.whole(ids[2]), site.surveyed(ids[3])];
    cache(&mut file, &patches, 1);
    // Completed, so used last.
    cache(&mut file, &[site.textured(ids[3])], 2);
    file.cache(&[], &[], &ids[..1], 3, 256 + bytes_of(&site.textured(ids[3]))).unwrap();
    assert_eq!([0, 1, 2, 3].map(|k| file.facts(ids[k]).unwrap().is_some()), [true, false, false, true]);
    assert_eq!(PlanetFile::open(&site.path()).unwrap().index().unwrap().len(), 2);
    file.cache(&[], &[], &[], 4, 0).unwrap();
    assert_eq!(file.index().unwrap(), []);
}

#[test]
fn an_edit_removes_parts_and_leaves_nothing_to_build_for_them() {
    let (site, near) = (Site::new(), |level| PatchId::containing(DVec3::X, level));
    let mut file = site.open();
    site.bake(&mut file, 1);
    let far = PatchId::containing(DVec3::NEG_X, 3);
    cache(&mut file, &[site.surveyed(near(3)), site.textured(near(4)), site.textured(far)], 1);
    // To stay, as far as the file knows.
    file.put(&[site.surveyed(near(5))]).unwrap();
    let reader = PlanetFile::open(&site.path()).unwrap();
    let (latitude_deg, longitude_deg) = latitude_longitude(DVec3::X);
    let edit = Edit { latitude_deg, longitude_deg, radius_m: 900.0, shape: Shape::Raise { by_m: 30.0 } };
    let changed = add(&mut file, &site.planet, edit).unwrap();
    assert!(file.pending().unwrap().iter().all(|id| id.level <= 1));
    assert_eq!([3, 4, 5].map(|level| parts(&file, near(level))), [[false; 3]; 3]);
    assert_eq!(parts(&file, far), [true, true, false]);
    // Whoever opened the file before knows nothing of the ground of now.
    assert_eq!((reader.facts(far).unwrap(), reader.contains_texture(far).unwrap()), (None, false));
    assert!(matches!(reader.texture(far), Err(StoreError::Changed { .. })));
    // What is known of a pending patch does not bring it back; building it does.
    let pending = *file.pending().unwrap().first().unwrap();
    let survey = Survey::new(&changed.planet.ground(), pending);
    file.put(&[BakedPatch::in_part(pending, &survey.facts, CELLS, None, None).unwrap()]).unwrap();
    file.keep(&[pending]).unwrap();
    assert!(file.pending().unwrap().contains(&pending));
    finish(&mut file, &changed.planet, 2, &|_| {}, &AtomicBool::new(false)).unwrap();
    assert_eq!(file.pending().unwrap(), []);
    assert_eq!(file.ids().unwrap().len(), 30);
}

/// Everything that is known of the patches of a file, or the first error.
fn read_all(path: &Path) -> Result<String, StoreError> {
    let file = PlanetFile::open(path)?;
    let index = file.index()?;
    for record in &index {
        assert_eq!(file.facts(record.id)?, Some(record.facts));
        if record.has_texture() {
            file.texture(record.id)?;
        }
    }
    Ok(format!("{index:?}"))
}

#[test]
fn damage_to_a_partial_row_is_noticed_and_never_put_right_by_completing_it() {
    let (site, ids) = (Site::new(), ids());
    let mut file = site.open();
    cache(&mut file, &[site.surveyed(ids[0]), site.textured(ids[1])], 1);
    drop(file);
    let (sound, copy) = (read_all(&site.path()).unwrap(), site.folder.path().join("b.planet"));
    let changes = [
        "UPDATE patch SET lowest = lowest - 1",
        "UPDATE patch SET child_wake = child_wake + 1",
        "UPDATE patch SET quarters = zeroblob(64)",
        "UPDATE patch SET always_awake = 4",
        "UPDATE patch SET geometry = x'01'",
        "UPDATE patch SET texture = x''",
        "UPDATE patch SET key = key + 1",
        "DELETE FROM patch WHERE length(texture) = 0",
    ];
    for change in changes {
        std::fs::copy(site.path(), &copy).unwrap();
        rusqlite::Connection::open(&copy).unwrap().execute_batch(change).unwrap();
        assert!(matches!(read_all(&copy), Err(StoreError::Damaged { .. })), "{change}");
        let mut file = PlanetFile::create_or_resume(&copy, &site.planet.header()).unwrap();
        cache(&mut file, &[site.whole(ids[0]), site.whole(ids[1])], 2);
        assert!(matches!(read_all(&copy), Err(StoreError::Damaged { .. })), "{change}, completed");
    }
    assert_eq!(read_all(&site.path()).unwrap(), sound);
}

/// Formats from 5 on have rows without parts from its start; to readers of records, no bytes were never a patch.
#[test]
fn no_bytes_are_no_record() {
    assert_eq!((FORMAT_VERSION, RECORD_VERSION), (7, 3));
    let id = ids()[0];
    assert!(matches!(geometry::decode(&[], id, CELLS), Err(RecordError::Short { found: 0, .. })));
    assert!(matches!(imagery::decode(&[], id, CELLS), Err(RecordError::Short { found: 0, .. })));
}
