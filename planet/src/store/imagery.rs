//! The texture record: a [`PatchTexture`] as six planes of bytes, each predicted from the texels left and above.
//!
//! Albedo goes as green and the differences of red and blue from it, which are small on ground of any colour.

use super::error::RecordError;
use super::geometry::cells_are_valid;
use super::predict::median_edge;
use super::record::{RecordReader, RecordWriter};
use crate::patch::PatchId;
use crate::texture::{texture_side, PatchTexture};

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

fn predicted(plane: &[u8], k: usize, side: usize) -> u8 {
    // The first row and column have one neighbour, which then stands for all three.
    match (!k.is_multiple_of(side), k >= side) {
        (true, true) => median_edge(plane[k - 1], plane[k - side], plane[k - side - 1]),
        (true, false) => plane[k - 1],
        (false, true) => plane[k - side],
        (false, false) => 0,
    }
}

fn residuals(plane: &[u8], side: usize) -> Vec<u8> {
    (0..plane.len()).map(|k| plane[k].wrapping_sub(predicted(plane, k, side))).collect()
}

fn restore(plane: &mut [u8], side: usize) {
    for k in 0..plane.len() {
        plane[k] = plane[k].wrapping_add(predicted(plane, k, side));
    }
}
