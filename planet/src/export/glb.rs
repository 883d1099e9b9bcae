//! Binary glTF 2.0: one node with one mesh of `f32` positions and `u32` indices.
//!
//! glTF is Y-up: (x, y, z) becomes (x, z, -y), a turn by -90° about X. On a planet north is +Y and longitude 0 stays +X; over a
//! heightfield up is +Y, east +X and north -Z.
//!
//! Positions are rounded to single precision once, as metres from the origin: the error is at most 2^-25 of the coordinate,
//! 0.03 mm at 1 km from the origin and 0.25 m at an Earth's radius from it. The node's translation puts the mesh back where it is
//! on the planet; [`super::origin_near`] gives origins whose translation is exact. `extras` of the node hold the same as lattice
//! integers in the planet's axes (`origin_lattice`), and the length of a lattice unit (`unit_m`). Programs that transform in single precision
//! should drop the translation, or they lose what the origin has won.

use super::{ExportError, Model};
use glam::DVec3;
use serde_json::json;

const MAGIC: u32 = 0x4654_6c67;
const VERSION: u32 = 2;
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;
/// Component types and buffer targets, as OpenGL numbers them.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;

/// The bytes of a file.
///
/// # Errors
/// For more than the 4 GiB that the format can state.
pub(super) fn encode(mesh: &Model) -> Result<Vec<u8>, ExportError> {
    let (vertex_bytes, index_bytes) = (12 * mesh.positions.len() as u64, 12 * mesh.triangles.len() as u64);
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    let mut binary = Vec::new();
    for &position in &mesh.positions {
        let point = y_up(position);
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
            binary.extend(point[axis].to_le_bytes());
        }
    }
    mesh.triangles.as_flattened().iter().for_each(|v| binary.extend(v.to_le_bytes()));
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("Terrane ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{
            "name": "terrane", "mesh": 0, "translation": y_up(mesh.translation), "extras": mesh.extras,
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "mode": 4 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": FLOAT, "count": mesh.positions.len(), "type": "VEC3", "min": low, "max": high },
            { "bufferView": 1, "componentType": UNSIGNED_INT, "count": 3 * mesh.triangles.len(), "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": vertex_bytes, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": vertex_bytes, "byteLength": index_bytes, "target": ELEMENT_ARRAY_BUFFER },
        ],
        "buffers": [{ "byteLength": vertex_bytes + index_bytes }],
    });
    container(document.to_string().into_bytes(), &binary)
}

/// Metres in glTF's axes.
fn y_up(metres: DVec3) -> [f32; 3] {
    // No negative zero, which some validators dislike.
    [metres.x, metres.z, 0.0 - metres.y].map(|c| c as f32)
}

/// Header and the two chunks, each of whole words.
fn container(mut document: Vec<u8>, binary: &[u8]) -> Result<Vec<u8>, ExportError> {
    document.resize(document.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + document.len() as u64 + 8 + binary.len() as u64;
    let most = u64::from(u32::MAX);
    if length > most {
        return Err(ExportError::TooLarge { what: "a length", found: length, format: "GLB", most });
    }
    let mut bytes = Vec::with_capacity(length as usize);
    let words = |bytes: &mut Vec<u8>, words: &[u32]| words.iter().for_each(|w| bytes.extend(w.to_le_bytes()));
    words(&mut bytes, &[MAGIC, VERSION, length as u32, document.len() as u32, JSON_CHUNK]);
    bytes.extend(document);
    words(&mut bytes, &[binary.len() as u32, BINARY_CHUNK]);
    bytes.extend(binary);
    Ok(bytes)
}
