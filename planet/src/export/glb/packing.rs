//! Packed numbers in GLB files, by `EXT_meshopt_compression` (Kapoulkine 2020). The codecs are meshoptimizer's, which is C++: programs that
//! want them bring them.

use super::super::{ExportError, Model};
use std::borrow::Cow;

/// The extension's name.
pub(super) const EXTENSION: &str = "EXT_meshopt_compression";

/// The codecs of the extension. Failures are what the codec says of them.
pub trait MeshCodec {
    /// An order of triangles, and of vertices by their first use, that packs well.
    fn order(&self, triangles: &[[u32; 3]], vertices: usize) -> PackingOrder;

    /// Packs elements of so many bytes, a multiple of four, as attributes of version 0 of the format.
    ///
    /// # Errors
    /// If they cannot be packed.
    fn attributes(&self, bytes: &[u8], stride: usize) -> Result<Vec<u8>, String>;

    /// Packs triangles as version 1 of the format has them; corners may take turns within a triangle.
    ///
    /// # Errors
    /// If they cannot be packed.
    fn triangles(&self, triangles: &[[u32; 3]], vertices: usize) -> Result<Vec<u8>, String>;
}

/// An order of triangles and vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PackingOrder {
    /// The triangles, by the old numbers of their corners.
    pub triangles: Vec<[u32; 3]>,
    /// The old numbers of the vertices, each at its new one.
    pub vertices: Vec<u32>,
}

/// The triangles of an order by the new numbers of their corners, in a mesh of so many vertices.
pub(super) fn renumbered(vertices: usize, order: &PackingOrder) -> Result<Vec<[u32; 3]>, ExportError> {
    let mut new = vec![u32::MAX; vertices];
    for (number, &old) in order.vertices.iter().enumerate() {
        *new.get_mut(old as usize).ok_or_else(|| failed("a vertex that the mesh does not have"))? = number as u32;
    }
    let corner = |v: u32| new.get(v as usize).copied().filter(|&v| v != u32::MAX);
    let triangle = |t: &[u32; 3]| Some([corner(t[0])?, corner(t[1])?, corner(t[2])?]);
    let triangles: Option<Vec<[u32; 3]>> = order.triangles.iter().map(triangle).collect();
    triangles.ok_or_else(|| failed("a corner that is left out"))
}

/// A mesh in another order.
pub(super) fn ordered(mesh: &Model, order: &PackingOrder) -> Result<Model<'static>, ExportError> {
    let triangles = renumbered(mesh.positions.len(), order)?;
    Ok(Model {
        positions: picked(&mesh.positions, &order.vertices),
        normals: picked(&mesh.normals, &order.vertices),
        tangents: picked(&mesh.tangents, &order.vertices),
        uvs: picked(&mesh.uvs, &order.vertices),
        triangles: Cow::Owned(triangles),
        albedo: mesh.albedo.clone(),
        normal_map: mesh.normal_map.clone(),
        provenance: mesh.provenance.clone(),
        origin: mesh.origin.clone(),
        extras: mesh.extras.clone(),
        quantized: mesh.quantized,
        axes: mesh.axes,
        decimals: mesh.decimals,
        translation: mesh.translation,
    })
}

/// Values of vertices in another order, if there are some.
pub(super) fn picked<T: Copy>(values: &[T], vertices: &[u32]) -> Vec<T> {
    vertices.iter().filter_map(|&v| values.get(v as usize).copied()).collect()
}

/// What a codec says when it fails.
pub(super) fn failed(problem: impl Into<String>) -> ExportError {
    ExportError::Codec { problem: problem.into() }
}
