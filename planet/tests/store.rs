//! The planet file: patches are read as they were written, and any other file at the path is refused by the name of its kind.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::builder::Faults;
use terrane_planet::planet::bake::{bake, BakePlan, BakeSummary};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{ground_text, Recipe};
use terrane_planet::store::{geometry, imagery, BakedPatch, PlanetFile, RecordError, StoreError, FORMAT_VERSION};

const CELLS: u32 = 16;

fn tiny(cells: u32) -> Planet {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml");
    Planet::from_recipe(Recipe::load(&path).unwrap(), cells).unwrap()
}

fn bake_levels(path: &Path, planet: &Planet, levels: u8) -> BakeSummary {
    let mut file = PlanetFile::create_or_resume(path, &planet.header()).unwrap();
    let plan = BakePlan::new(planet.recipe.radius, levels, None).unwrap();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, 2, &|_| (), &AtomicBool::new(false)).unwrap()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

/// Everything a reader can get out of a file, or the first error.
fn read_all(path: &Path) -> Result<String, StoreError> {
    use std::fmt::Write;
    let file = PlanetFile::open(path)?;
    let mut text = format!("{:?}", file.header());
    for record in file.index()? {
        write!(text, "{record:?}{:?}", file.mesh(record.id)?).unwrap();
        write!(
            text,
            "{}",
            crc32fast::hash(&file.texture(record.id)?.slopes.iter().flatten().map(|&b| b as u8).collect::<Vec<_>>())
        )
        .unwrap();
        write!(text, "{}", crc32fast::hash(file.texture(record.id)?.albedo.as_flattened())).unwrap();
    }
    Ok(text)
}

#[test]
fn a_file_from_before_its_places_is_the_same_planet_and_gets_them() {
    let folder = Folder::new();
    let path = folder.path("a.planet");
    let with = |places: &str| {
        let text = ground_text(&tiny(CELLS).recipe.text).into_owned() + places;
        Planet::from_recipe(Recipe::from_toml(&text, "tiny", Path::new("")).unwrap(), CELLS).unwrap()
    };
    let bare = with("");
    let view = "latitude_deg = 1\nlongitude_deg = 2\naltitude_m = 3\nheading_deg = 4\npitch_deg = 5\n";
    let placed = with(&format!("\n[[place]]\nname = \"Here\"\n{view}"));
    assert_eq!((bare.header().checksum(), bare.header().file_name()), (placed.header().checksum(), placed.header().file_name()));
    bake_levels(&path, &bare, 1);
    let patches = PlanetFile::open(&path).unwrap().index().unwrap();
    drop(PlanetFile::create_or_resume(&path, &placed.header()).unwrap());
    let file = PlanetFile::open(&path).unwrap();
    assert!(file.index().unwrap() == patches);
    assert_eq!(Planet::from_header(file.header()).unwrap().recipe.place("here").unwrap().pitch_deg, 5.0);
    drop(file);
    // Anything else in the recipe makes another planet.
    let other = Recipe::from_toml(&placed.recipe.text.replace("seed = 7", "seed = 8"), "tiny", Path::new("")).unwrap();
    let refused = PlanetFile::create_or_resume(&path, &Planet::from_recipe(other, CELLS).unwrap().header());
    assert!(matches!(refused, Err(StoreError::Differs { what: "the recipe", .. })));
}

#[test]
fn patches_come_back_as_they_were_built() {
    let (folder, planet) = (Folder::new(), tiny(32));
    let path = folder.path("a.planet");
    let summary = bake_levels(&path, &planet, 1);
    assert_eq!((summary.planned, summary.built, summary.faults), (30, 30, Faults::default()));
    let file = PlanetFile::open(&path).unwrap();
    assert_eq!(*file.header(), planet.header());
    assert_eq!(Planet::from_header(file.header()).unwrap().header(), planet.header());
    let index = file.index().unwrap();
    assert_eq!(index.len(), 30);
    for record in index {
        let (mesh, texture, _) = planet.build(record.id);
        assert!(file.mesh(record.id).unwrap() == mesh, "{}", record.id);
        assert!(file.texture(record.id).unwrap() == texture, "{}", record.id);
        assert_eq!(BakedPatch::new(&mesh, &texture).unwrap().record, record);
        assert!(
            mesh.vertices.iter().any(|v| v.wake != v.coarser_wake) || record.id.level == 0,
            "a comparison without coarser wakes"
        );
    }
}

#[test]
fn a_full_cache_keeps_baked_patches_and_what_was_used_last() {
    let (folder, planet) = (Folder::new(), tiny(CELLS));
    let path = folder.path("a.planet");
    bake_levels(&path, &planet, 0);
    let mut file = PlanetFile::create_or_resume(&path, &planet.header()).unwrap();
    let ids: Vec<PatchId> = PatchId::roots().filter_map(|root| root.children()).flatten().collect();
    let build = |id: PatchId| {
        let (mesh, texture, _) = planet.build(id);
        BakedPatch::new(&mesh, &texture).unwrap()
    };
    let patches: Vec<BakedPatch> = ids[..8].iter().map(|&id| build(id)).collect();
    let bytes = |patches: &[BakedPatch]| patches.iter().map(|p| (p.geometry.len() + p.texture.len()) as u64).sum::<u64>();
    file.cache(&patches[..4], &[], &[], 1, u64::MAX).unwrap();
    file.cache(&patches[4..], &[], &ids[..2], 2, u64::MAX).unwrap();
    assert_eq!(file.cached_bytes().unwrap(), bytes(&patches));
    // A bake makes one of them stay.
    file.keep(&ids[2..3]).unwrap();
    let budget = bytes(&patches) - bytes(&patches[2..4]);
    file.cache(&[], &[], &[], 3, budget).unwrap();
    let there = |k: usize| file.contains(ids[k]).unwrap();
    assert_eq!((0..8).filter(|&k| !there(k)).collect::<Vec<_>>(), [3], "only what was unused for longest goes");
    assert_eq!(file.cached_bytes().unwrap(), budget);
    // The index still agrees with the stored count of patches, and the patches are those that a bake makes.
    assert_eq!(PlanetFile::open(&path).unwrap().index().unwrap().len(), 6 + 7);
    assert!(file.mesh(ids[0]).unwrap() == planet.build(ids[0]).0);
    file.cache(&[], &[], &[], 4, 0).unwrap();
    let index = PlanetFile::open(&path).unwrap().index().unwrap();
    assert_eq!(index.iter().filter(|r| r.id.level > 0).map(|r| r.id).collect::<Vec<_>>(), ids[2..3]);
}

#[test]
fn a_patch_that_was_not_baked_is_absent() {
    let (folder, planet) = (Folder::new(), tiny(CELLS));
    let path = folder.path("a.planet");
    bake_levels(&path, &planet, 0);
    let file = PlanetFile::open(&path).unwrap();
    let [root, child] = [PatchId::roots().next().unwrap(), PatchId::roots().next().unwrap().children().unwrap()[3]];
    assert!(file.contains(root).unwrap() && !file.contains(child).unwrap());
    assert!(matches!(file.mesh(child), Err(StoreError::Absent { id, .. }) if id == child));
}

#[test]
fn a_file_opened_for_reading_refuses_patches() {
    let (folder, planet) = (Folder::new(), tiny(CELLS));
    let path = folder.path("a.planet");
    bake_levels(&path, &planet, 0);
    let mut file = PlanetFile::open(&path).unwrap();
    assert!(matches!(file.put(&[]), Err(StoreError::ReadOnly { .. })));
}

#[test]
fn another_planet_does_not_resume() {
    let (folder, planet) = (Folder::new(), tiny(CELLS));
    let path = folder.path("a.planet");
    bake_levels(&path, &planet, 0);
    let mut other = planet.header();
    other.recipe.push_str("\n# changed\n");
    let mut assets = planet.header();
    assets.assets.push(terrane_planet::recipe::Asset { name: "a.png".into(), bytes: vec![1] });
    for (header, what) in [(tiny(32).header(), "cells"), (other, "the recipe"), (assets, "files")] {
        let error = PlanetFile::create_or_resume(&path, &header).unwrap_err();
        assert!(matches!(error, StoreError::Differs { .. }) && error.to_string().contains(what), "{error}");
    }
    assert!(PlanetFile::create_or_resume(&path, &planet.header()).is_ok());
}

/// One of the whole faces as it goes into a file.
fn baked_root() -> BakedPatch {
    let (mesh, texture, _) = tiny(CELLS).build(PatchId::roots().nth(4).unwrap());
    BakedPatch::new(&mesh, &texture).unwrap()
}

#[test]
fn every_flipped_byte_of_a_record_is_noticed() {
    let baked = baked_root();
    let id = baked.record.id;
    assert!(geometry::decode(&baked.geometry, id, CELLS).is_ok() && imagery::decode(&baked.texture, id, CELLS).is_ok());
    for k in 0..baked.geometry.len() {
        let mut bytes = baked.geometry.clone();
        bytes[k] ^= 0x10;
        assert!(geometry::decode(&bytes, id, CELLS).is_err(), "byte {k}");
        assert!(geometry::decode(&baked.geometry[..k], id, CELLS).is_err(), "cut at {k}");
    }
    for k in (0..baked.texture.len()).step_by(7) {
        let mut bytes = baked.texture.clone();
        bytes[k] ^= 0x10;
        assert!(imagery::decode(&bytes, id, CELLS).is_err(), "byte {k}");
    }
}

/// The checksum is computed again after the damage, so that only the decoder's own checks can find it.
#[test]
fn damage_behind_a_right_checksum_never_panics() {
    let baked = baked_root();
    let id = baked.record.id;
    let seal = |bytes: &mut [u8]| assert!(geometry::seal(bytes, id, CELLS));
    let mut resealed = baked.geometry.clone();
    seal(&mut resealed);
    assert_eq!(resealed, baked.geometry, "the test does not know where the checksum is");
    let mut reached_beyond = 0;
    for k in 0..baked.geometry.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = baked.geometry.clone();
            bytes[k] ^= flip;
            seal(&mut bytes);
            match geometry::decode(&bytes, id, CELLS) {
                Err(RecordError::Checksum { .. }) => panic!("the seal is wrong at {k}"),
                Err(RecordError::Chunk { reason, .. }) => {
                    assert!(!matches!(*reason, RecordError::Checksum { .. }), "the seal is wrong at {k}");
                    reached_beyond += usize::from(matches!(*reason, RecordError::Vertex { .. }));
                }
                Ok(_) => reached_beyond += 1,
                Err(_) => {}
            }
        }
    }
    assert!(reached_beyond > 0, "no damage got past the envelope");
    let stated_length = u32::MAX.to_le_bytes();
    let mut huge = baked.geometry.clone();
    let first = geometry::head_bytes(CELLS);
    huge[first..first + 4].copy_from_slice(&stated_length);
    seal(&mut huge);
    let error = geometry::decode(&huge, id, CELLS).unwrap_err();
    assert!(error.to_string().starts_with("chunk 1 of 1: wake steps ends after"), "{error}");
}

#[test]
fn records_of_other_patches_versions_and_grids_are_told_apart() {
    let planet = tiny(CELLS);
    let id = PatchId::roots().next().unwrap();
    let other = PatchId::roots().nth(1).unwrap();
    let (mesh, texture, _) = planet.build(id);
    let baked = BakedPatch::new(&mesh, &texture).unwrap();
    assert!(matches!(geometry::decode(&baked.geometry, other, CELLS), Err(RecordError::Belongs { .. })));
    assert!(matches!(geometry::decode(&baked.geometry, id, 32), Err(RecordError::Belongs { .. })));
    assert!(matches!(geometry::decode(&baked.texture, id, CELLS), Err(RecordError::Magic { .. })));
    let mut newer = baked.geometry.clone();
    newer[4] = 9;
    assert!(matches!(geometry::decode(&newer, id, CELLS), Err(RecordError::Version { found: 9, expected: 3 })));
    assert!(matches!(geometry::decode(&[], id, CELLS), Err(RecordError::Short { .. })));
}

/// Flips bytes all over a file: a reader gets an error, or exactly what was written; never something else, never a panic.
#[test]
fn a_damaged_file_never_reads_as_another_planet() {
    let (folder, planet) = (Folder::new(), tiny(CELLS));
    let (path, damaged) = (folder.path("a.planet"), folder.path("b.planet"));
    bake_levels(&path, &planet, 0);
    let bytes = std::fs::read(&path).unwrap();
    let original = read_all(&path).unwrap();
    let (mut refused, mut harmless) = (0, 0);
    let stride = bytes.len() / 700 + 1;
    for at in (0..120).chain((120..bytes.len()).step_by(stride)).chain((0..bytes.len()).step_by(8192).flat_map(|p| p..p + 12)) {
        let mut copy = bytes.clone();
        copy[at] ^= 0x41;
        std::fs::write(&damaged, &copy).unwrap();
        match read_all(&damaged) {
            Ok(text) => {
                assert!(text == original, "byte {at} changed what is read");
                harmless += 1;
            }
            Err(StoreError::System { .. } | StoreError::ReadOnly { .. } | StoreError::Differs { .. }) => {
                panic!("byte {at}: wrong kind of error")
            }
            Err(error) => {
                assert!(error.to_string().contains("b.planet"), "no file name: {error}");
                refused += 1;
            }
        }
    }
    // Damage to SQLite's change counters and to free space within pages is harmless.
    assert!(refused > 200, "{refused} refused, {harmless} harmless");
}

#[test]
fn a_truncated_file_is_refused() {
    let (folder, planet) = (Folder::new(), tiny(8));
    let (path, cut) = (folder.path("a.planet"), folder.path("b.planet"));
    bake_levels(&path, &planet, 0);
    let bytes = std::fs::read(&path).unwrap();
    for length in [1, 15, 50, 99, 100, 4000, 8192, 8193, bytes.len() / 2, bytes.len() - 8192, bytes.len() - 1] {
        std::fs::write(&cut, &bytes[..length]).unwrap();
        let error = PlanetFile::open(&cut).unwrap_err();
        assert!(matches!(error, StoreError::Damaged { .. } | StoreError::Foreign { .. }), "{length}: {error:?}");
        assert!(PlanetFile::create_or_resume(&cut, &planet.header()).is_err(), "{length}");
    }
}

#[test]
fn foreign_files_are_refused_by_name_and_left_alone() {
    let (folder, planet) = (Folder::new(), tiny(CELLS));
    let path = folder.path("a.planet");
    let database = folder.path("other.db");
    rusqlite::Connection::open(&database).unwrap().execute_batch("CREATE TABLE patch (a); INSERT INTO patch VALUES (1)").unwrap();
    let cases: [(Vec<u8>, &str); 4] = [
        (Vec::new(), "an empty file"),
        (b"\x89PNG\r\n\x1a\n....".to_vec(), "a PNG image"),
        (b"some notes\n".to_vec(), "a text file"),
        (std::fs::read(&database).unwrap(), "another SQLite database"),
    ];
    for (bytes, name) in cases {
        std::fs::write(&path, &bytes).unwrap();
        for error in [PlanetFile::open(&path).unwrap_err(), PlanetFile::create_or_resume(&path, &planet.header()).unwrap_err()] {
            assert!(matches!(error, StoreError::Foreign { .. }) && error.to_string().contains(name), "{error}");
        }
        assert_eq!(std::fs::read(&path).unwrap(), bytes, "{name} was changed");
    }
}

#[test]
fn other_format_versions_are_refused_with_both_versions() {
    let (folder, planet) = (Folder::new(), tiny(8));
    let path = folder.path("a.planet");
    bake_levels(&path, &planet, 0);
    for (version, advice) in [(99, "newer Terrane"), (0, "older Terrane")] {
        rusqlite::Connection::open(&path).unwrap().pragma_update(None, "user_version", version).unwrap();
        let error = PlanetFile::open(&path).unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, StoreError::Version { found, expected: FORMAT_VERSION, .. } if found == version), "{text}");
        assert!(text.contains(advice) && text.contains(&version.to_string()), "{text}");
    }
}

#[test]
fn a_row_that_is_taken_away_is_noticed() {
    let (folder, planet) = (Folder::new(), tiny(8));
    let path = folder.path("a.planet");
    bake_levels(&path, &planet, 0);
    assert!(PlanetFile::open(&path).unwrap().index().is_ok());
    rusqlite::Connection::open(&path).unwrap().execute("DELETE FROM patch WHERE face = 3", []).unwrap();
    let error = PlanetFile::open(&path).unwrap().index().unwrap_err();
    assert!(error.to_string().contains("5 patches"), "{error}");
}

#[test]
fn readers_see_whole_batches_while_a_bake_goes_on() {
    let (folder, planet) = (Folder::new(), tiny(CELLS));
    let path = folder.path("a.planet");
    bake_levels(&path, &planet, 0);
    let counts = std::thread::scope(|scope| {
        let baker = scope.spawn(|| bake_levels(&path, &planet, 2));
        let mut counts = Vec::new();
        while !baker.is_finished() {
            let file = PlanetFile::open(&path).unwrap();
            let index = file.index().unwrap();
            file.mesh(index[index.len() - 1].id).unwrap();
            counts.push(index.len());
        }
        counts
    });
    assert!(counts.is_sorted() && counts.len() > 2, "{counts:?}");
    assert_eq!(PlanetFile::open(&path).unwrap().index().unwrap().len(), 126);
}

/// A process that dies within a transaction leaves a half-written file and a journal that undoes it.
#[test]
fn a_half_written_transaction_is_rolled_back_by_the_next_reader() {
    let (folder, planet) = (Folder::new(), tiny(8));
    let (path, crashed) = (folder.path("a.planet"), folder.path("crashed.planet"));
    bake_levels(&path, &planet, 0);
    let original = read_all(&path).unwrap();
    let connection = rusqlite::Connection::open(&path).unwrap();
    // With a cache of one page, changes reach the file long before the end of the transaction.
    connection.execute_batch("PRAGMA cache_size = 1; BEGIN; UPDATE patch SET texture = zeroblob(90000)").unwrap();
    std::fs::copy(&path, &crashed).unwrap();
    let half_written = std::fs::read(&crashed).unwrap();
    std::fs::copy(folder.path("a.planet-journal"), folder.path("crashed.planet-journal")).unwrap();
    connection.execute_batch("ROLLBACK").unwrap();
    assert_ne!(half_written, std::fs::read(&path).unwrap(), "nothing was half written");
    assert_eq!(read_all(&crashed).unwrap(), original);
    assert_eq!(bake_levels(&crashed, &planet, 0).skipped, 6);
}

#[test]
fn a_planet_file_moves_between_threads() {
    fn is_send<T: Send>() {}
    is_send::<PlanetFile>();
}
