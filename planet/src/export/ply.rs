//! Binary little-endian PLY: doubles `x`, `y`, `z`, and `int` lists of vertex indices.

use super::{ExportError, Model};

/// The bytes of a file.
///
/// # Errors
/// For more vertices than a signed index can name.
pub(super) fn encode(mesh: &Model) -> Result<Vec<u8>, ExportError> {
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let (found, most) = (vertices as u64, i32::MAX as u64);
    if found > most {
        return Err(ExportError::TooLarge { what: "a number of vertices", found, format: "PLY", most });
    }
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment Terrane: {}\ncomment {}\n\
         element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.axes, mesh.provenance
    );
    let mut bytes = Vec::with_capacity(header.len() + 24 * vertices + 13 * faces);
    bytes.extend(header.as_bytes());
    for position in &mesh.positions {
        position.to_array().iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    for triangle in mesh.triangles {
        bytes.push(3);
        triangle.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    }
    Ok(bytes)
}
