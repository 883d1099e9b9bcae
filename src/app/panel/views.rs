//! Views that the user remembers, as small pictures to click.

use super::super::host::Bookmark;
use super::super::keys::Command;
use super::Asked;
use egui::{Button, CollapsingHeader, ColorImage, Image, TextEdit, TextureHandle, TextureOptions, Ui, Vec2};

/// Width of a thumbnail, in points: two beside each other.
const WIDTH: f32 = 112.0;

/// A bookmark with its thumbnail on the GPU, once that was shown.
pub(crate) struct Shelved {
    pub(super) bookmark: Bookmark,
    texture: Option<TextureHandle>,
}

impl Shelved {
    pub(super) fn new(bookmark: Bookmark) -> Shelved {
        Shelved { bookmark, texture: None }
    }
}

pub(super) fn show(ui: &mut Ui, shelf: &mut [Shelved], name: &mut String, asked: &mut Asked) {
    CollapsingHeader::new("Views").default_open(false).show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(name).hint_text("name").desired_width(150.0));
            if ui.button("Remember").on_hover_text("this view, under the name").clicked() {
                asked.commands.push(Command::Bookmark);
            }
        });
        ui.horizontal_wrapped(|ui| {
            for shelved in shelf {
                ui.vertical(|ui| show_one(ui, shelved, asked));
            }
        });
    });
}

fn show_one(ui: &mut Ui, shelved: &mut Shelved, asked: &mut Asked) {
    let Shelved { bookmark, texture } = shelved;
    let size = bookmark.thumbnail.size.map(|side| side as usize);
    let context = ui.ctx().clone();
    let texture = texture.get_or_insert_with(|| {
        let image = ColorImage::from_rgba_unmultiplied(size, &bookmark.thumbnail.rgba);
        context.load_texture(bookmark.name.clone(), image, TextureOptions::LINEAR)
    });
    let shown = Vec2::new(WIDTH, WIDTH * size[1] as f32 / size[0].max(1) as f32);
    let image = Image::new((texture.id(), shown));
    if ui.add(Button::image(image)).on_hover_text("fly there").clicked() {
        asked.view = Some(bookmark.view.clone());
    }
    ui.horizontal(|ui| {
        ui.set_max_width(WIDTH);
        if ui.small_button("🗑").on_hover_text("forget it").clicked() {
            asked.forget = Some(bookmark.name.clone());
        }
        ui.add(egui::Label::new(&bookmark.name).truncate());
    });
}
