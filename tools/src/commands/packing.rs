//! meshoptimizer's codecs, for GLB files with `EXT_meshopt_compression`.

use terrane_planet::export::glb::{MeshCodec, PackingOrder};

/// Version of the format of attributes that the extension allows; meshoptimizer's own default is newer.
const ATTRIBUTES_VERSION: i32 = 0;

/// How hard it tries, which version 0 ignores.
const LEVEL: i32 = 2;

/// The codecs.
pub(crate) struct Meshoptimizer;

impl MeshCodec for Meshoptimizer {
    fn order(&self, triangles: &[[u32; 3]], vertices: usize) -> PackingOrder {
        let corners = meshopt::optimize_vertex_cache(triangles.as_flattened(), vertices);
        let table = meshopt::optimize_vertex_fetch_remap(&corners, vertices);
        let mut order: Vec<(u32, u32)> = table.into_iter().zip(0..).filter(|(new, _)| *new != u32::MAX).collect();
        order.sort_unstable();
        PackingOrder { triangles: corners.as_chunks::<3>().0.to_vec(), vertices: order.into_iter().map(|(_, old)| old).collect() }
    }

    fn attributes(&self, bytes: &[u8], stride: usize) -> Result<Vec<u8>, String> {
        match stride {
            4 => packed::<4>(bytes),
            8 => packed::<8>(bytes),
            12 => packed::<12>(bytes),
            16 => packed::<16>(bytes),
            _ => Err(format!("elements of {stride} bytes")),
        }
    }

    fn triangles(&self, triangles: &[[u32; 3]], vertices: usize) -> Result<Vec<u8>, String> {
        meshopt::encode_index_buffer(triangles.as_flattened(), vertices).map_err(|error| error.to_string())
    }
}

fn packed<const BYTES: usize>(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let elements = bytes.as_chunks::<BYTES>().0;
    meshopt::encode_vertex_buffer_level(elements, LEVEL, Some(ATTRIBUTES_VERSION)).map_err(|error| error.to_string())
}

/// Unpacks elements of so many bytes, as [`MeshCodec::attributes`] packs them.
pub(crate) fn unpacked(count: usize, stride: usize, bytes: &[u8]) -> Result<Vec<u8>, String> {
    match stride {
        4 => unpacked_as::<4>(count, bytes),
        8 => unpacked_as::<8>(count, bytes),
        12 => unpacked_as::<12>(count, bytes),
        16 => unpacked_as::<16>(count, bytes),
        _ => Err(format!("elements of {stride} bytes")),
    }
}

fn unpacked_as<const BYTES: usize>(count: usize, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let elements = meshopt::decode_vertex_buffer::<Element<BYTES>>(bytes, count).map_err(|error| error.to_string())?;
    Ok(elements.into_iter().flat_map(|element| element.0).collect())
}

/// So many bytes.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Element<const BYTES: usize>([u8; BYTES]);

impl<const BYTES: usize> Default for Element<BYTES> {
    fn default() -> Self {
        Element([0; BYTES])
    }
}
