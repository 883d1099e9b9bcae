//! Stage `overlay`: lines of text over a finished picture. Shaders: `overlay.vert`, `overlay.frag`.
//!
//! In: text. Out: glyphs blended into the picture, one instanced quad a character.

use crate::shaders;
use crate::vulkan::{
    vk, Access, Blend, Buffer, ColorTarget, Commands, Context, GraphicsDescription, GraphicsPipeline, ImageView, Memory,
    Resource, Result, Usage, FRAMES_IN_FLIGHT,
};
use font8x8::legacy::BASIC_LEGACY;
use std::sync::Arc;
use terrane_planet::draw::layout::{TEXT_CELL, TEXT_POSITION_BITS};

/// Most characters drawn; text past it is cut off.
const MAX_CHARACTERS: usize = 4096;

/// Columns and rows that a cell's word can tell apart.
const MOST_CELLS: usize = 1 << TEXT_POSITION_BITS;

/// The stage's pipeline, its font, and the text of each frame in flight.
pub struct Overlay {
    pipeline: GraphicsPipeline,
    glyphs: Buffer,
    cells: Vec<Buffer>,
    slot: usize,
}

impl Overlay {
    /// Builds the pipeline for pictures of a format.
    pub fn new(context: &Arc<Context>, format: vk::Format) -> Result<Overlay> {
        let formats = [format];
        let mut description = GraphicsDescription::new(shaders::OVERLAY_VERT, Some(shaders::OVERLAY_FRAG), &formats);
        description.blend = Blend::Premultiplied;
        description.topology = vk::PrimitiveTopology::TRIANGLE_STRIP;
        let upload = |name: &str, bytes: usize| Buffer::new(context, name, bytes as u64, Usage::STORAGE_BUFFER, Memory::Upload);
        let mut glyphs = upload("glyphs", size_of_val(&BASIC_LEGACY))?;
        glyphs.write(0, BASIC_LEGACY.as_flattened())?;
        Ok(Overlay {
            pipeline: GraphicsPipeline::new(context, "overlay", &description)?,
            glyphs,
            cells: (0..FRAMES_IN_FLIGHT).map(|_| upload("text", 4 * MAX_CHARACTERS)).collect::<Result<_>>()?,
            slot: 0,
        })
    }

    /// Records the stage: blends `text` into `picture` from its upper left corner, each pixel of the font drawn as `scale` × `scale`.
    /// Call it once a frame: the frame before the last must have finished.
    pub fn record(&mut self, commands: &mut Commands, picture: &ImageView, text: &str, scale: u32) -> Result<()> {
        let (width, height) = picture.size();
        let columns = (width / (TEXT_CELL[0] * scale)).max(1);
        let cells = layout(text, columns as usize);
        if cells.is_empty() {
            return Ok(());
        }
        self.slot = (self.slot + 1) % self.cells.len();
        self.cells[self.slot].write(0, &cells)?;
        let clip = |pixels: u32, side: u32| (2 * pixels * scale) as f32 / side as f32;
        commands.zone("overlay", |commands| {
            commands.ready(&[picture.to(Access::ColorTarget)])?;
            commands.begin_rendering(&[ColorTarget { view: picture, clear: None }], None)?;
            commands.bind(
                &self.pipeline,
                &[("Cells", Resource::Storage(&self.cells[self.slot])), ("Glyphs", Resource::Storage(&self.glyphs))],
            )?;
            commands.push_constants(&[clip(TEXT_CELL[0], width), clip(TEXT_CELL[1], height)])?;
            commands.draw(4, cells.len() as u32)?;
            commands.end_rendering()
        })
    }
}

/// The cells of a text wrapped at `columns`: column, row and character, [`TEXT_POSITION_BITS`] apart. What the font lacks becomes
/// a question mark.
fn layout(text: &str, columns: usize) -> Vec<u32> {
    let columns = columns.min(MOST_CELLS);
    let mut cells = Vec::new();
    let rows = text.lines().flat_map(|line| wrap(line, columns));
    for (row, line) in rows.enumerate().take(MOST_CELLS) {
        for (column, character) in line.chars().enumerate().take(columns) {
            let code = if character.is_ascii() { character as u32 } else { u32::from(b'?') };
            cells.push(column as u32 | (row as u32) << TEXT_POSITION_BITS | code << (2 * TEXT_POSITION_BITS));
        }
    }
    cells.truncate(MAX_CHARACTERS);
    cells
}

/// Breaks a line between words where it can.
fn wrap(line: &str, columns: usize) -> Vec<String> {
    let mut rows = vec![String::new()];
    for word in line.split_inclusive(' ') {
        let used = rows.last().map_or(0, |row| row.chars().count());
        if used > 0 && used + word.trim_end().chars().count() > columns {
            rows.push(String::new());
        }
        if let Some(row) = rows.last_mut() {
            row.push_str(word);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_wraps_between_words_and_stays_in_its_columns() {
        let cells = layout("ab cd\nüx", 4);
        let decoded = |cell: &u32| (cell & 0x3ff, cell >> 10 & 0x3ff, char::from_u32(cell >> 20).unwrap());
        let expected = [(0, 0, 'a'), (1, 0, 'b'), (2, 0, ' '), (0, 1, 'c'), (1, 1, 'd'), (0, 2, '?'), (1, 2, 'x')];
        assert_eq!(cells.iter().map(decoded).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn a_word_longer_than_the_window_is_cut_off() {
        assert_eq!(layout(&"w".repeat(50), 8).len(), 8);
        assert_eq!(layout(&"a b ".repeat(MAX_CHARACTERS), 8).len(), MAX_CHARACTERS);
    }
}
