//! Where a mesh lies: in `--json`, in GLB files, and in the files beside a mesh, for heightfields and for planets.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};
use crate::mesh_and_bench::planet_in;
use serde_json::{json, Value};
use std::path::Path;

fn run(arguments: &[&str], folder: &Path) -> Value {
    let output = terrane(arguments, folder);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The JSON chunk of a GLB file.
pub(crate) fn glb_json(path: &Path) -> Value {
    let bytes = std::fs::read(path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

fn three(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|k| value[k].as_f64().unwrap_or_else(|| panic!("{value} is no vector")))
}

/// Largest coordinates of the vertices of a Y-up OBJ file: east, north, up.
fn far_corner(path: &Path) -> [f64; 3] {
    let text = std::fs::read_to_string(path).unwrap();
    let vertices = text.lines().filter_map(|line| line.strip_prefix("v "));
    vertices.fold([f64::MIN; 3], |most, line| {
        let v: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        [most[0].max(v[0]), most[1].max(-v[2]), most[2].max(v[1])]
    })
}

/// Lines `key: value` of a text beside a mesh.
fn said(path: &Path, key: &str) -> String {
    let text = std::fs::read_to_string(path).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(": "));
    line.unwrap_or_else(|| panic!("{text} does not say {key}")).to_owned()
}

/// An Esri grid of 6 × 5 samples, 25 units apart, whose south-western one is at 600,100 and 5,200,200.
fn grid() -> String {
    let rows = (0..5).map(|row| (0..6).map(|column| format!("{} ", 3 * row * column)).collect::<String>() + "\n");
    format!("ncols 6\nnrows 5\nxllcenter 600100\nyllcenter 5200200\ncellsize 25\n{}", rows.collect::<String>())
}

#[test]
fn corners_of_a_mesh_are_those_of_the_map() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("a.asc"), grid()).unwrap();
    let simplify = ["simplify", "a.asc", "--crs", "EPSG:32632", "--faces", "30", "--json", "--sidecar", "--out"];
    let found = run(&[&simplify[..], &["m.obj"]].concat(), folder.path())["georeference"].clone();
    assert_eq!((&found["crs"], &found["unit"]), (&json!("EPSG:32632"), &json!("metre")));
    assert_eq!(found["origin"], json!([600_100.0, 5_200_200.0, 0.0]));
    // What the mesh adds to its origin leads to the north-eastern sample.
    let (origin, units, corner) = (three(&found["origin"]), three(&found["units_a_metre"]), far_corner(&at("m.obj")));
    let north_east = [0, 1].map(|k| origin[k] + units[k] * corner[k]);
    assert_eq!(north_east, [600_100.0 + 125.0, 5_200_200.0 + 100.0]);
    assert!(std::fs::read_to_string(at("m.obj")).unwrap().contains("at 600100 5200200 0 in EPSG:32632, unit metre"));
    // Beside it: WKT that reads back as the same system, and lines for people and scripts.
    let wkt = std::fs::read_to_string(at("m.prj")).unwrap();
    assert!(wkt.starts_with("PROJCS[\"WGS 84 / UTM zone 32N\"") && found["wkt"] == wkt.trim_end(), "{wkt}");
    let lines = ["axes", "crs", "unit", "origin", "units a metre"].map(|key| said(&at("m.txt"), key));
    assert_eq!(lines, ["metres, +X east, +Y up, -Z north", "EPSG:32632", "metre", "600100 5200200 0", "1 1 1"]);
    assert_eq!(said(&at("m.txt"), "coordinates of a vertex"), "origin + units a metre * (x, -z, y)");
    std::fs::write(at("b.asc"), grid()).unwrap();
    std::fs::copy(at("m.prj"), at("b.prj")).unwrap();
    let back = run(&["simplify", "b.asc", "--faces", "30", "--json", "--out", "b.obj"], folder.path());
    assert_eq!(back["georeference"]["units_a_metre"], found["units_a_metre"]);
    assert_eq!((back["spacing_m"][0].as_f64(), &back["georeference"]["wkt"]), (Some(25.0), &found["wkt"]));
    // The same in a GLB, and in the Z-up text of a PLY.
    run(&[&simplify[..], &["m.glb"]].concat(), folder.path());
    assert_eq!(glb_json(&at("m.glb"))["asset"]["extras"]["georeference"], found);
    run(&[&simplify[..], &["z.ply"]].concat(), folder.path());
    assert_eq!(said(&at("z.txt"), "coordinates of a vertex"), "origin + units a metre * (x, y, z)");
    // Another system is another place.
    let other = run(&["simplify", "a.asc", "--crs", "EPSG:2264", "--faces", "30", "--json", "--out", "o.obj"], folder.path());
    assert!(three(&other["georeference"]["units_a_metre"])[0] > 3.2 && other["georeference"]["wkt"] != found["wkt"]);
    assert!(!at("o.prj").exists() && !at("o.txt").exists(), "files beside a mesh are there when they are asked for");
}

#[test]
fn degrees_lead_to_the_corners_too() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/jacksboro_fault_dem.tif");
    let arguments = ["simplify", dem.to_str().unwrap(), "--faces", "900,90", "--json", "--sidecar", "--out", "j.obj"];
    let found = run(&arguments, folder.path());
    let place = &found["georeference"];
    let (origin, units) = (three(&place["origin"]), three(&place["units_a_metre"]));
    let corner = far_corner(&folder.path().join("j-900.obj"));
    for (k, [low, high]) in [["west", "east"], ["south", "north"]].into_iter().enumerate() {
        let wanted = [low, high].map(|side| found["bounds_deg"][side].as_f64().unwrap());
        let sides = [origin[k], origin[k] + units[k] * corner[k]];
        assert!((0..2).all(|end| (sides[end] - wanted[end]).abs() < 1e-9), "{sides:?}, expected {wanted:?}");
        assert!(wanted[1] - wanted[0] > 0.2, "a map of a point tells nothing");
    }
    for name in ["j-900", "j-90"] {
        let wkt = std::fs::read_to_string(folder.path().join(name).with_extension("prj")).unwrap();
        assert!(wkt.starts_with("GEOGCS[") && wkt.contains("SPHEROID["), "{wkt}");
        assert_eq!(said(&folder.path().join(name).with_extension("txt"), "unit"), "degree");
    }
}

#[test]
fn meshes_of_a_planet_lie_on_its_sphere() {
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let at = |name: &str| folder.path().join(name);
    let view = ["mesh", "tiny.planet", "--at", "10,20,500", "--look", "30,-20", "--json", "--sidecar", "--out"];
    let found = run(&[&view[..], &["v.glb"]].concat(), folder.path());
    let (place, document) = (&found["georeference"], glb_json(&at("v.glb")));
    assert_eq!((&document["asset"]["extras"]["georeference"], &place["unit"]), (place, &json!("metre")));
    let unit = found["unit_m"].as_f64().unwrap();
    let origin = three(&found["origin_lattice"]).map(|c| c * unit);
    assert_eq!(three(&place["origin"]), origin);
    // The origin is 500 m above ground that lies around a sphere of 60 km.
    let radius: f64 = place["crs"].as_str().unwrap().split("+R=").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let height = origin.map(|c| c * c).iter().sum::<f64>().sqrt() - radius;
    assert!(height.abs() < 0.1 * radius && radius > 1e4, "{height} m above {radius} m");
    let wkt = std::fs::read_to_string(at("v.prj")).unwrap();
    assert!(wkt.starts_with("GEOCCS[") && wkt.contains(&format!("SPHEROID[\"sphere\",{radius},0]")), "{wkt}");
    assert!(said(&at("v.txt"), "coordinates of a vertex").contains("the translation of the node is this origin"));
    // From the centre there is nothing to add.
    let whole = run(&[&view[..], &["w.ply"]].concat(), folder.path());
    assert_eq!(three(&whole["georeference"]["origin"]), [0.0; 3]);
    assert!(!said(&at("w.txt"), "coordinates of a vertex").contains("translation"));
}

#[test]
fn meshes_without_a_place_say_so_and_files_of_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("a.raw"), (0..32).flat_map(|k: u16| (k * k).to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    let raw = ["simplify", "a.raw", "--raw-size", "8x4", "--range", "0,90", "--faces", "9", "--json", "--sidecar", "--out"];
    let found = run(&[&raw[..], &["m.obj"]].concat(), folder.path());
    assert_eq!((&found["georeference"], said(&at("m.txt"), "crs").as_str()), (&Value::Null, "none is known"));
    assert!(!at("m.prj").exists());
    std::fs::write(at("a.asc"), grid()).unwrap();
    std::fs::write(at("a.prj"), "theirs").unwrap();
    for (input, crs) in [("a.asc", "EPSG:32632"), ("./a.asc", "EPSG:32632")] {
        let arguments = ["simplify", input, "--crs", crs, "--faces", "30", "--sidecar", "--out", "a.obj"];
        let output = terrane(&arguments, folder.path());
        assert!(output.status.code() == Some(1) && text(&output.stderr).contains("give the mesh another name"), "{input}");
    }
    assert_eq!(std::fs::read_to_string(at("a.prj")).unwrap(), "theirs");
    let output = terrane(&["simplify", "a.asc", "--faces", "30", "--sidecar", "--out", "-", "--format", "obj"], folder.path());
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("--out -: found --sidecar"));
}
