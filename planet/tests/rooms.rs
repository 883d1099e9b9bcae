//! Rooms use one another one way: each only those that stand before it in the lists below. A room is a top-level module of a crate
//! (or of `src/vulkan`); a path that goes up, and with it any ring of rooms, fails here. Unit tests may look anywhere.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A crate, or a folder of one, with its rooms from the ground up.
struct House {
    /// Folder of the sources, from the repository's root.
    folder: &'static str,
    /// Path in front of every room: what `crate` or `crate::vulkan` is.
    prefix: &'static [&'static str],
    /// Each room may use those before it.
    rooms: &'static [&'static str],
}

const HOUSES: [House; 4] = [
    House {
        folder: "planet/heightfield/src",
        prefix: &[],
        rooms: &[
            "angles",
            "field",
            "raster",
            "fill",
            "deviation",
            "import",
            "decimate",
            "holes",
            "polish",
            "plain",
            "polished",
            "classic",
        ],
    },
    House {
        folder: "planet/src",
        prefix: &[],
        rooms: &[
            "globe",
            "recipe",
            "ground",
            "terrain",
            "mesh",
            "store",
            "published",
            "maps",
            "draw",
            "planet",
            "reference",
            "query",
            "verify",
            "export",
            "tiles",
        ],
    },
    House {
        folder: "src",
        prefix: &[],
        rooms: &["vulkan", "shaders", "glsl", "hot_reload", "scene", "frame", "headless", "stills", "verify", "measure", "app"],
    },
    House {
        folder: "src",
        prefix: &["vulkan"],
        rooms: &["error", "device", "resources", "pipelines", "commands", "transfers", "swapchain"],
    },
];

/// A path from one room into a later one.
#[derive(Debug, PartialEq)]
struct Upward {
    file: String,
    from: String,
    to: String,
}

/// The code of a file: without comments and unit tests.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// `a::{b, c::d}` as `a::b` and `a::c::d`.
fn expand(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else { return vec![tree.to_owned()] };
    let (before, inside) = (&tree[..open], &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())]);
    let mut branches = vec![String::new()];
    let mut depth = 0;
    for c in inside.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match branches.last_mut() {
            Some(branch) if c != ',' || depth > 0 => branch.push(c),
            _ => branches.push(String::new()),
        }
    }
    let full = branches.iter().filter(|branch| !branch.trim().is_empty());
    full.flat_map(|branch| expand(branch)).map(|branch| format!("{before}{branch}")).collect()
}

/// All paths in code that begin with `crate` or `super`: those of `use` trees, and those that stand in the text.
fn paths(code: &str) -> Vec<Vec<String>> {
    let (mut found, mut rest) = (Vec::new(), String::new());
    for (k, statement) in code.split("use ").enumerate() {
        match statement.split_once(';') {
            Some((tree, after)) if k > 0 => {
                found.extend(expand(tree));
                rest += after;
            }
            _ => rest += statement,
        }
    }
    let word = |c: char| !c.is_alphanumeric() && c != '_' && c != ':';
    found.extend(rest.split(word).map(str::to_owned));
    let split = |path: String| path.split("::").map(|part| part.trim().to_owned()).collect::<Vec<_>>();
    found.into_iter().map(split).filter(|path| path.len() > 1 && (path[0] == "crate" || path[0] == "super")).collect()
}

/// Paths of one file that go up. `module` is the file's own path in the crate, `exported` the rooms of names that the root exports.
fn upward(house: &House, file: &str, module: &[String], text: &str, exported: &BTreeMap<String, String>) -> Vec<Upward> {
    let height = |room: &str| house.rooms.iter().position(|r| *r == room);
    let within = |path: &[String]| {
        path.strip_prefix(&house.prefix.iter().map(|p| (*p).to_owned()).collect::<Vec<_>>()[..]).map(<[_]>::to_vec)
    };
    let Some(from) = within(module).and_then(|m| m.first().cloned()) else { return Vec::new() };
    let absolute = |path: Vec<String>| {
        let ups = path.iter().take_while(|part| *part == "super").count();
        let base = if ups == 0 { &[][..] } else { &module[..module.len().saturating_sub(ups)] };
        [base, &path[ups.max(1)..]].concat()
    };
    let mut up = Vec::new();
    for path in paths(&code(text)).into_iter().map(absolute) {
        let Some(to) = within(&path).and_then(|p| p.first().cloned()) else { continue };
        let to = exported.get(&to).cloned().unwrap_or(to);
        if let (Some(own), Some(other)) = (height(&from), height(&to)) {
            if other > own {
                up.push(Upward { file: file.to_owned(), from: from.clone(), to });
            }
        }
    }
    up
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Source files below a folder, without folders of unit tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the folder is there").map(|entry| entry.expect("it can be read").path()) {
        if entry.is_dir() && !entry.ends_with("tests") {
            files.extend(sources(&entry));
        } else if entry.extension().is_some_and(|e| e == "rs") {
            files.push(entry);
        }
    }
    files
}

/// The path of a file's module below `folder`.
fn module_of(folder: &Path, file: &Path) -> Vec<String> {
    let below = file.strip_prefix(folder).expect("a file of the folder").with_extension("");
    let mut parts: Vec<String> = below.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    parts.pop_if(|last| last == "mod" || last == "lib");
    parts
}

/// Which room each name comes from that the root of a crate exports.
fn exports(folder: &Path) -> BTreeMap<String, String> {
    let text = std::fs::read_to_string(folder.join("lib.rs")).unwrap_or_default();
    let uses = text.split("pub use ").skip(1).filter_map(|after| after.split_once(';')).flat_map(|(tree, _)| expand(tree));
    uses.filter_map(|path| Some((path.rsplit_once("::")?.1.to_owned(), path.split_once("::")?.0.to_owned()))).collect()
}

#[test]
fn rooms_use_only_those_before_them() {
    let mut found = Vec::new();
    for house in &HOUSES {
        let base = root().join(house.folder);
        let folder = house.prefix.iter().fold(base.clone(), |f, part| f.join(part));
        let exported = exports(&base);
        for file in sources(&folder) {
            let text = std::fs::read_to_string(&file).expect("a source file");
            let name = file.strip_prefix(root()).expect("below the root").display().to_string();
            found.extend(upward(house, &name, &module_of(&base, &file), &text, &exported));
        }
    }
    assert_eq!(found, Vec::new());
}

#[test]
fn every_room_has_its_place() {
    for house in &HOUSES {
        let folder = house.prefix.iter().fold(root().join(house.folder), |f, part| f.join(part));
        let entries = std::fs::read_dir(&folder).expect("the folder is there").map(|e| e.expect("it can be read").path());
        let mut there: Vec<String> =
            entries.map(|path| path.with_extension("").file_name().expect("a name").to_string_lossy().into_owned()).collect();
        there.retain(|name| !["lib", "mod", "tests"].contains(&name.as_str()));
        there.sort_unstable();
        let mut listed: Vec<String> = house.rooms.iter().map(|room| (*room).to_owned()).collect();
        listed.sort_unstable();
        assert_eq!(there, listed, "{}", folder.display());
    }
}

#[test]
fn paths_that_go_up_are_found() {
    let house = &HOUSES[1];
    let module = ["mesh".to_owned(), "builder".to_owned()];
    let found = |text: &str| -> Vec<String> {
        upward(house, "here", &module, text, &BTreeMap::new()).into_iter().map(|up| up.to).collect()
    };
    assert_eq!(found("use crate::{globe::patch, draw::{view::View, tree}};"), ["draw", "draw"]);
    assert_eq!(found("let x = crate::verify::check();"), ["verify"]);
    assert_eq!(found("use super::super::store::PlanetFile;"), ["store"]);
    assert_eq!(found("use super::wake::Wake; use crate::ground::Ground; // crate::draw::view"), Vec::<String>::new());
    assert_eq!(found("fn f() {}\n#[cfg(test)]\nmod tests { use crate::draw::view::View; }"), Vec::<String>::new());
}

#[test]
fn every_file_of_tests_is_run() {
    // Folders whose files are modules of one program, and the files there that are programs of their own.
    for (folder, apart) in [("planet/tests", ""), ("planet/heightfield/tests", ""), ("tests/command", "fly"), ("tests/gpu", "")] {
        let folder = root().join(folder);
        let program = std::fs::read_to_string(folder.join("main.rs")).expect("the program");
        for file in std::fs::read_dir(&folder).expect("the folder is there").map(|entry| entry.expect("it can be read").path()) {
            let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let is_source = file.extension().is_some_and(|e| e == "rs");
            let run = name == "main" || name == apart || program.contains(&format!("\nmod {name};\n"));
            assert!(run || !is_source, "{} is not run: add it to main.rs", file.display());
        }
    }
}
