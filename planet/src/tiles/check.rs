//! Reads a set of tiles as a client does, and says what is wrong with it. Shares nothing with what writes them.
//!
//! Checked: every file that is named is there and its bytes have the hash that its name says; errors never rise from a tile to its
//! children; every vertex lies in the box of its tile and of all tiles above; every box in that above.

use glam::{DMat4, DQuat, DVec3, DVec4};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

/// Faults that are described; more are only counted.
const MOST_DESCRIBED: usize = 20;

/// Share of a box by which something may lie outside.
const SLACK: f64 = 1e-6;

/// Deepest nesting that is followed.
const DEEPEST: usize = 64;

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Tiles with a GLB.
    pub tiles: usize,
    /// Files that the set leads to, `tileset.json` included.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Triangles of all tiles.
    pub triangles: u64,
    /// Files under names of content that the set does not lead to.
    pub strays: usize,
    /// How many faults there are.
    pub faults: usize,
    /// The first of them.
    pub described: Vec<String>,
}

/// Unpacks attributes of `EXT_meshopt_compression`: elements, bytes an element, packed bytes.
pub type Unpack<'a> = &'a dyn Fn(usize, usize, &[u8]) -> Result<Vec<u8>, String>;

/// Checks the set of tiles in a folder.
pub fn check(folder: &Path, unpack: Unpack) -> Report {
    let mut checker = Checker { folder, unpack, seen: HashSet::new(), report: Report::default() };
    checker.file(&folder.join("tileset.json"), &Above { error: f64::INFINITY, boxes: Vec::new() });
    checker.report.strays = checker.strays();
    checker.report
}

/// What holds for all tiles below.
#[derive(Clone)]
struct Above {
    error: f64,
    boxes: Vec<Bounds>,
}

/// An oriented box.
#[derive(Clone, Copy)]
struct Bounds {
    middle: DVec3,
    half: [DVec3; 3],
}

impl Bounds {
    fn of(tile: &Value) -> Option<Bounds> {
        let numbers: Vec<f64> = tile["boundingVolume"]["box"].as_array()?.iter().map(Value::as_f64).collect::<Option<_>>()?;
        let v = |k: usize| Some(DVec3::from_slice(numbers.get(3 * k..3 * k + 3)?));
        let found = Bounds { middle: v(0)?, half: [v(1)?, v(2)?, v(3)?] };
        (numbers.len() == 12 && numbers.iter().all(|c| c.is_finite())).then_some(found)
    }

    /// By how many half sizes a point lies outside.
    fn outside(&self, point: DVec3) -> f64 {
        let off = point - self.middle;
        self.half.iter().map(|half| off.dot(*half).abs() / half.length_squared() - 1.0).fold(f64::MIN, f64::max)
    }

    fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        (0..8).map(|k| (0..3).fold(self.middle, |p, axis| p + self.half[axis] * if k >> axis & 1 == 0 { -1.0 } else { 1.0 }))
    }
}

struct Checker<'a> {
    folder: &'a Path,
    unpack: Unpack<'a>,
    seen: HashSet<PathBuf>,
    report: Report,
}

impl Checker<'_> {
    fn fault(&mut self, what: String) {
        self.report.faults += 1;
        if self.report.described.len() < MOST_DESCRIBED {
            self.report.described.push(what);
        }
    }

    /// A tileset.
    fn file(&mut self, path: &Path, above: &Above) {
        let name = path.display().to_string();
        if self.seen.contains(path) {
            return self.fault(format!("{name}: two tiles lead to it"));
        }
        let Some(bytes) = self.read(path) else { return };
        let set: Value = match serde_json::from_slice(&bytes) {
            Ok(set) => set,
            Err(error) => return self.fault(format!("{name}: no JSON: {error}")),
        };
        if set["asset"]["version"] != "1.1" {
            self.fault(format!("{name}: version {}, expected 1.1", set["asset"]["version"]));
        }
        if set["extensionsRequired"].as_array().is_some_and(|required| !required.is_empty()) {
            self.fault(format!("{name}: requires extensions: {}", set["extensionsRequired"]));
        }
        if set["geometricError"].as_f64().is_none_or(|error| error < set["root"]["geometricError"].as_f64().unwrap_or(f64::NAN)) {
            self.fault(format!("{name}: its geometricError is below that of its root"));
        }
        if set["root"]["refine"] != "REPLACE" {
            self.fault(format!("{name}: refines by {}, expected REPLACE", set["root"]["refine"]));
        }
        self.tile(path, &set["root"], above);
    }

    /// The bytes of a file that was not read yet.
    fn read(&mut self, path: &Path) -> Option<Vec<u8>> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) => {
                self.fault(format!("{}: {error}", path.display()));
                return None;
            }
        };
        if !self.seen.insert(path.to_owned()) {
            return Some(bytes);
        }
        self.report.files += 1;
        self.report.bytes += bytes.len() as u64;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        if path != self.folder.join("tileset.json") && (stem.len() < 32 || !hash.starts_with(&stem)) {
            self.fault(format!("{}: its bytes have the hash {hash}", path.display()));
        }
        Some(bytes)
    }

    fn tile(&mut self, file: &Path, tile: &Value, above: &Above) {
        let name = tile["extras"]["patch"].as_str().unwrap_or("a tile without a name").to_owned();
        let at = format!("{name} in {}", file.display());
        let Some(bounds) = Bounds::of(tile) else { return self.fault(format!("{at}: no box")) };
        let Some(error) = tile["geometricError"].as_f64().filter(|error| error.is_finite() && *error >= 0.0) else {
            return self.fault(format!("{at}: no geometricError"));
        };
        if error > above.error {
            self.fault(format!("{at}: geometricError {error} after {} above", above.error));
        }
        if let Some(outer) = above.boxes.last() {
            let worst = bounds.corners().map(|corner| outer.outside(corner)).fold(f64::MIN, f64::max);
            if worst > SLACK {
                self.fault(format!("{at}: its box leaves the one above by {worst} of its size"));
            }
        }
        let below = Above { error, boxes: above.boxes.iter().copied().chain([bounds]).collect() };
        if below.boxes.len() > DEEPEST {
            return self.fault(format!("{at}: nested more than {DEEPEST} deep"));
        }
        if let Some(uri) = tile["content"]["uri"].as_str() {
            match self.resolve(file, uri) {
                None => self.fault(format!("{at}: '{uri}' leads out of the folder")),
                Some(path) if uri.ends_with(".json") => self.file(&path, &below),
                Some(path) => self.content(&path, &at, &below),
            }
        }
        for child in tile["children"].as_array().into_iter().flatten() {
            self.tile(file, child, &below);
        }
    }

    /// The file that an address names, if it is in the folder.
    fn resolve(&self, from: &Path, uri: &str) -> Option<PathBuf> {
        let mut path = from.parent()?.to_owned();
        for part in Path::new(uri).components() {
            match part {
                Component::Normal(part) => path.push(part),
                Component::ParentDir if path != self.folder => path = path.parent()?.to_owned(),
                Component::CurDir => {}
                _ => return None,
            }
        }
        path.starts_with(self.folder).then_some(path)
    }

    fn content(&mut self, path: &Path, at: &str, above: &Above) {
        let Some(bytes) = self.read(path) else { return };
        self.report.tiles += 1;
        match points(&bytes, self.unpack) {
            Err(problem) => self.fault(format!("{}: {problem}", path.display())),
            Ok((points, triangles)) => {
                self.report.triangles += triangles;
                let outside = |bounds: &Bounds| points.iter().map(|&p| bounds.outside(p)).fold(f64::MIN, f64::max);
                let worst = above.boxes.iter().map(outside).fold(f64::MIN, f64::max);
                if worst > SLACK {
                    self.fault(format!("{at}: a vertex lies {worst} of the size of a box outside of it"));
                }
            }
        }
    }

    fn strays(&self) -> usize {
        let folders = std::fs::read_dir(self.folder).into_iter().flatten().flatten().filter(|entry| entry.file_name().len() == 2);
        let files = folders.flat_map(|folder| std::fs::read_dir(folder.path()).into_iter().flatten().flatten());
        files.filter(|file| !self.seen.contains(&file.path())).count()
    }
}

/// All vertices of a GLB in metres and in the axes of tilesets, and its triangles.
///
/// # Errors
/// With what is wrong with it.
pub fn points(bytes: &[u8], unpack: Unpack) -> Result<(Vec<DVec3>, u64), String> {
    let (document, binary) = chunks(bytes)?;
    let (mut points, mut triangles) = (Vec::new(), 0);
    for node in document["nodes"].as_array().into_iter().flatten() {
        let Some(mesh) = node["mesh"].as_u64() else { continue };
        let matrix = matrix(node);
        for primitive in document["meshes"][mesh as usize]["primitives"].as_array().into_iter().flatten() {
            let accessor = primitive["attributes"]["POSITION"].as_u64().ok_or("a primitive without POSITION")?;
            for [x, y, z] in positions(&document, binary, accessor as usize, unpack)? {
                let p = matrix.transform_point3(DVec3::new(x, y, z));
                // What clients do with the axes of glTF: +Y up becomes +Z up.
                points.push(DVec3::new(p.x, -p.z, p.y));
            }
            let indices = primitive["indices"].as_u64().ok_or("a primitive without indices")?;
            triangles += document["accessors"][indices as usize]["count"].as_u64().unwrap_or(0) / 3;
        }
    }
    match points.is_empty() {
        true => Err("a GLB without vertices".into()),
        false => Ok((points, triangles)),
    }
}

/// Document and binary chunk of a GLB.
fn chunks(bytes: &[u8]) -> Result<(Value, &[u8]), String> {
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize).ok_or("cut off");
    if word(0)? != 0x4654_6c67 || word(4)? != 2 || word(8)? != bytes.len() {
        return Err("no GLB of version 2 and of this length".into());
    }
    let end = 20 + word(12)?;
    let document = serde_json::from_slice(bytes.get(20..end).ok_or("cut off")?).map_err(|error| error.to_string())?;
    let length = word(end)?;
    Ok((document, bytes.get(end + 8..end + 8 + length).ok_or("cut off")?))
}

fn matrix(node: &Value) -> DMat4 {
    let numbers = |key: &str| -> Option<Vec<f64>> { node[key].as_array()?.iter().map(Value::as_f64).collect() };
    let vector = |key: &str, or: DVec3| numbers(key).filter(|n| n.len() == 3).map_or(or, |n| DVec3::from_slice(&n));
    let turn = numbers("rotation").filter(|n| n.len() == 4).map_or(DQuat::IDENTITY, |n| DQuat::from_vec4(DVec4::from_slice(&n)));
    DMat4::from_scale_rotation_translation(vector("scale", DVec3::ONE), turn, vector("translation", DVec3::ZERO))
}

/// The numbers of an accessor of positions in 16 bits.
fn positions(document: &Value, binary: &[u8], accessor: usize, unpack: Unpack) -> Result<Vec<[f64; 3]>, String> {
    let accessor = &document["accessors"][accessor];
    if accessor["componentType"] != 5122 || accessor["type"] != "VEC3" {
        return Err("positions that are not three shorts".into());
    }
    let count = accessor["count"].as_u64().unwrap_or(0) as usize;
    let view = &document["bufferViews"][accessor["bufferView"].as_u64().ok_or("positions without a view")? as usize];
    let packed = &view["extensions"]["EXT_meshopt_compression"];
    let source = if packed.is_object() { packed } else { view };
    let number = |key: &str| source[key].as_u64().unwrap_or(0) as usize;
    let (offset, length, stride) = (number("byteOffset"), number("byteLength"), number("byteStride"));
    let plain = binary.get(offset..offset.saturating_add(length)).ok_or("positions outside of the buffer")?;
    let plain = if packed.is_object() { unpack(count, stride, plain)? } else { plain.to_vec() };
    if stride < 6 || plain.len() < count.saturating_mul(stride) {
        return Err("positions cut off".into());
    }
    let short = |bytes: &[u8], k: usize| f64::from(i16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]));
    Ok(plain.chunks_exact(stride).take(count).map(|bytes| [0, 1, 2].map(|k| short(bytes, k))).collect())
}
