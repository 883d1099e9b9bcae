//! What a planet file keeps though it could be computed again: heights around patches, and the map of clouds.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::ground::surroundings::{sample_surroundings, KnownSurroundings, Surroundings};
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::edits::{add, finish};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{Edit, Recipe, Shape};
use terrane_planet::store::surroundings::{decode, encode};
use terrane_planet::store::{PlanetFile, RecordError, StoreError};

const CELLS: u32 = 8;
const LEVELS: u8 = 3;

fn planet() -> Planet {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml");
    Planet::from_recipe(Recipe::load(&path).unwrap(), CELLS).unwrap()
}

fn baked(folder: &Path) -> (PathBuf, Planet, PlanetFile) {
    let (path, planet) = (folder.join("a.planet"), planet());
    let mut file = PlanetFile::create_or_resume(&path, &planet.header()).unwrap();
    let plan = BakePlan::new(planet.recipe.radius, LEVELS, None).unwrap();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    (path, planet, file)
}

fn all(level: u8) -> Vec<PatchId> {
    (0..level).fold(PatchId::roots().collect(), |ids, _| ids.into_iter().flat_map(|id| id.children().unwrap()).collect())
}

#[test]
fn heights_around_a_patch_are_those_of_the_terrain() {
    let folder = tempfile::tempdir().unwrap();
    let (_, planet, file) = baked(folder.path());
    for id in (0..=LEVELS).flat_map(all) {
        assert_eq!(file.surroundings(id).unwrap(), Some(sample_surroundings(&planet.ground(), id)), "{id}");
    }
    assert_eq!(file.surroundings(all(LEVELS + 1)[5]).unwrap(), None);
}

#[test]
fn an_edit_forgets_the_heights_that_it_reaches_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let (_, planet, mut file) = baked(folder.path());
    let middle = all(LEVELS)[17];
    let (latitude_deg, longitude_deg) = latitude_longitude(middle.centre());
    let edit = Edit { latitude_deg, longitude_deg, radius_m: 200.0, shape: Shape::Raise { by_m: 50.0 } };
    let changed = add(&mut file, &planet, edit).unwrap();
    finish(&mut file, &changed.planet, 2, &|_| (), &AtomicBool::new(false)).unwrap();
    let (mut same, mut rebuilt, mut gone) = (0, 0, 0);
    for id in all(LEVELS) {
        let (before, now) = (sample_surroundings(&planet.ground(), id), sample_surroundings(&changed.planet.ground(), id));
        match file.surroundings(id).unwrap() {
            Some(kept) => {
                assert_eq!(kept, now, "{id}");
                *(if before == now { &mut same } else { &mut rebuilt }) += 1;
            }
            None => gone += 1,
        }
    }
    assert!(rebuilt >= 1 && gone >= 1 && same > 300, "{rebuilt} built again, {gone} forgotten, {same} as before");
}

#[test]
fn known_surroundings_of_some_patches_are_those_and_no_others() {
    let planet = planet();
    let ground = planet.ground();
    let known = KnownSurroundings::default();
    let ids = all(1);
    ids.iter().for_each(|&id| drop(known.get(id, || Surroundings::sample(&ground, id))));
    let some = known.of_those(|id| id.x == 0);
    let is_sampled = |id: PatchId| {
        let mut sampled = false;
        some.get(id, || {
            sampled = true;
            Surroundings::sample(&ground, id)
        });
        sampled
    };
    assert!(ids.iter().all(|&id| is_sampled(id) == (id.x != 0)));
}

#[test]
fn heights_go_with_their_patch_and_count_as_its_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (_, planet, mut file) = baked(folder.path());
    let id = all(LEVELS + 1)[9];
    let around = vec![(id, encode(&sample_surroundings(&planet.ground(), id), id, CELLS).unwrap())];
    file.cache(&[], &around, &[], 1, u64::MAX).unwrap();
    assert_eq!(file.surroundings(id).unwrap(), None, "of a patch that the file does not know");
    let (mesh, texture, _) = planet.build(id);
    let patch = terrane_planet::store::BakedPatch::new(&mesh, &texture).unwrap();
    let bytes = (patch.geometry.len() + patch.texture.len()) as u64;
    for _ in 0..2 {
        file.cache(std::slice::from_ref(&patch), &around, &[], 1, u64::MAX).unwrap();
        assert!(file.surroundings(id).unwrap().is_some());
        assert_eq!(file.cached_bytes().unwrap(), bytes + around[0].1.len() as u64);
    }
    file.cache(&[], &[], &[], 2, 0).unwrap();
    assert_eq!((file.surroundings(id).unwrap(), file.cached_bytes().unwrap()), (None, 0));
}

#[test]
fn damaged_heights_are_refused() {
    let (planet, id) = (planet(), all(2)[7]);
    let heights = sample_surroundings(&planet.ground(), id);
    let record = encode(&heights, id, CELLS).unwrap();
    assert_eq!(decode(&record, id, CELLS).unwrap(), heights);
    for k in 0..record.len() {
        let mut bytes = record.clone();
        bytes[k] ^= 4;
        assert!(decode(&bytes, id, CELLS).is_err(), "byte {k}");
        assert!(decode(&record[..k], id, CELLS).is_err(), "{k} bytes");
    }
    assert!(matches!(decode(&record, all(2)[8], CELLS), Err(RecordError::Belongs { .. })));
    assert!(matches!(encode(&heights[1..], id, CELLS), Err(RecordError::Short { .. })));
    let extremes: Vec<i32> = (0..heights.len() as i32).map(|k| if k % 2 == 0 { i32::MIN } else { i32::MAX - k }).collect();
    assert_eq!(decode(&encode(&extremes, id, CELLS).unwrap(), id, CELLS).unwrap(), extremes);
}

#[test]
fn a_map_of_clouds_is_kept_whole_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _, mut file) = baked(folder.path());
    assert_eq!(file.cloud_map(64).unwrap(), None);
    let map: Vec<u8> = (0..64 * 64).map(|k: u32| (k * k / 97 % 256) as u8).collect();
    file.keep_cloud_map(&map, 64).unwrap();
    assert_eq!(PlanetFile::open(&path).unwrap().cloud_map(64).unwrap(), Some(map));
    assert!(matches!(file.cloud_map(128), Err(StoreError::Damaged { .. })), "of another size");
    assert!(matches!(PlanetFile::open(&path).unwrap().keep_cloud_map(&[0], 1), Err(StoreError::ReadOnly { .. })));
    let connection = rusqlite::Connection::open(&path).unwrap();
    let record: Vec<u8> = connection.query_row("SELECT texels FROM map", [], |row| row.get(0)).unwrap();
    for k in (0..record.len()).step_by(7) {
        let mut bytes = record.clone();
        bytes[k] ^= 1;
        connection.execute("UPDATE map SET texels = ?1", [&bytes]).unwrap();
        assert!(file.cloud_map(64).is_err(), "byte {k}");
        connection.execute("UPDATE map SET texels = ?1", [&record[..k]]).unwrap();
        assert!(file.cloud_map(64).is_err(), "{k} bytes");
    }
}
