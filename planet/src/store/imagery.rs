//! The texture record: a [`PatchTexture`] as six planes of bytes, each predicted from the texels left and above.
//!
//! Albedo goes as green and the differences of red and blue from it, which are small on ground of any colour.

use super::error::RecordError;
use super::geometry::cells_are_valid;
use super::predict::median_edge;
use super::record::{RecordReader, RecordWriter};
use crate::globe::patch::PatchId;
use crate::ground::texture::{texture_side, PatchTexture};

/// First bytes of a texture record.
pub const MAGIC: [u8; 4] = *b"TRPT";

/// Names of the planes, in file order.
const PLANES: [&str; 6] = ["first slope", "second slope", "green", "red less green", "blue less green", "shore"];

/// The record of a texture, or why it has none: its size must be that of the patch's cells.
pub fn encode(texture: &PatchTexture, id: PatchId, cells: u32) -> Result<Vec<u8>, RecordError> {
    let side = side(cells)?;
    let sizes = [texture.slopes.len(), texture.albedo.len(), texture.shore.len()];
    if let Some(&found) = sizes.iter().find(|&&size| size != side * side) {
        return Err(RecordError::Short { what: "texture", found, expected: side * side });
    }
    let mut record = RecordWriter::new(MAGIC, id, cells);
    let slope = |k: usize| texture.slopes.iter().map(|s| s[k] as u8).collect::<Vec<u8>>();
    let less_green = |k: usize| texture.albedo.iter().map(|c| c[k].wrapping_sub(c[1])).collect::<Vec<u8>>();
    let green = texture.albedo.iter().map(|c| c[1]).collect();
    for plane in [slope(0), slope(1), green, less_green(0), less_green(2), texture.shore.clone()] {
        record.stream(&residuals(&plane, side));
    }
    Ok(record.finish())
}

/// The texture of a record.
pub fn decode(bytes: &[u8], id: PatchId, cells: u32) -> Result<PatchTexture, RecordError> {
    let side = side(cells)?;
    let texels = side * side;
    let mut record = RecordReader::open(bytes, MAGIC, id, cells)?;
    if record.raw != PLANES.len() * texels {
        return Err(RecordError::Short { what: "raw record", found: record.raw, expected: PLANES.len() * texels });
    }
    let mut planes = Vec::with_capacity(PLANES.len());
    for name in PLANES {
        let mut plane = record.stream(name, texels)?;
        restore(&mut plane, side);
        planes.push(plane);
    }
    record.finish()?;
    let slopes = (0..texels).map(|k| [planes[0][k] as i8, planes[1][k] as i8]).collect();
    let colour = |k: usize| {
        let green = planes[2][k];
        [planes[3][k].wrapping_add(green), green, planes[4][k].wrapping_add(green)]
    };
    let albedo = (0..texels).map(colour).collect();
    Ok(PatchTexture { slopes, albedo, shore: planes.swap_remove(5) })
}

fn side(cells: u32) -> Result<usize, RecordError> {
    let wrong = RecordError::Measure("the grid's cells are not a power of two in range");
    if cells_are_valid(cells) {
        Ok(texture_side(cells) as usize)
    } else {
        Err(wrong)
    }
}

/// What each texel differs by from its prediction. The first row and column have one neighbour, which then stands for all three.
pub(super) fn residuals(plane: &[u8], side: usize) -> Vec<u8> {
    let mut residuals = plane.to_vec();
    for k in 1..side {
        residuals[k] = plane[k].wrapping_sub(plane[k - 1]);
    }
    let rows = plane.chunks_exact(side).zip(plane.chunks_exact(side).skip(1));
    for ((above, row), out) in rows.zip(residuals.chunks_exact_mut(side).skip(1)) {
        out[0] = row[0].wrapping_sub(above[0]);
        for (k, out) in out.iter_mut().enumerate().skip(1) {
            *out = row[k].wrapping_sub(median_edge(row[k - 1], above[k], above[k - 1]));
        }
    }
    residuals
}

/// Inverse of [`residuals`].
pub(super) fn restore(plane: &mut [u8], side: usize) {
    for k in 1..side {
        plane[k] = plane[k].wrapping_add(plane[k - 1]);
    }
    for first in (side..plane.len()).step_by(side) {
        let (above, row) = plane.split_at_mut(first);
        let (above, row) = (&above[first - side..], &mut row[..side]);
        let mut left = row[0].wrapping_add(above[0]);
        row[0] = left;
        for (texel, pair) in row[1..].iter_mut().zip(above.windows(2)) {
            left = texel.wrapping_add(median_edge(left, pair[1], pair[0]));
            *texel = left;
        }
    }
}
