//! Khronos's glTF validator over every kind of GLB that the command writes. It comes from npm, into target/gltf-validator; where there
//! is no Node, or no way to fetch it, the test says "skipped".

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::common::{terrane, text};
use crate::mesh_and_bench::planet_in;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The folder of the validator, fetched once if it is not there.
pub(crate) fn validator() -> Option<PathBuf> {
    static FOLDER: OnceLock<Option<PathBuf>> = OnceLock::new();
    FOLDER.get_or_init(fetched).clone()
}

fn fetched() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/gltf-validator");
    if !folder.join("node_modules/gltf-validator").is_dir() {
        std::fs::create_dir_all(&folder).ok()?;
        let fetch = ["install", "--no-audit", "--no-fund", "--silent", "--prefix", "."];
        let fetched = Command::new("npm").args(fetch).arg("gltf-validator@2.0.0-dev.3.10").current_dir(&folder).status();
        if !fetched.is_ok_and(|status| status.success()) {
            println!("skipped: npm cannot fetch gltf-validator, so that no GLB is validated");
            return None;
        }
    }
    if Command::new("node").arg("--version").output().is_err() {
        println!("skipped: node is not installed, so that no GLB is validated");
        return None;
    }
    Some(folder.canonicalize().unwrap())
}

/// The codes of what the validator finds in a file, and what it counts.
pub(crate) fn validate(validator: &Path, file: &Path) -> (Vec<String>, Value) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/command/validate_glb.mjs");
    let output = Command::new("node").arg(script).arg(validator).arg(file).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let messages = report["messages"].as_array().unwrap().iter();
    (messages.map(|m| format!("{} {} {}", m["code"], m["pointer"], m["message"])).collect(), report["info"].clone())
}

/// What the validator says of a file whose numbers are packed, and nothing else: it does not know the extension, and does not see that its
/// views use the file's buffer, unless a picture does, too.
pub(crate) fn unseen(kind: &[&str]) -> Vec<String> {
    let place = kind.iter().filter(|option| **option == "--quantize").count();
    let unknown = "Cannot validate an extension as it is not supported by the validator: 'EXT_meshopt_compression'.";
    let mut said = vec![format!("\"UNSUPPORTED_EXTENSION\" \"/extensionsUsed/{place}\" \"{unknown}\"")];
    if !kind.contains(&"--maps") {
        said.push("\"UNUSED_OBJECT\" \"/buffers/0\" \"This object may be unused.\"".into());
    }
    said
}

#[test]
fn the_validator_of_khronos_finds_nothing_in_any_glb() {
    let Some(validator) = validator() else { return };
    let folder = tempfile::tempdir().unwrap();
    planet_in(folder.path());
    let dem = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/jacksboro_fault_dem.tif");
    let simplify = ["simplify", dem.to_str().unwrap(), "--faces", "3000"];
    let mesh = ["mesh", "tiny.planet", "--at", "10,20,500", "--look", "30,-20"];
    let kinds: [&[&str]; 8] = [
        &[],
        &["--quantize"],
        &["--solid", "50"],
        &["--solid", "50", "--quantize"],
        &["--maps", "256"],
        &["--maps", "256", "--quantize"],
        &["--compress"],
        &["--maps", "256", "--quantize", "--compress"],
    ];
    for kind in kinds {
        for command in [&simplify[..], &mesh] {
            let output = terrane(&[command, kind, &["--out", "x.glb", "--json"]].concat(), folder.path());
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            let (found, info) = validate(&validator, &folder.path().join("x.glb"));
            let wanted = if kind.contains(&"--compress") { unseen(kind) } else { Vec::new() };
            assert_eq!(found, wanted, "{command:?} {kind:?}");
            assert_eq!(info["hasTextures"], kind.contains(&"--maps"), "{info}");
            let count = |name: &str| info[name].as_u64().unwrap();
            assert!(count("totalTriangleCount") > 100 && count("totalVertexCount") > 60, "{info}");
            let extensions = info["extensionsUsed"].as_array().map_or(0, Vec::len);
            let asked = ["--quantize", "--compress"].iter().filter(|option| kind.contains(option)).count();
            assert_eq!(extensions, asked, "{info}");
        }
    }
    // A picture, as it is: 64 x 64 greys.
    let mut picture = png::Encoder::new(std::fs::File::create(folder.path().join("p.png")).unwrap(), 64, 64);
    picture.set_color(png::ColorType::Rgb);
    picture.write_header().unwrap().write_image_data(&[90; 3 * 64 * 64]).unwrap();
    for kind in [&[][..], &["--quantize"], &["--maps", "128"]] {
        let output = terrane(&[&simplify[..], kind, &["--texture", "p.png", "--out", "t.glb"]].concat(), folder.path());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let (found, info) = validate(&validator, &folder.path().join("t.glb"));
        assert!(found.is_empty() && info["hasTextures"] == true && info["maxUVs"] == 1, "{found:?} {info}");
        let (glb, png) = ["t.glb", "p.png"].map(|name| std::fs::read(folder.path().join(name)).unwrap()).into();
        assert!(glb.windows(png.len()).any(|bytes| bytes == png), "the picture is not there as it is");
    }
    // A coordinate that is no number makes it complain.
    let output = terrane(&[&mesh[..], &["--out", "x.glb"]].concat(), folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut bytes = std::fs::read(folder.path().join("x.glb")).unwrap();
    let binary = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize + 8;
    bytes[binary..binary + 4].fill(0xff);
    std::fs::write(folder.path().join("bad.glb"), bytes).unwrap();
    assert_ne!(validate(&validator, &folder.path().join("bad.glb")).0, Vec::<String>::new());
}

#[test]
fn maps_that_no_file_holds_are_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    // No input is there: a message about one would mean that it was read first.
    for (texels, out, message) in [
        ("1000", "x.glb", "maps of 1000 texels a side, expected a power of two from 64 to 8192"),
        ("16384", "x.glb", "expected a power of two"),
        ("256", "x.obj", "--maps: OBJ files hold no maps"),
    ] {
        for command in [&["mesh", "gone.planet"][..], &["simplify", "gone.tif", "--faces", "9"]] {
            let output = terrane(&[command, &["--maps", texels, "--out", out]].concat(), folder.path());
            let said = text(&output.stderr);
            assert!(output.status.code() == Some(1) && said.contains(message), "{command:?} {texels} {out}: {said}");
        }
    }
}
