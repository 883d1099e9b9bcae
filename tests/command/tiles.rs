//! `terrane tiles` as a process: what it says, what it keeps, and what Khronos's validator, CesiumJS and 3DTilesRendererJS make of it. The
//! clients run in headless Chromium from npm packages in target/web; where Node, npm or Chromium is missing, or with `TERRANE_QUICK=1`
//! (`tools/test --quick`), that part says "skipped".

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};
use crate::gltf::{unseen, validate, validator};
use glam::DVec3;
use serde_json::{json, Value};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::{direction, direction_at, latitude_longitude};
use terrane_planet::planet::bake::BakePlan;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::shipped;
use terrane_planet::store::Region;

/// A place on Tiny, around which tiles are finer.
const SITE: [f64; 2] = [12.0, 24.0];
const REGION: [&str; 6] = ["--levels", "1", "--region", "12,24,2", "--to-level", "4"];

/// Rays of a picture: four pictures have 200.
const RAYS: usize = 50;

/// Metres that rays may miss by beside the stated error: clients compute in single precision.
const SLACK_M: f64 = 0.05;

fn summary(arguments: &[&str], folder: &Path) -> Value {
    let output = terrane(&[arguments, &["--json"]].concat(), folder);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn glbs(folder: &Path) -> Vec<PathBuf> {
    let folders = std::fs::read_dir(folder).unwrap().flatten().filter(|entry| entry.path().is_dir());
    let files = folders.flat_map(|folder| std::fs::read_dir(folder.path()).unwrap().flatten());
    files.map(|file| file.path()).filter(|path| path.extension().is_some_and(|extension| extension == "glb")).collect()
}

#[test]
fn tiles_are_written_checked_and_kept_and_the_validator_of_khronos_finds_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let made = summary(&["tiles", "tiny", "--out", "t", "--levels", "1", "--maps", "64"], folder.path());
    assert_eq!((&made["tiles"], &made["written"], &made["kept"]), (&json!(30), &json!(31), &json!(0)), "{made}");
    let again = summary(&["tiles", "tiny", "--out", "t", "--levels", "1", "--maps", "64"], folder.path());
    assert_eq!((&again["written"], &again["kept"], &again["removed"]), (&json!(0), &json!(31), &json!(0)), "{again}");
    let packed = summary(&["tiles", "tiny", "--out", "p", "--levels", "1", "--maps", "64", "--pack"], folder.path());
    assert!(packed["bytes"].as_u64().unwrap() < 3 * made["bytes"].as_u64().unwrap() / 4, "{packed} of {made}");
    assert_eq!(packed["triangles"], made["triangles"]);
    assert_eq!(summary(&["tiles", "--check", "p"], folder.path())["faults"], 0);
    if let Some(validator) = validator() {
        let files = glbs(&folder.path().join("t"));
        assert_eq!(files.len(), 30);
        for file in files {
            let (found, info) = validate(&validator, &file);
            assert!(found.is_empty(), "{found:?}");
            assert_eq!(info["hasTextures"], true);
        }
        for file in glbs(&folder.path().join("p")).iter().take(4) {
            assert_eq!(validate(&validator, file).0, unseen(&["--quantize", "--maps"]));
        }
    }
    std::fs::write(&glbs(&folder.path().join("t"))[0], "no tile").unwrap();
    let output = terrane(&["tiles", "--check", "t"], folder.path());
    let said = text(&output.stderr);
    assert!(output.status.code() == Some(1) && said.contains("faults; make the tiles again") && said.contains("hash"), "{said}");
    for (arguments, message) in [
        (&["tiles", "tiny", "--out", "x", "--maps", "100"][..], "expected a power of two"),
        (&["tiles", "nobody", "--out", "x"], "no recipe nobody"),
        (&["tiles", "tiny", "--out", "x", "--levels", "40"], "level 40 is too deep"),
        (&["tiles", "--check", "nowhere"], "nowhere/tileset.json"),
    ] {
        let output = terrane(arguments, folder.path());
        assert!(output.status.code() == Some(1) && text(&output.stderr).contains(message), "{}", text(&output.stderr));
    }
}

/// The folder of the npm packages, fetched if they are not there.
fn packages() -> Option<PathBuf> {
    let skipped = |why: &str| println!("skipped: {why}, so that no other renderer draws tiles");
    if std::env::var_os("TERRANE_QUICK").is_some_and(|quick| quick == "1") {
        skipped("TERRANE_QUICK=1");
        return None;
    }
    let answers = |program: &str| Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success());
    if let Some(missing) = ["node", "npm", &chromium()].into_iter().find(|program| !answers(program)) {
        skipped(&format!("{missing} is not installed"));
        return None;
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/web");
    std::fs::create_dir_all(&folder).ok()?;
    let mut is_new = !folder.join("node_modules/.package-lock.json").exists();
    for name in ["package.json", "package-lock.json"] {
        let wanted = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("web").join(name)).unwrap();
        is_new |= std::fs::read(folder.join(name)).ok() != Some(wanted.clone());
        std::fs::write(folder.join(name), wanted).unwrap();
    }
    let fetch = ["ci", "--ignore-scripts", "--legacy-peer-deps", "--no-audit", "--no-fund", "--silent"];
    if is_new && !Command::new("npm").args(fetch).current_dir(&folder).status().is_ok_and(|status| status.success()) {
        std::fs::remove_file(folder.join("package.json")).unwrap();
        skipped("npm cannot fetch the packages of tools/web");
        return None;
    }
    Some(folder.canonicalize().unwrap())
}

fn chromium() -> String {
    std::env::var("CHROMIUM").unwrap_or_else(|_| "/usr/bin/chromium".into())
}

/// What clients make of jobs: a report a picture.
fn drawn(packages: &Path, folder: &Path, jobs: &Value) -> Vec<Value> {
    let list = folder.join("jobs.json");
    std::fs::write(&list, jobs.to_string()).unwrap();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pages = here.join("web").canonicalize().unwrap();
    let script = here.join("../tests/command/tiles_in_browsers.mjs");
    let output =
        Command::new("node").arg(script).arg(packages).arg(pages).arg(list).env("CHROMIUM", chromium()).output().unwrap();
    assert!(output.status.success(), "{}\n{}", text(&output.stdout), text(&output.stderr));
    text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The planet of the test, its finest patches, and what its surface is.
struct World {
    planet: Planet,
    leaves: Vec<PatchId>,
}

impl World {
    fn new() -> World {
        let planet = Planet::from_recipe(shipped::load("tiny").unwrap(), 64).unwrap();
        let region = Region { direction: direction_at(SITE[0], SITE[1]), radius_m: 2000.0, to_level: 4 };
        let plan = BakePlan::new(planet.recipe.radius, 1, Some(region)).unwrap().patches;
        let parents: HashSet<PatchId> = plan.iter().filter_map(|id| id.parent()).collect();
        World { leaves: plan.into_iter().filter(|id| !parents.contains(id)).collect(), planet }
    }

    /// Metres from the centre to ground or sea.
    fn surface(&self, direction: DVec3) -> f64 {
        let height = self.planet.terrain.height(direction);
        self.planet.recipe.radius + self.planet.terrain.ground_or_sea(&self.planet.recipe, direction, height)
    }

    /// Samples of the finest patches within an angle of a direction, where tiles are compared with the terrain itself.
    fn samples(&self, about: DVec3, angle: f64) -> Vec<DVec3> {
        let inside = |id: &PatchId| {
            let id = *id;
            (0..64 * 64).filter(|k| k % 64 > 0 && k / 64 > 0).map(move |k| direction(id.point(k % 64, k / 64, 64)))
        };
        let near: Vec<DVec3> = self.leaves.iter().flat_map(inside).filter(|d| d.angle_between(about) < angle).collect();
        assert!(near.len() >= RAYS, "{} samples", near.len());
        (0..RAYS).map(|k| near[k * near.len() / RAYS]).collect()
    }

    /// Orbit, limb and 2 km above the site.
    fn views(&self) -> Value {
        let (site, radius) = (direction_at(SITE[0], SITE[1]), self.planet.recipe.radius);
        let view = |name: &str, eye: DVec3, target: DVec3, picks: &[DVec3]| {
            let picks: Vec<[f64; 3]> = picks.iter().map(|d| d.to_array()).collect();
            json!({
                "name": name, "eye": eye.to_array(), "target": target.to_array(), "up": [0.0, 0.0, 1.0], "degrees": 50.0, "picks": picks,
            })
        };
        let north = (DVec3::Z - site * site.z).normalize();
        let low = site * (self.surface(site) + 2000.0);
        json!([
            view("orbit", site * 3.2 * radius, DVec3::ZERO, &self.samples(site, 0.9)),
            view("limb", site * 1.25 * radius, (site * 0.8 + north * 0.6) * radius, &[]),
            view("near", low, DVec3::ZERO, &self.samples(site, 700.0 / radius)),
        ])
    }

    fn job(&self, name: &str, client: &str, tiles: &Path, out: &Path, views: &Value) -> Value {
        let (radius, sea) = (self.planet.recipe.radius, self.planet.recipe.sea.as_ref().unwrap().level_m);
        json!({
            "name": name, "client": client, "tiles": tiles, "out": out, "size": [640, 480], "pixels": 16, "views": views,
            "low": radius + sea, "high": radius + self.planet.terrain.height_range().1,
        })
    }

    /// What is wrong with a picture.
    fn faults(&self, report: &Value, views: &Value) -> Vec<String> {
        let name = format!("{} {} {}", report["job"], report["client"], report["view"]);
        let mut found = Vec::new();
        let number = |key: &str| report[key].as_f64().unwrap();
        for (key, wanted) in [("holes", "no sky within the planet"), ("strays", "nothing but sky beside it")] {
            if number(key) > 0.0 {
                found.push(format!("{name}: {} pixels, expected {wanted}", number(key)));
            }
        }
        let view = views.as_array().unwrap().iter().find(|view| view["name"] == report["view"]).unwrap();
        if report["view"] == "orbit" {
            let scale = number("height") / 2.0 / 25.0_f64.to_radians().tan();
            let pixels = |radius: f64| scale * (radius / (3.2 * self.planet.recipe.radius)).asin().tan();
            let (low, high) = (pixels(self.planet.recipe.radius), pixels(self.planet.recipe.radius + 2500.0));
            if !(low - 1.0..high).contains(&number("radius")) {
                found.push(format!("{name}: a disc of {} pixels, expected {low} to {high}", number("radius")));
            }
            let off = [("width", 0), ("height", 1)].map(|(side, k)| report["centre"][k].as_f64().unwrap() - number(side) / 2.0);
            if off[0].hypot(off[1]) > 3.0 {
                found.push(format!("{name}: its middle is {off:?} pixels off"));
            }
        }
        let rays = view["picks"].as_array().unwrap().iter().zip(report["picks"].as_array().unwrap());
        for (ray, pick) in rays {
            let [x, y, z] = [0, 1, 2].map(|k| ray[k].as_f64().unwrap());
            let wanted = self.surface(DVec3::new(x, y, z));
            let (Some(radius), Some(error)) = (pick["radius"].as_f64(), pick["error"].as_f64()) else {
                found.push(format!("{name}: no ground under {x} {y} {z}"));
                continue;
            };
            if (radius - wanted).abs() > error + SLACK_M {
                found.push(format!("{name}: {} m off under {x} {y} {z}, {error} m stated in {}", radius - wanted, pick["patch"]));
            }
        }
        found
    }
}

/// Moves a tile outwards by metres.
fn shift(glb: &Path, metres: f64) {
    let bytes = std::fs::read(glb).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut document: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    for node in document["nodes"].as_array_mut().unwrap() {
        let place: Vec<f64> = node["translation"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
        let place = DVec3::from_slice(&place);
        node["translation"] = json!((place + place.normalize() * metres).to_array());
    }
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = (bytes.len() - length + text.len()) as u32;
    let head = [&bytes[..8], &total.to_le_bytes(), &(text.len() as u32).to_le_bytes(), &bytes[16..20]].concat();
    std::fs::write(glb, [&head, &text, &bytes[20 + length..]].concat()).unwrap();
}

/// The file of a patch's tile.
fn file_of(folder: &Path, patch: &str) -> PathBuf {
    fn find(from: &Path, tile: &Value, patch: &str) -> Option<PathBuf> {
        let file = from.join(tile["content"]["uri"].as_str().unwrap_or_default());
        if tile["content"]["uri"].as_str().is_some_and(|uri| uri.ends_with(".json")) {
            let inner: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
            return find(file.parent().unwrap(), &inner["root"], patch);
        }
        if tile["extras"]["patch"] == patch {
            return Some(file);
        }
        tile["children"].as_array()?.iter().find_map(|child| find(from, child, patch))
    }
    let root: Value = serde_json::from_slice(&std::fs::read(folder.join("tileset.json")).unwrap()).unwrap();
    find(folder, &root["root"], patch).unwrap()
}

#[test]
fn cesium_and_three_draw_the_planet_in_place_whole_and_as_high_as_it_is() {
    let Some(packages) = packages() else { return };
    let folder = tempfile::tempdir().unwrap();
    let make = |out: &str, more: &[&str]| summary(&[&["tiles", "tiny", "--out", out], &REGION[..], more].concat(), folder.path());
    make("whole", &[]);
    make("bare", &["--no-skirts"]);
    let out = packages.parent().unwrap().join("tiles-pictures");
    std::fs::create_dir_all(&out).unwrap();
    let (world, at) = (World::new(), |name: &str| folder.path().join(name));
    // The rays' truth is what the command itself says.
    for ray in world.samples(direction_at(SITE[0], SITE[1]), 0.9).into_iter().step_by(17) {
        let (latitude, longitude) = latitude_longitude(ray);
        let said = summary(&["height", "tiny", "--at", &format!("{latitude},{longitude}")], folder.path());
        assert!((said["height_m"].as_f64().unwrap() - world.planet.terrain.height(ray)).abs() < 1e-3, "{said}");
    }
    let views = world.views();
    let jobs: Vec<Value> = ["cesium", "three"].map(|client| world.job("whole", client, &at("whole"), &out, &views)).to_vec();
    let reports = drawn(&packages, folder.path(), &json!(jobs));
    assert_eq!(reports.len(), 6);
    for report in &reports {
        assert_eq!(world.faults(report, &views), Vec::<String>::new(), "{report}");
        let levels = report["tiles"].as_object().unwrap().len();
        assert!(levels > 1 || report["view"] == "orbit", "tiles of one level have no gaps: {}", report["tiles"]);
        let colours: Vec<f64> = report["colours"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
        assert!(colours.iter().all(|c| (15.0..200.0).contains(c)), "black or white ground: {colours:?}");
    }
    // Controls: without skirts there are holes, and a tile out of place is seen.
    let near = reports.iter().find(|report| report["view"] == "near").unwrap();
    let patch = near["picks"][RAYS / 2]["patch"].as_str().unwrap();
    let error = near["picks"][RAYS / 2]["error"].as_f64().unwrap();
    shift(&file_of(&at("whole"), patch), 3.0 * error + 1.0);
    let jobs =
        [world.job("bare", "cesium", &at("bare"), &out, &views), world.job("shifted", "three", &at("whole"), &out, &views)];
    let controls = drawn(&packages, folder.path(), &json!(jobs));
    let found = |job: &str, what: &str| {
        let reports = controls.iter().filter(|report| report["job"] == job);
        reports.flat_map(|report| world.faults(report, &views)).filter(|fault| fault.contains(what)).count()
    };
    assert!(found("bare", "expected no sky within the planet") > 0, "gaps without skirts are not seen");
    assert!(found("shifted", "m off under") > 0, "a tile out of place is not seen");
}
