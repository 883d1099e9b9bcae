//! The attributes of vertices as GLB files hold them: in single precision, or in 16 bits (`KHR_mesh_quantization`).

use super::super::{ExportError, Model, Up};
use super::buffers::{Buffers, Numbers, FLOAT, SHORT, UNSIGNED_SHORT};
use glam::DVec3;
use serde_json::{json, Map, Value};

/// Largest whole numbers of 16 bits.
const U16: f64 = 65_535.0;
const I16: f64 = 32_767.0;

/// The grid that quantised positions are on: metres are `low + step * number`, axis by axis, in glTF's axes.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub low: DVec3,
    pub step: DVec3,
}

impl Grid {
    /// The finest one of 16 bits that holds all vertices of a mesh.
    pub(super) fn of(mesh: &Model) -> Grid {
        let points = mesh.positions.iter().map(|&p| Up::Y.turn(p));
        let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let step = (high - low) / U16;
        // Any step does along an axis on which all vertices agree.
        Grid { low, step: DVec3::select(step.cmpgt(DVec3::ZERO), step, DVec3::ONE) }
    }
}

/// Adds all attributes of a mesh; without a grid in single precision. Out: their accessors, by name.
pub(super) fn add(mesh: &Model, grid: Option<Grid>, buffers: &mut Buffers) -> Result<Map<String, Value>, ExportError> {
    let mut names = Map::new();
    let mut note = |name: &str, accessor: usize| names.insert(name.to_owned(), accessor.into());
    note("POSITION", positions(mesh, grid, buffers)?);
    if !mesh.normals.is_empty() {
        note("NORMAL", normals(mesh, grid, buffers)?);
    }
    if !mesh.tangents.is_empty() {
        note("TANGENT", tangents(mesh, grid, buffers)?);
    }
    if !mesh.uvs.is_empty() {
        note("TEXCOORD_0", uvs(mesh, grid.is_some(), buffers)?);
    }
    Ok(names)
}

/// Adds the triangles; with `short`, in 16 bits where that is enough.
pub(super) fn add_triangles(mesh: &Model, short: bool, buffers: &mut Buffers) -> Result<usize, ExportError> {
    let vertices = mesh.positions.len();
    // The largest number means "begin anew" to some devices.
    buffers.triangles(&mesh.triangles, vertices, short && vertices < usize::from(u16::MAX))
}

fn positions(mesh: &Model, grid: Option<Grid>, buffers: &mut Buffers) -> Result<usize, ExportError> {
    let count = mesh.positions.len();
    let points = mesh.positions.iter().map(|&p| Up::Y.turn(p));
    let Some(grid) = grid else {
        let points: Vec<[f32; 3]> = points.map(|p| p.as_vec3().to_array()).collect();
        let bounds = [f32::min, f32::max].map(|pick| {
            let merge = |a: [f32; 3], b: &[f32; 3]| [0, 1, 2].map(|k| pick(a[k], b[k]));
            json!(points.iter().fold(points[0], merge))
        });
        let bytes = floats(points.as_flattened());
        return buffers.attribute(&Numbers { component: FLOAT, parts: 3, normalized: false }, count, &bytes, Some(bounds));
    };
    let points: Vec<[u16; 4]> = points
        .map(|p| ((p - grid.low) / grid.step).round().to_array())
        .map(|[x, y, z]| [x as u16, y as u16, z as u16, 0])
        .collect();
    let bounds = [Ord::min, Ord::max].map(|pick: fn(u16, u16) -> u16| {
        let merge = |a: [u16; 4], b: &[u16; 4]| [0, 1, 2, 3].map(|k| pick(a[k], b[k]));
        json!(points.iter().fold(points[0], merge)[..3])
    });
    let bytes: Vec<u8> = points.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    buffers.attribute(&Numbers { component: UNSIGNED_SHORT, parts: 3, normalized: false }, count, &bytes, Some(bounds))
}

/// Normals; on a grid with another step on each axis they are bent so that its scale bends them back.
fn normals(mesh: &Model, grid: Option<Grid>, buffers: &mut Buffers) -> Result<usize, ExportError> {
    let scale = grid.map_or(DVec3::ONE, |grid| grid.step);
    let bent = |normal: &DVec3| (Up::Y.turn(*normal) * scale).normalize_or(DVec3::Y).to_array();
    let bytes = match grid {
        Some(_) => mesh.normals.iter().flat_map(bent).enumerate().flat_map(|(k, c)| padded(short(c), k % 3 == 2)).collect(),
        None => floats(&mesh.normals.iter().flat_map(bent).map(|c| c as f32).collect::<Vec<_>>()),
    };
    let component = if grid.is_some() { SHORT } else { FLOAT };
    buffers.attribute(&Numbers { component, parts: 3, normalized: grid.is_some() }, mesh.normals.len(), &bytes, None)
}

/// Tangents, with +1 for bitangents that are normal × tangent; bent, too, but as ways on the ground.
fn tangents(mesh: &Model, grid: Option<Grid>, buffers: &mut Buffers) -> Result<usize, ExportError> {
    let scale = grid.map_or(DVec3::ONE, |grid| grid.step);
    let bent = |tangent: &DVec3| (Up::Y.turn(*tangent) / scale).normalize_or(DVec3::X).extend(1.0).to_array();
    let numbers = mesh.tangents.iter().flat_map(bent);
    let (component, bytes) = match grid {
        Some(_) => (SHORT, numbers.flat_map(|c| short(c).to_le_bytes()).collect()),
        None => (FLOAT, floats(&numbers.map(|c| c as f32).collect::<Vec<_>>())),
    };
    buffers.attribute(&Numbers { component, parts: 4, normalized: grid.is_some() }, mesh.tangents.len(), &bytes, None)
}

fn uvs(mesh: &Model, short: bool, buffers: &mut Buffers) -> Result<usize, ExportError> {
    let (component, bytes) = if short {
        let code = |c: &f32| ((f64::from(*c) * U16).round() as u16).to_le_bytes();
        (UNSIGNED_SHORT, mesh.uvs.as_flattened().iter().flat_map(code).collect())
    } else {
        (FLOAT, floats(mesh.uvs.as_flattened()))
    };
    buffers.attribute(&Numbers { component, parts: 2, normalized: short }, mesh.uvs.len(), &bytes, None)
}

/// A share of one as a number of 16 bits.
pub(super) fn short(share: f64) -> i16 {
    (share * I16).round() as i16
}

/// The bytes of a number, and two more after the last one of an element.
pub(super) fn padded(number: i16, is_last: bool) -> impl Iterator<Item = u8> {
    number.to_le_bytes().into_iter().chain(is_last.then_some([0; 2]).into_iter().flatten())
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|c| c.to_le_bytes()).collect()
}
