//! Binary little-endian PLY: doubles `x`, `y`, `z`, floats `nx`, `ny`, `nz` where there are normals, and `int` lists of vertex indices.

use super::{ExportError, Model, Up};

/// The bytes of a file.
///
/// # Errors
/// For more vertices than a signed index can name.
pub(super) fn encode(mesh: &Model, up: Up) -> Result<Vec<u8>, ExportError> {
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let (found, most) = (vertices as u64, i32::MAX as u64);
    if found > most {
        return Err(ExportError::TooLarge { what: "a number of vertices", found, format: "PLY", most });
    }
    let normals = if mesh.normals.is_empty() { "" } else { "property float nx\nproperty float ny\nproperty float nz\n" };
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment Terrane: {}\ncomment {}\n\
         element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n{normals}\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.axes(up),
        mesh.provenance
    );
    let mut bytes = Vec::with_capacity(header.len() + 36 * vertices + 13 * faces);
    bytes.extend(header.as_bytes());
    for (v, &position) in mesh.positions.iter().enumerate() {
        up.turn(position).to_array().iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        if let Some(&normal) = mesh.normals.get(v) {
            up.turn(normal).as_vec3().to_array().iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        }
    }
    for triangle in mesh.triangles.iter() {
        bytes.push(3);
        triangle.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    Ok(bytes)
}
