//! Pictures of the window that are kept: as files, and small beside a remembered view.

use super::flight::{Flight, Screenshot};
use super::host::{Bookmark, Host, Picture};
use super::AppError;
use crate::frame::GuiFrame;
use crate::vulkan::{capture, vk, Access, Commands, Image, ImageDescription};
use egui::TexturesDelta;

impl Flight {
    /// Waits for the latest picture and hands it to `save`, with the interface over it if that was wanted.
    pub(super) fn save_screenshot(&mut self, wanted: Screenshot, gui: GuiFrame, host: &mut dyn Host) -> Result<(), AppError> {
        let Some(picture) = &self.picture else { return Ok(()) };
        let (width, height) = picture.size();
        let captured = match wanted {
            Screenshot::Picture | Screenshot::Bookmark => capture(&self.context, picture, (0, 0), Access::TransferRead)?,
            Screenshot::Window => {
                // The interface is recorded once more, into buffers of a frame that may be under way.
                self.context.wait_idle()?;
                let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT;
                let image =
                    Image::new(&self.context, &ImageDescription::new("screenshot", (width, height), picture.format(), usage))?;
                let gui = GuiFrame { images: TexturesDelta::default(), ..gui };
                Commands::once(&self.context, "screenshot", |commands| {
                    commands.found(picture.view(), Access::TransferRead);
                    commands.ready(&[picture.view().to(Access::TransferRead), image.view().anew(Access::TransferWrite)])?;
                    commands.copy_to_view(picture, image.view())?;
                    self.interface.record(commands, image.view(), &gui)
                })?;
                capture(&self.context, &image, (0, 0), Access::ColorTarget)?
            }
        };
        let picture = Picture { size: [width, height], rgba: captured.to_rgba8()? };
        let said = match wanted {
            Screenshot::Bookmark => self.remember(&picture, host),
            _ => host.save(&picture, &self.view_line()).unwrap_or_else(|problem| problem),
        };
        tracing::info!("{said}");
        self.panel.say(said);
        Ok(())
    }

    /// Remembers what is seen.
    fn remember(&mut self, picture: &Picture, host: &mut dyn Host) -> String {
        let view = self.view_line();
        let bookmark = Bookmark { name: self.panel.take_name(view.at), view, thumbnail: thumbnail(picture) };
        let said = match host.add_bookmark(&bookmark) {
            Ok(()) => format!("remembered as {}", bookmark.name),
            Err(problem) => problem,
        };
        self.panel.set_bookmarks(host.bookmarks());
        said
    }
}

/// Width of a thumbnail in pixels.
const THUMBNAIL: u32 = 224;

/// A picture, smaller: the mean of the pixels that fall on each of its own.
fn thumbnail(picture: &Picture) -> Picture {
    let [width, height] = picture.size;
    let size = [THUMBNAIL.min(width), (THUMBNAIL.min(width) * height / width.max(1)).max(1)];
    let span = |at: u32, small: u32, large: u32| (at * large / small)..((at + 1) * large / small).max(at * large / small + 1);
    let mut rgba = Vec::with_capacity(4 * (size[0] * size[1]) as usize);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let (rows, columns) = (span(y, size[1], height), span(x, size[0], width));
            let count = (rows.len() * columns.len()) as u32;
            let sums = rows
                .flat_map(|row| columns.clone().map(move |column| 4 * (row * width + column) as usize))
                .fold([0; 4], |sums, at| std::array::from_fn(|channel| sums[channel] + u32::from(picture.rgba[at + channel])));
            rgba.extend(sums.map(|sum: u32| (sum / count) as u8));
        }
    }
    Picture { size, rgba }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thumbnail_has_the_means_of_its_picture_and_its_shape() {
        let (width, height) = (4 * THUMBNAIL, 2 * THUMBNAIL);
        let grey = |x: u32, y: u32| if (x + y).is_multiple_of(2) { 40 } else { 60 };
        let rgba = (0..height).flat_map(|y| (0..width).flat_map(move |x| [grey(x, y), grey(x, y), 200, 255])).collect();
        let small = thumbnail(&Picture { size: [width, height], rgba });
        assert_eq!(small.size, [THUMBNAIL, THUMBNAIL / 2]);
        assert!(small.rgba.chunks(4).all(|pixel| pixel == [50, 50, 200, 255]));
        let tiny = Picture { size: [3, 2], rgba: vec![7; 24] };
        assert_eq!(thumbnail(&tiny), tiny);
    }
}
