//! Binary STL: facets of single-precision corners, for printers.
//!
//! STL has no unit: slicers take numbers for millimetres, and these are metres; the header says so.

use super::{ExportError, Model, Up};
use glam::DVec3;

/// Bytes of the header. It must not begin with "solid", which would make it a text file.
const HEADER: usize = 80;

/// The bytes of a file.
///
/// # Errors
/// For more facets than 32 bits count.
pub(super) fn encode(mesh: &Model, up: Up) -> Result<Vec<u8>, ExportError> {
    let (found, most) = (mesh.triangles.len() as u64, u64::from(u32::MAX));
    if found > most {
        return Err(ExportError::TooLarge { what: "a number of facets", found, format: "STL", most });
    }
    let mut bytes = Vec::with_capacity(HEADER + 4 + 50 * mesh.triangles.len());
    bytes.extend(format!("Terrane: {}", mesh.axes(up)).into_bytes().into_iter().take(HEADER));
    bytes.resize(HEADER, b' ');
    bytes.extend((found as u32).to_le_bytes());
    for triangle in mesh.triangles.iter() {
        // Rounded first, so that the normal is that of the facet as it is written.
        let corners = triangle.map(|v| up.turn(mesh.positions[v as usize]).as_vec3());
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or(DVec3::ZERO).as_vec3();
        for vector in [normal, corners[0], corners[1], corners[2]] {
            vector.to_array().iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    Ok(bytes)
}
