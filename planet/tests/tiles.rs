//! Tiles as files: what is written, read by a reader of its own, lies within its stated errors and closes all gaps; the checker finds faults.

use glam::DVec3;
use serde_json::Value;
use std::collections::HashMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use terrane_planet::globe::patch::{PatchId, Side};
use terrane_planet::globe::sphere::direction;
use terrane_planet::planet::bake::BakePlan;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{shipped, Edit, Shape};
use terrane_planet::store::Region;
use terrane_planet::tiles::{check, Certified, PictureCodec, Published, TileMaker, Watch};

const CELLS: u32 = 16;
const LEVELS: u8 = 2;

/// Pictures need not be pictures here.
struct Plain;

impl PictureCodec for Plain {
    fn jpeg(&self, _: [u32; 2], texels: &[[u8; 3]]) -> Result<Vec<u8>, String> {
        Ok(texels.as_flattened().to_vec())
    }
}

fn tiny() -> Planet {
    Planet::from_recipe(shipped::load("tiny").unwrap(), CELLS).unwrap()
}

fn publish(planet: &Planet, plan: &BakePlan, folder: &Path) -> (Certified, Published) {
    let maker = TileMaker { planet, source: &|_| Ok(None), map_side: 64, codec: None, pictures: &Plain, skirts: true };
    let watch = Watch { progress: &|_, _| (), stop: &AtomicBool::new(false) };
    let certified = maker.certify(&plan.patches, &watch).unwrap().unwrap();
    let published = maker.publish(&certified, folder, &watch).unwrap().unwrap();
    (certified, published)
}

fn unpacked(_: usize, _: usize, _: &[u8]) -> Result<Vec<u8>, String> {
    Err("nothing is packed here".into())
}

fn faults(folder: &Path) -> Vec<String> {
    check::check(folder, &unpacked).described
}

/// A tile as a client has it.
struct Drawn {
    error: f64,
    points: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Drawn {
    /// Distance from the centre of the outermost triangle in a direction.
    fn radius(&self, direction: DVec3) -> Option<f64> {
        let meet = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|v| self.points[v]);
            // Beside the ray, where numbers are small.
            let [p, q, r] = [a, b, c].map(|v| v - direction * v.dot(direction));
            let shares = [q.cross(r), r.cross(p), p.cross(q)].map(|n| n.dot(direction));
            let total = shares.iter().sum::<f64>();
            let inside = a.dot(direction) > 0.0 && total > 0.0 && shares.iter().all(|&s| s >= -1e-7 * total);
            let along = [a, b, c].map(|v| v.dot(direction));
            inside.then(|| shares.iter().zip(along).map(|(share, along)| share / total * along).sum())
        };
        self.triangles.iter().filter_map(meet).max_by(f64::total_cmp)
    }
}

/// All tiles below one of a tileset, by the names of their patches.
fn read(folder: &Path, file: &str, tile: &Value, tiles: &mut HashMap<String, Drawn>) {
    let uri = tile["content"]["uri"].as_str().map(|uri| match file.split_once('/') {
        Some(_) => uri.trim_start_matches("../").to_owned(),
        None => uri.to_owned(),
    });
    match uri {
        Some(uri) if uri.ends_with(".json") => {
            let inner: Value = serde_json::from_slice(&std::fs::read(folder.join(&uri)).unwrap()).unwrap();
            read(folder, &uri, &inner["root"], tiles);
        }
        Some(uri) => {
            let drawn = glb(&std::fs::read(folder.join(&uri)).unwrap(), tile["extras"]["error_m"].as_f64().unwrap());
            tiles.insert(tile["extras"]["patch"].as_str().unwrap().to_owned(), drawn);
        }
        None => {}
    }
    for child in tile["children"].as_array().into_iter().flatten() {
        read(folder, file, child, tiles);
    }
}

fn glb(bytes: &[u8], error: f64) -> Drawn {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let document: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let binary = &bytes[28 + length..];
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let mut drawn = Drawn { error, points: Vec::new(), triangles: Vec::new() };
    for node in document["nodes"].as_array().unwrap() {
        let metres = |k: usize| node["translation"][k].as_f64().unwrap();
        let step = node["scale"][0].as_f64().unwrap();
        let primitive = &document["meshes"][number(&node["mesh"])]["primitives"][0];
        let part = |accessor: &Value| {
            let accessor = &document["accessors"][number(accessor)];
            (
                &binary[number(&document["bufferViews"][number(&accessor["bufferView"])]["byteOffset"])..],
                number(&accessor["count"]),
            )
        };
        let first = drawn.points.len();
        let (positions, count) = part(&primitive["attributes"]["POSITION"]);
        let short = |at: usize| f64::from(i16::from_le_bytes([positions[at], positions[at + 1]]));
        drawn.points.extend((0..count).map(|v| {
            let [x, y, z] = [0, 1, 2].map(|k| metres(k) + step * short(8 * v + 2 * k));
            DVec3::new(x, -z, y)
        }));
        let (corners, count) = part(&primitive["indices"]);
        let corner = |k: usize| first + usize::from(u16::from_le_bytes([corners[2 * k], corners[2 * k + 1]]));
        drawn.triangles.extend((0..count / 3).map(|t| [corner(3 * t), corner(3 * t + 1), corner(3 * t + 2)]));
    }
    drawn
}

fn all(folder: &Path) -> HashMap<String, Drawn> {
    let root: Value = serde_json::from_slice(&std::fs::read(folder.join("tileset.json")).unwrap()).unwrap();
    let mut tiles = HashMap::new();
    read(folder, "tileset.json", &root["root"], &mut tiles);
    tiles
}

/// The surface in a direction in metres from the centre: the terrain itself, or the sea.
fn surface(planet: &Planet, direction: DVec3) -> f64 {
    let height = planet.terrain.height(direction);
    planet.recipe.radius + planet.terrain.ground_or_sea(&planet.recipe, direction, height)
}

#[test]
fn every_tile_lies_within_its_stated_error_of_the_terrain_at_the_finest_samples() {
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let plan = BakePlan::new(planet.recipe.radius, LEVELS, None).unwrap();
    let (_, published) = publish(&planet, &plan, folder.path());
    assert_eq!((published.tiles, published.removed), (126, 0));
    let tiles = all(folder.path());
    let mut worst = [0.0_f64; 3];
    for &id in &plan.patches {
        let tile = &tiles[&id.to_string()];
        // The samples of level 2 inside and on the borders of the patch.
        let along = CELLS << (LEVELS - id.level);
        for k in (0..(along + 1) * (along + 1)).step_by(if id.level == LEVELS { 1 } else { 7 }) {
            let up = direction(id.point((k % (along + 1)) as i32, (k / (along + 1)) as i32, along));
            let found = tile.radius(up).unwrap_or_else(|| panic!("{id}: a hole at sample {k}"));
            let off = (found - surface(&planet, up)).abs();
            assert!(off <= tile.error + planet.lattice.unit, "{id}: {off} m off at sample {k}, stated {} m", tile.error);
            worst[usize::from(id.level)] = worst[usize::from(id.level)].max(off / tile.error);
        }
    }
    assert!(worst.iter().all(|share| (0.2..=1.01).contains(share)), "errors are stated for what they are: {worst:?}");
}

#[test]
fn skirts_reach_below_whatever_may_stand_across() {
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let region = Region { direction: DVec3::new(0.6, 0.64, 0.48), radius_m: 3000.0, to_level: 4 };
    let plan = BakePlan::new(planet.recipe.radius, 1, Some(region)).unwrap();
    let (certified, _) = publish(&planet, &plan, folder.path());
    assert_eq!(faults(folder.path()), Vec::<String>::new());
    let tiles = all(folder.path());
    let related = |a: PatchId, b: PatchId| a.ancestor(b.level.min(a.level)) == b.ancestor(a.level.min(b.level));
    let (mut pairs, mut deepest) = (0, 0.0_f64);
    for &id in &plan.patches {
        for side in Side::ALL {
            let promise = certified.promise(id).unwrap();
            for k in 1..CELLS as i32 {
                let n = CELLS as i32;
                let [a, b] = match side {
                    Side::Left => [0, k],
                    Side::Right => [n, k],
                    Side::Bottom => [k, 0],
                    Side::Top => [k, n],
                };
                let up = direction(id.point(a, b, CELLS));
                let Some(own) = tiles[&id.to_string()].radius(up) else { panic!("{id}: a hole on its border") };
                // What lies a little outside, at every level that is there.
                let outside = (up + (up - id.centre()) * 1e-7).normalize();
                for level in 0..=4 {
                    let other = PatchId::containing(outside, level);
                    let Some(tile) = tiles.get(&other.to_string()).filter(|_| !related(id, other)) else { continue };
                    let Some(across) = tile.radius(up) else { continue };
                    let (gap, depth) = (own - across, promise.skirts[side as usize]);
                    assert!(gap < depth, "{id} {side:?} beside {other}: {gap} m, and a skirt of {depth} m");
                    pairs += 1;
                    deepest = deepest.max(gap / depth);
                }
            }
        }
    }
    assert!(pairs > 5000 && deepest > 0.2, "{pairs} pairs, at most {deepest} of a skirt");
}

#[test]
fn tiles_of_the_deepest_levels_are_as_good() {
    let (planet, folder) = (Planet::from_recipe(shipped::load("terra").unwrap(), CELLS).unwrap(), tempfile::tempdir().unwrap());
    let mut patches: Vec<PatchId> = PatchId::roots().collect();
    let mut deep = PatchId::containing(DVec3::new(0.3, 0.5, 0.4), 0);
    while let Some(children) = deep.children() {
        patches.extend(children);
        deep = children[usize::from(deep.level) % 4];
    }
    let plan = BakePlan { patches, region: None };
    publish(&planet, &plan, folder.path());
    assert_eq!(faults(folder.path()), Vec::<String>::new());
    let tiles = all(folder.path());
    for id in plan.patches.iter().filter(|id| id.level == 21) {
        let tile = &tiles[&id.to_string()];
        for k in 0..(CELLS + 1) * (CELLS + 1) {
            let up = direction(id.point((k % (CELLS + 1)) as i32, (k / (CELLS + 1)) as i32, CELLS));
            let off = (tile.radius(up).unwrap() - surface(&planet, up)).abs();
            assert!(off <= tile.error + planet.lattice.unit, "{id}: {off} m off at sample {k}, stated {} m", tile.error);
        }
    }
    let finest = tiles[&deep.to_string()].error;
    assert!(finest < 0.2, "{finest} m at tiles of 5 m");
}

#[test]
fn what_has_not_changed_is_not_written_again() {
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let plan = BakePlan::new(planet.recipe.radius, LEVELS, None).unwrap();
    let (_, first) = publish(&planet, &plan, folder.path());
    assert_eq!((first.written, first.kept), (127, 0));
    let (_, again) = publish(&planet, &plan, folder.path());
    assert_eq!((again.written, again.kept, again.removed), (0, 127, 0));
    let shape = Shape::Crater { depth_m: 60.0, ground_m: None };
    let edit = Edit { latitude_deg: 10.0, longitude_deg: 20.0, radius_m: 400.0, shape };
    let recipe = shipped::load("tiny").unwrap().with_edit(&edit).unwrap();
    let edited = Planet::from_recipe(recipe, CELLS).unwrap();
    let (_, changed) = publish(&edited, &plan, folder.path());
    assert!((1..40).contains(&changed.written) && changed.removed < 40 && changed.removed > 0, "{changed:?}");
    assert_eq!(faults(folder.path()), Vec::<String>::new());
    // What is no tile stays.
    std::fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    publish(&planet, &plan, folder.path());
    assert!(folder.path().join("notes.txt").exists());
}

#[test]
fn the_check_finds_what_is_wrong() {
    let (planet, folder) = (tiny(), tempfile::tempdir().unwrap());
    let plan = BakePlan::new(planet.recipe.radius, 1, None).unwrap();
    publish(&planet, &plan, folder.path());
    let found = check::check(folder.path(), &unpacked);
    assert_eq!((found.tiles, found.files, found.faults, found.strays), (30, 31, 0, 0), "{found:?}");
    let path = folder.path().join("tileset.json");
    let good = std::fs::read_to_string(&path).unwrap();
    let with = |change: &dyn Fn(&mut Value)| {
        let mut root: Value = serde_json::from_str(&good).unwrap();
        change(&mut root);
        std::fs::write(&path, root.to_string()).unwrap();
        let found = faults(folder.path()).join("\n");
        std::fs::write(&path, &good).unwrap();
        found
    };
    for (wanted, change) in [
        (
            "geometricError",
            &(|root: &mut Value| root["root"]["children"][0]["children"][1]["geometricError"] = 1e9.into())
                as &dyn Fn(&mut Value),
        ),
        ("its box leaves", &|root| root["root"]["children"][0]["children"][2]["boundingVolume"]["box"][0] = 0.0.into()),
        ("a vertex lies", &|root| root["root"]["children"][0]["boundingVolume"]["box"][0] = 0.0.into()),
        ("leads out of the folder", &|root| root["root"]["children"][0]["content"]["uri"] = "../x.glb".into()),
        ("No such file", &|root| root["root"]["children"][0]["content"]["uri"] = "00/00.glb".into()),
        ("expected 1.1", &|root| root["asset"]["version"] = "1.0".into()),
        ("expected REPLACE", &|root| root["root"]["refine"] = "ADD".into()),
        ("no box", &|root| root["root"]["children"][3]["boundingVolume"]["box"] = Value::Null),
        ("two tiles lead to it", &|root| root["root"]["children"][3]["content"]["uri"] = "tileset.json".into()),
    ] {
        let found = with(change);
        assert!(found.contains(wanted), "expected '{wanted}', found '{found}'");
    }
    let content = walk(folder.path());
    let mut bytes = std::fs::read(&content).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    std::fs::write(&content, &bytes).unwrap();
    assert!(faults(folder.path()).join("").contains("have the hash"));
    std::fs::write(&content, &bytes[..100]).unwrap();
    assert!(faults(folder.path()).join("").contains("no GLB"));
    assert!(check::check(&folder.path().join("nowhere"), &unpacked).faults == 1);
}

/// The file of some tile.
fn walk(folder: &Path) -> std::path::PathBuf {
    let root: Value = serde_json::from_slice(&std::fs::read(folder.join("tileset.json")).unwrap()).unwrap();
    folder.join(root["root"]["children"][0]["content"]["uri"].as_str().unwrap())
}
