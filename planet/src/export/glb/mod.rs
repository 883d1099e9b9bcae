//! Binary glTF 2.0: one node with one mesh of `f32` positions and `u32` indices, with normals where there are some, and a material where
//! there is a picture; or all of it in 16 bits, by `KHR_mesh_quantization`. A codec packs it, by `EXT_meshopt_compression`.
//!
//! glTF is Y-up: (x, y, z) becomes (x, z, -y), a turn by -90° about X. On a planet north is +Y and longitude 0 stays +X; over a
//! heightfield up is +Y, east +X and north -Z.
//!
//! Positions are rounded to single precision once, as metres from the origin: the error is at most 2^-25 of the coordinate,
//! 0.03 mm at 1 km from the origin and 0.25 m at an Earth's radius from it. The node's translation puts the mesh back where it is
//! on the planet; [`super::origin_near`] gives origins whose translation is exact. `extras` of the node hold the same as lattice
//! integers in the planet's axes (`origin_lattice`), and the length of a lattice unit (`unit_m`). Programs that transform in single precision
//! should drop the translation, or they lose what the origin has won.

mod attributes;
mod buffers;
mod packing;
mod tile;

use super::{ExportError, Model, Origin, Picture, Up};
use attributes::Grid;
use buffers::Buffers;
pub use packing::{MeshCodec, PackingOrder};
use serde_json::{json, Value};
pub use tile::{Tile, TileMaterial, TilePart, MOST_STEPS};

const MAGIC: u32 = 0x4654_6c67;
const VERSION: u32 = 2;
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;
/// How pictures are filtered, as OpenGL numbers it: linearly, between mip levels too, up to their edge.
const LINEAR: u32 = 9729;
const MIPMAPS: u32 = 9987;
const CLAMP_TO_EDGE: u32 = 33_071;

/// The bytes of a file, whose numbers a codec packs if there is one.
///
/// # Errors
/// For more than the 4 GiB that the format can state, and where the codec fails.
pub(super) fn encode(mesh: &Model, codec: Option<&dyn MeshCodec>) -> Result<Vec<u8>, ExportError> {
    let order = codec.map(|codec| codec.order(&mesh.triangles, mesh.positions.len()));
    let ordered = order.map(|order| packing::ordered(mesh, &order)).transpose()?;
    let mesh = ordered.as_ref().unwrap_or(mesh);
    let mut buffers = Buffers::packed_by(codec);
    let grid = mesh.quantized.then(|| Grid::of(mesh));
    let attributes = attributes::add(mesh, grid, &mut buffers)?;
    let indices = attributes::add_triangles(mesh, mesh.quantized, &mut buffers)?;
    let mut primitive = json!({ "attributes": attributes, "indices": indices, "mode": 4 });
    let mut document = json!({
        "asset": {
            "version": "2.0", "generator": concat!("Terrane ", env!("CARGO_PKG_VERSION")),
            "extras": {
                "unit": "metre", "axes": mesh.axes(Up::Y), "origin": mesh.provenance,
                "georeference": mesh.origin.as_ref().map(Origin::json),
            },
        },
        "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": nodes(mesh, grid),
    });
    if mesh.albedo.is_some() || mesh.normal_map.is_some() {
        primitive["material"] = 0.into();
        add_material(mesh, &mut document, &mut buffers);
    }
    document["meshes"] = json!([{ "primitives": [primitive] }]);
    let quantized = mesh.quantized.then_some("KHR_mesh_quantization");
    let extensions: Vec<&str> = quantized.into_iter().chain(codec.map(|_| packing::EXTENSION)).collect();
    if !extensions.is_empty() {
        document["extensionsUsed"] = json!(extensions);
        document["extensionsRequired"] = json!(extensions);
    }
    document["buffers"] = buffers.described();
    let Buffers { bytes, views, accessors, .. } = buffers;
    document["accessors"] = accessors.into();
    document["bufferViews"] = views.into();
    container(document.to_string().into_bytes(), &bytes)
}

/// The node that puts the mesh where it is, and below it, for quantised positions, the one that gives them their size.
fn nodes(mesh: &Model, grid: Option<Grid>) -> Value {
    let mut node = json!({ "name": "terrane", "translation": single(Up::Y.turn(mesh.translation)), "extras": mesh.extras });
    let Some(grid) = grid else {
        node["mesh"] = 0.into();
        return json!([node]);
    };
    node["children"] = json!([1]);
    json!([node, { "name": "quantized", "mesh": 0, "translation": single(grid.low), "scale": single(grid.step) }])
}

fn single(v: glam::DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// Adds a rough, non-metallic material of a mesh's pictures.
fn add_material(mesh: &Model, document: &mut Value, buffers: &mut Buffers) {
    let mut material = json!({ "name": "ground", "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 } });
    let (mut images, mut textures) = (Vec::new(), Vec::new());
    let mut add = |name: &str, picture: &Picture| {
        textures.push(json!({ "sampler": 0, "source": images.len() }));
        images.push(json!({ "name": name, "bufferView": buffers.picture(&picture.bytes), "mimeType": picture.mime }));
        json!({ "index": textures.len() - 1 })
    };
    if let Some(picture) = &mesh.albedo {
        material["pbrMetallicRoughness"]["baseColorTexture"] = add("albedo", picture);
    }
    if let Some(picture) = &mesh.normal_map {
        material["normalTexture"] = add("normals", picture);
    }
    document["materials"] = json!([material]);
    document["images"] = images.into();
    document["textures"] = textures.into();
    document["samplers"] = json!([{ "magFilter": LINEAR, "minFilter": MIPMAPS, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE }]);
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
