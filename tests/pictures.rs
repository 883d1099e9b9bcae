//! Small pictures against references: `tests/pictures/README.md` says what is compared, and how to make new references.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use common::{device, terrane, text};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::recipe::Recipe;
use terrane_planet::store::Region;
use terrane_planet::store::{BakedPatch, PlanetFile};

/// Width and height of the pictures.
const SIZE: [u32; 2] = [320, 180];
/// Grid cells of the planets.
const CELLS: u32 = 32;
/// Latitude and longitude that the descent ends at, where terra is baked to its finest level.
const SITE: [f64; 2] = [-38.95, 34.34];
/// Finest level of terra.
const FINEST: u8 = 15;
/// Latitude and longitude of the mountains, and how far about and how finely they are baked.
const MOUNTAINS: [f64; 2] = [44.78, 54.17];
const MOUNTAINS_M: f64 = 18e3;
const MOUNTAINS_FINEST: u8 = 11;
/// Level of the patch whose descendants are removed to make a comparison fail: so coarse that two pictures show it.
const LOST: u8 = 8;
/// Largest difference of a channel between pixels that count as equal.
const LIMIT: u8 = 3;
/// Share of pixels that may differ by more.
const OUTLIERS: f64 = 0.005;
/// Least share of a picture that shows the planet.
const LEAST_COVERAGE: f64 = 0.08;
/// Fewest colours, of 32 shades a channel, that the ground of a picture has.
const FEWEST_COLOURS: usize = 40;

/// One picture: its name, planet, and the arguments of its view.
struct Shot {
    name: &'static str,
    planet: &'static str,
    view: &'static [&'static str],
}

const SHOTS: [Shot; 9] = [
    Shot { name: "orbit", planet: "terra", view: &["--at", "20,90,12000000"] },
    Shot { name: "limb", planet: "terra", view: &["--at", "-38.95,34.34,300000", "--look", "60,-18"] },
    Shot { name: "terminator", planet: "terra", view: &["--at", "10,100,9000000", "--sun", "90,2"] },
    Shot { name: "glitter", planet: "terra", view: &["--at", "-38.95,34.34,600", "--look", "350,-8", "--sun", "350,18"] },
    Shot { name: "coast", planet: "terra", view: &["--at", "-38.95,34.34,1500", "--look", "310,-9"] },
    Shot {
        name: "mountains",
        planet: "terra",
        view: &["--at", "44.73,53.97,1500", "--look", "76,-2", "--sun", "160,20", "--clear-sky"],
    },
    Shot { name: "ground", planet: "terra", view: &["--at", "-38.95,34.34,60", "--look", "300,-5"] },
    Shot { name: "luna", planet: "luna", view: &["--at", "20,10,3000000"] },
    Shot { name: "mars", planet: "mars", view: &["--at", "-5,-75,6500000"] },
];

/// An RGB picture.
#[derive(Clone, PartialEq)]
struct Picture {
    size: [u32; 2],
    rgb: Vec<u8>,
}

impl Picture {
    fn read(path: &Path) -> Result<Picture, String> {
        let file = std::fs::File::open(path).map_err(|e| format!("missing reference {}: {e}", path.display()))?;
        let damaged = |e: &dyn std::fmt::Display| format!("damaged picture {}: {e}", path.display());
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().map_err(|e| damaged(&e))?;
        let mut rgb = vec![0; reader.output_buffer_size().ok_or_else(|| damaged(&"too large"))?];
        let info = reader.next_frame(&mut rgb).map_err(|e| damaged(&e))?;
        reader.finish().map_err(|e| damaged(&e))?;
        if (info.color_type, info.bit_depth) != (png::ColorType::Rgb, png::BitDepth::Eight) {
            return Err(damaged(&format!("{:?} of {:?} bits, expected RGB of 8", info.color_type, info.bit_depth)));
        }
        rgb.truncate(info.buffer_size());
        Ok(Picture { size: [info.width, info.height], rgb })
    }

    fn write(&self, path: &Path) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        encoder.write_header().unwrap().write_image_data(&self.rgb).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    fn pixels(&self) -> impl Iterator<Item = [u8; 3]> + '_ {
        self.rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2]])
    }

    /// The same picture moved to the right; its left edge is repeated.
    fn moved(&self, by: usize) -> Picture {
        let width = self.size[0] as usize;
        let pixels: Vec<[u8; 3]> = self.pixels().collect();
        let row = |row: &[[u8; 3]]| (0..width).flat_map(|x| row[x.saturating_sub(by)]).collect::<Vec<u8>>();
        Picture { size: self.size, rgb: pixels.chunks(width).flat_map(row).collect() }
    }
}

/// Mean perceived difference of two pictures from half a metre away (FLIP: Andersson and others 2020), 0 to 1.
fn flip(a: &Picture, b: &Picture) -> f32 {
    let [a, b] = [a, b].map(|p| nv_flip::FlipImageRgb8::with_data(p.size[0], p.size[1], &p.rgb));
    nv_flip::FlipPool::from_image(&nv_flip::flip(a, b, nv_flip::DEFAULT_PIXELS_PER_DEGREE)).mean()
}

/// How two pictures of one size differ.
#[derive(Debug)]
struct Difference {
    /// Share of pixels with a channel that differs by more than [`LIMIT`].
    outliers: f64,
    /// Mean difference of a channel.
    mean: f64,
    /// Largest difference of a channel.
    worst: u8,
}

impl Difference {
    fn between(a: &Picture, b: &Picture) -> Difference {
        let apart = |(a, b): ([u8; 3], [u8; 3])| [0, 1, 2].map(|k| a[k].abs_diff(b[k]));
        let differences: Vec<[u8; 3]> = a.pixels().zip(b.pixels()).map(apart).collect();
        let count = differences.len() as f64;
        Difference {
            outliers: differences.iter().filter(|d| d.iter().any(|&c| c > LIMIT)).count() as f64 / count,
            mean: differences.iter().flatten().map(|&c| f64::from(c)).sum::<f64>() / (3.0 * count),
            worst: differences.iter().flatten().copied().max().unwrap_or(0),
        }
    }

    fn is_small(&self) -> bool {
        self.outliers <= OUTLIERS
    }
}

fn references() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/pictures")
}

fn failures() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("pictures")
}

/// Compares a picture with its reference in a folder; writes picture and difference into another if they differ.
fn compare(name: &str, picture: &Picture, references: &Path, failures: &Path) -> Result<Difference, String> {
    let path = references.join(format!("{name}.png"));
    let reference = Picture::read(&path);
    if reference.as_ref().is_ok_and(|r| r.size != picture.size) || reference.is_err() {
        picture.write(&failures.join(format!("{name}.actual.png")));
    }
    let reference = reference?;
    if reference.size != picture.size {
        return Err(format!("{}: size {:?}, expected {:?}", path.display(), reference.size, picture.size));
    }
    let difference = Difference::between(&reference, picture);
    if difference.is_small() {
        return Ok(difference);
    }
    picture.write(&failures.join(format!("{name}.actual.png")));
    let strong = reference.rgb.iter().zip(&picture.rgb).map(|(a, b)| a.abs_diff(*b).saturating_mul(16)).collect();
    Picture { size: picture.size, rgb: strong }.write(&failures.join(format!("{name}.difference.png")));
    Err(format!(
        "{name}: {:.2} % of the pixels differ by more than {LIMIT} (allowed {:.2} %), mean difference {:.2}, worst {}, FLIP {:.4}; see {}",
        100.0 * difference.outliers,
        100.0 * OUTLIERS,
        difference.mean,
        difference.worst,
        flip(&reference, picture),
        failures.display()
    ))
}

/// Checks that a picture shows a planet, with a depth picture of the same view, whose pixels are black where there is no ground.
fn check_content(name: &str, picture: &Picture, depth: &Picture) -> Result<(), String> {
    let ground: Vec<[u8; 3]> = picture.pixels().zip(depth.pixels()).filter(|(_, d)| *d != [0; 3]).map(|(p, _)| p).collect();
    let coverage = ground.len() as f64 / f64::from(picture.size[0] * picture.size[1]);
    let colours: std::collections::HashSet<[u8; 3]> = ground.iter().map(|p| p.map(|c| c / 8)).collect();
    if coverage < LEAST_COVERAGE || colours.len() < FEWEST_COLOURS {
        let share = 100.0 * coverage;
        return Err(format!(
            "{name}: {share:.1} % of the picture is ground, of {} colours: this is no picture of it",
            colours.len()
        ));
    }
    Ok(())
}

/// A folder with the planets, baked once.
fn planets() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let near = Region { direction: direction_at(SITE[0], SITE[1]), radius_m: 0.0, to_level: FINEST };
        let [latitude, longitude] = MOUNTAINS;
        let mountains =
            Region { direction: direction_at(latitude, longitude), radius_m: MOUNTAINS_M, to_level: MOUNTAINS_FINEST };
        let bakes = [("terra", 1, Some(near)), ("terra", 1, Some(mountains)), ("luna", 2, None), ("mars", 2, None)];
        for (name, levels, region) in bakes {
            let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../planet/recipes/{name}.toml"));
            let planet = Planet::from_recipe(Recipe::load(&recipe).unwrap(), CELLS).unwrap();
            let plan = BakePlan::new(planet.recipe.radius, levels, region).unwrap();
            let mut file = PlanetFile::create_or_resume(&folder.path().join(format!("{name}.planet")), &planet.header()).unwrap();
            let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
            bake(&mut file, &planet.terrain, &planet.terrain, &plan, threads, &|_| (), &false.into()).unwrap();
        }
        folder
    });
    folder.path()
}

/// Renders a view of a planet file.
fn render(planet: &Path, view: &[&str], more: &[&str]) -> Picture {
    let folder = tempfile::tempdir().unwrap();
    let (planet, size) = (planet.to_string_lossy(), format!("{}x{}", SIZE[0], SIZE[1]));
    let arguments = [&["shot", &planet, "--stored-only", "--out", "picture.png", "--size", &size], view, more].concat();
    let output = terrane(&arguments, folder.path());
    assert!(output.status.success(), "{view:?}: {}", text(&output.stderr));
    Picture::read(&folder.path().join("picture.png")).unwrap()
}

fn render_shot(shot: &Shot, more: &[&str]) -> Picture {
    render(&planets().join(format!("{}.planet", shot.planet)), shot.view, more)
}

fn shot(name: &str) -> &'static Shot {
    SHOTS.iter().find(|s| s.name == name).unwrap()
}

/// The device, processor and settings that references are rendered with.
fn record(device: &str) -> serde_json::Value {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find(|l| l.starts_with("model name")).and_then(|l| l.split_once(": "));
    json!({ "device": device, "cpu": model.map_or("unknown", |(_, name)| name), "size": SIZE, "cells": CELLS, "finest_level": FINEST })
}

/// The record of the references.
fn recorded() -> String {
    std::fs::read_to_string(references().join("recorded.json")).unwrap_or_else(|_| "nothing recorded".to_owned())
}

#[test]
fn pictures_match_their_references() {
    let Some(device) = device() else { return };
    let update = std::env::var("TERRANE_UPDATE_PICTURES").is_ok_and(|value| value == "1");
    let mut faults = Vec::new();
    for shot in &SHOTS {
        let picture = render_shot(shot, &[]);
        faults.extend(check_content(shot.name, &picture, &render_shot(shot, &["--mode", "depth"])).err());
        if update {
            picture.write(&references().join(format!("{}.png", shot.name)));
        }
        match compare(shot.name, &picture, &references(), &failures()) {
            Ok(difference) => println!("{}: {difference:?}", shot.name),
            Err(fault) => faults.push(fault),
        }
    }
    if update {
        let text = serde_json::to_string_pretty(&record(&device)).unwrap() + "\n";
        std::fs::write(references().join("recorded.json"), text).unwrap();
    }
    assert!(faults.is_empty(), "on {device}:\n{}\nreferences made with {}", faults.join("\n"), recorded());
}

/// Largest mean FLIP between pictures of meshes with errors of up to 1 and up to 0.25 pixels.
const SHADING_FLIP: f32 = 0.03;

#[test]
fn shading_hardly_depends_on_the_mesh() {
    if device().is_none() {
        return;
    }
    for shot in &SHOTS {
        let picture = render_shot(shot, &[]);
        let found = flip(&picture, &render_shot(shot, &["--error", "0.25"]));
        assert!(found < SHADING_FLIP, "{}: {found}", shot.name);
        println!("{}: FLIP {found:.4}", shot.name);
    }
    // The negative control: a sun that is five degrees higher changes the light by more.
    let shot = shot("coast");
    let other = flip(&render_shot(shot, &["--sun", "135,35"]), &render_shot(shot, &["--sun", "135,40"]));
    assert!(other > SHADING_FLIP, "a change of the light that is seen is not told from none: {other}");
}

#[test]
fn a_picture_moved_by_two_pixels_fails() {
    if device().is_none() {
        return;
    }
    for shot in &SHOTS {
        let picture = render_shot(shot, &[]);
        let difference = Difference::between(&picture, &picture.moved(2));
        assert!(!difference.is_small(), "{}: {difference:?}", shot.name);
        assert!(Difference::between(&picture, &picture.moved(0)).worst == 0);
    }
}

#[test]
fn a_missing_patch_fails() {
    if device().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let whole = PlanetFile::open(&planets().join("terra.planet")).unwrap();
    let path = folder.path().join("holed.planet");
    let mut holed = PlanetFile::create_or_resume(&path, whole.header()).unwrap();
    let lost = PatchId::containing(direction_at(SITE[0], SITE[1]), LOST);
    let is_below = |mut id: PatchId| {
        while id.level > lost.level {
            id.level -= 1;
            (id.x, id.y) = (id.x / 2, id.y / 2);
            if id == lost {
                return true;
            }
        }
        false
    };
    let kept = whole.index().unwrap().into_iter().filter(|r| !is_below(r.id));
    let patches: Vec<BakedPatch> = kept
        .map(|record| BakedPatch {
            record,
            geometry: whole.geometry_record(record.id).unwrap(),
            texture: whole.texture_record(record.id).unwrap(),
        })
        .collect();
    assert!(patches.len() < whole.index().unwrap().len());
    holed.put(&patches).unwrap();
    for name in ["ground", "coast"] {
        let shot = shot(name);
        let difference = Difference::between(&render_shot(shot, &[]), &render(&path, shot.view, &[]));
        assert!(!difference.is_small(), "{name}: {difference:?}");
    }
}

#[test]
fn a_picture_of_nothing_is_noticed() {
    if device().is_none() {
        return;
    }
    let sky = ["--at", "-38.95,34.34,60", "--look", "30,45"];
    let planet = planets().join("terra.planet");
    let found = check_content("sky", &render(&planet, &sky, &[]), &render(&planet, &sky, &["--mode", "depth"]));
    assert!(found.as_ref().is_err_and(|fault| fault.contains("0.0 % of the picture")), "{found:?}");
    // One colour is no picture either, wherever the ground is.
    let depth = render_shot(shot("ground"), &["--mode", "depth"]);
    let flat = Picture { size: SIZE, rgb: vec![128; depth.rgb.len()] };
    assert!(check_content("flat", &flat, &depth).is_err());
}

#[test]
fn missing_damaged_and_wrong_sized_references_fail() {
    let folder = tempfile::tempdir().unwrap();
    let rgb = (0..SIZE[0] * SIZE[1] * 3).map(|k| (k % 251) as u8).collect();
    let picture = Picture { size: SIZE, rgb };
    let failures = folder.path().join("failures");
    let fault = |name: &str| compare(name, &picture, folder.path(), &failures).unwrap_err();
    assert!(fault("none").contains("missing reference"));
    assert!(Picture::read(&failures.join("none.actual.png")).unwrap() == picture);
    Picture { size: [SIZE[0], SIZE[1] / 2], rgb: picture.rgb[..picture.rgb.len() / 2].to_vec() }
        .write(&folder.path().join("small.png"));
    assert!(fault("small").contains("size [320, 90], expected [320, 180]"));
    let whole = folder.path().join("whole.png");
    picture.write(&whole);
    assert!(compare("whole", &picture, folder.path(), &failures).is_ok());
    let bytes = std::fs::read(&whole).unwrap();
    std::fs::write(folder.path().join("short.png"), &bytes[..bytes.len() / 2]).unwrap();
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 1;
    std::fs::write(folder.path().join("flipped.png"), flipped).unwrap();
    std::fs::write(folder.path().join("other.png"), "no picture").unwrap();
    for name in ["short", "flipped", "other"] {
        assert!(fault(name).contains("damaged picture"), "{}", fault(name));
    }
    let moved = compare("whole", &picture.moved(2), folder.path(), &failures).unwrap_err();
    assert!(moved.contains("of the pixels differ") && failures.join("whole.difference.png").exists(), "{moved}");
}

#[test]
fn limits_are_where_they_say() {
    let picture = Picture { size: [100, 10], rgb: vec![100; 3000] };
    let with = |pixels: usize, by: u8| {
        let mut other = picture.clone();
        (0..pixels).for_each(|k| other.rgb[3 * k + 1] += by);
        Difference::between(&picture, &other)
    };
    assert!(with(1000, LIMIT).is_small() && with(5, LIMIT + 1).is_small());
    assert!(!with(6, LIMIT + 1).is_small());
    assert!((with(1000, 3).mean - 1.0).abs() < 1e-12 && with(1, 9).worst == 9);
}
