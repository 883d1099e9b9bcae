//! A tile of a planet as GLB: up to one mesh of ground under its maps and one of sea, in whole steps from a point that single precision
//! holds exactly (`KHR_mesh_quantization`).
//!
//! The step is a power of two and the same along all axes, so that positions are exact, and normals need no bending.

use super::super::{ExportError, Picture, Up};
use super::attributes::{padded, short};
use super::buffers::{Buffers, Numbers, SHORT, UNSIGNED_SHORT};
use super::packing::{self, failed, MeshCodec, PackingOrder};
use super::{container, single, CLAMP_TO_EDGE, LINEAR, MIPMAPS};
use glam::{DVec3, IVec3};
use serde_json::{json, Map, Value};

/// Farthest that a vertex may lie from the origin along an axis, in steps.
pub const MOST_STEPS: i32 = i16::MAX as i32;

/// Colour of the sea, linear, and how rough it is.
const WATER_COLOUR: [f32; 4] = [0.004, 0.018, 0.05, 1.0];
const WATER_ROUGHNESS: f32 = 0.25;

/// What the triangles of a part are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileMaterial {
    /// Ground under the maps of the tile.
    Ground,
    /// The surface of the sea.
    Water,
}

/// Triangles of one material, with an origin and a step of their own.
#[derive(Clone, Debug)]
pub struct TilePart {
    /// The origin in metres from the planet's centre, exact in single precision.
    pub anchor: DVec3,
    /// Metres a step, a power of two.
    pub step: f64,
    /// Steps from the origin in planet axes, each within [`MOST_STEPS`].
    pub positions: Vec<IVec3>,
    /// Unit vectors in planet axes.
    pub normals: Vec<DVec3>,
    /// Unit vectors along which the red of the normal map leans, or none.
    pub tangents: Vec<DVec3>,
    /// Places in the maps, or none.
    pub uvs: Vec<[f32; 2]>,
    /// Corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// What they are made of.
    pub material: TileMaterial,
}

/// A tile.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Its parts.
    pub parts: Vec<TilePart>,
    /// Albedo of its ground, sRGB-encoded, and normals in the frame of normal and tangent.
    pub maps: [Picture; 2],
}

impl Tile {
    /// The bytes of a file, whose numbers a codec packs if there is one.
    ///
    /// # Errors
    /// For a tile that is too large, and where the codec fails.
    pub fn encode(&self, codec: Option<&dyn MeshCodec>) -> Result<Vec<u8>, ExportError> {
        let mut buffers = Buffers::packed_by(codec);
        let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
        for (number, part) in self.parts.iter().enumerate() {
            let (place, scale) = (single(Up::Y.turn(part.anchor)), [part.step as f32; 3]);
            nodes.push(json!({ "mesh": number, "translation": place, "scale": scale }));
            meshes.push(json!({ "primitives": [primitive(part, codec, &mut buffers)?] }));
        }
        let has_water = self.parts.iter().any(|part| part.material == TileMaterial::Water);
        let extensions: Vec<&str> = ["KHR_mesh_quantization"].into_iter().chain(codec.map(|_| packing::EXTENSION)).collect();
        let scene: Vec<usize> = (0..nodes.len()).collect();
        let mut document = json!({
            "asset": { "version": "2.0", "generator": concat!("Terrane ", env!("CARGO_PKG_VERSION")) },
            "scene": 0, "scenes": [{ "nodes": scene }], "nodes": nodes, "meshes": meshes,
            "extensionsUsed": extensions, "extensionsRequired": extensions,
        });
        add_materials(&self.maps, has_water, &mut document, &mut buffers);
        document["buffers"] = buffers.described();
        let Buffers { bytes, views, accessors, .. } = buffers;
        document["accessors"] = accessors.into();
        document["bufferViews"] = views.into();
        container(document.to_string().into_bytes(), &bytes)
    }
}

/// Adds a part. Out: its primitive.
fn primitive(part: &TilePart, codec: Option<&dyn MeshCodec>, buffers: &mut Buffers) -> Result<Value, ExportError> {
    let ordered = codec.map(|codec| ordered(part, &codec.order(&part.triangles, part.positions.len()))).transpose()?;
    let part = ordered.as_ref().unwrap_or(part);
    let (attributes, count) = (attributes(part, buffers)?, part.positions.len());
    let indices = buffers.triangles(&part.triangles, count, count < usize::from(u16::MAX))?;
    Ok(json!({ "attributes": attributes, "indices": indices, "material": part.material as usize, "mode": 4 }))
}

/// Adds the materials, each at the number of its [`TileMaterial`].
fn add_materials(maps: &[Picture; 2], has_water: bool, document: &mut Value, buffers: &mut Buffers) {
    let names = ["albedo", "normals"];
    let images = names
        .iter()
        .zip(maps)
        .map(|(name, map)| json!({ "name": name, "bufferView": buffers.picture(&map.bytes), "mimeType": map.mime }));
    document["images"] = images.collect::<Vec<_>>().into();
    document["textures"] = json!([{ "sampler": 0, "source": 0 }, { "sampler": 0, "source": 1 }]);
    document["samplers"] = json!([{ "magFilter": LINEAR, "minFilter": MIPMAPS, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE }]);
    let ground = json!({
        "name": "ground", "normalTexture": { "index": 1 },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicFactor": 0.0, "roughnessFactor": 1.0 },
    });
    let water = json!({
        "name": "water",
        "pbrMetallicRoughness": { "baseColorFactor": WATER_COLOUR, "metallicFactor": 0.0, "roughnessFactor": WATER_ROUGHNESS },
    });
    document["materials"] = if has_water { json!([ground, water]) } else { json!([ground]) };
}

/// Adds the attributes of a part's vertices. Out: their accessors, by name.
fn attributes(part: &TilePart, buffers: &mut Buffers) -> Result<Map<String, Value>, ExportError> {
    let mut names = Map::new();
    let points: Vec<[i16; 3]> = part.positions.iter().map(|&p| [p.x as i16, p.z as i16, -p.y as i16]).collect();
    let count = points.len();
    let bounds = [i16::min, i16::max].map(|pick: fn(i16, i16) -> i16| {
        let merge = |a: [i16; 3], b: &[i16; 3]| [0, 1, 2].map(|k| pick(a[k], b[k]));
        json!(points.iter().skip(1).fold(points.first().copied().unwrap_or_default(), merge))
    });
    let words = |numbers: &[i16; 3]| [numbers[0], numbers[1], numbers[2], 0];
    let bytes: Vec<u8> = points.iter().flat_map(words).flat_map(i16::to_le_bytes).collect();
    let numbers = Numbers { component: SHORT, parts: 3, normalized: false };
    names.insert("POSITION".into(), buffers.attribute(&numbers, count, &bytes, Some(bounds))?.into());
    let turned = |v: &DVec3| Up::Y.turn(*v).to_array();
    let bytes: Vec<u8> =
        part.normals.iter().flat_map(turned).enumerate().flat_map(|(k, c)| padded(short(c), k % 3 == 2)).collect();
    let numbers = Numbers { component: SHORT, parts: 3, normalized: true };
    names.insert("NORMAL".into(), buffers.attribute(&numbers, count, &bytes, None)?.into());
    if !part.tangents.is_empty() {
        let numbers = Numbers { component: SHORT, parts: 4, normalized: true };
        let tangent = |t: &DVec3| Up::Y.turn(*t).extend(1.0).to_array();
        let bytes: Vec<u8> = part.tangents.iter().flat_map(tangent).flat_map(|c| short(c).to_le_bytes()).collect();
        names.insert("TANGENT".into(), buffers.attribute(&numbers, count, &bytes, None)?.into());
    }
    if !part.uvs.is_empty() {
        let numbers = Numbers { component: UNSIGNED_SHORT, parts: 2, normalized: true };
        let code = |c: &f32| ((f64::from(*c) * f64::from(u16::MAX)).round() as u16).to_le_bytes();
        let bytes: Vec<u8> = part.uvs.as_flattened().iter().flat_map(code).collect();
        names.insert("TEXCOORD_0".into(), buffers.attribute(&numbers, count, &bytes, None)?.into());
    }
    Ok(names)
}

/// A part in another order.
fn ordered(part: &TilePart, order: &PackingOrder) -> Result<TilePart, ExportError> {
    let triangles = packing::renumbered(part.positions.len(), order)?;
    let (vertices, lost) = (&order.vertices, || failed("a vertex that the mesh does not have"));
    if vertices.iter().any(|&v| v as usize >= part.positions.len()) {
        return Err(lost());
    }
    Ok(TilePart {
        anchor: part.anchor,
        step: part.step,
        positions: packing::picked(&part.positions, vertices),
        normals: packing::picked(&part.normals, vertices),
        tangents: packing::picked(&part.tangents, vertices),
        uvs: packing::picked(&part.uvs, vertices),
        triangles,
        material: part.material,
    })
}
