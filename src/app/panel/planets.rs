//! Other planets, without leaving.

use super::Asked;
use egui::{CollapsingHeader, Key, TextEdit, Ui};

pub(super) fn show(ui: &mut Ui, names: &[String], recent: &[String], text: &mut String, asked: &mut Asked) {
    CollapsingHeader::new("Planet").default_open(false).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            for name in names {
                if ui.button(name).clicked() {
                    asked.open = Some(name.clone());
                }
            }
        });
        ui.horizontal(|ui| {
            let field = ui.add(TextEdit::singleline(text).hint_text("planet file, recipe or picture").desired_width(180.0));
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            if (ui.button("Open").clicked() || entered) && !text.trim().is_empty() {
                asked.open = Some(text.trim().to_owned());
            }
        });
        for path in recent.iter().filter(|path| !names.contains(path)) {
            if ui.link(path).on_hover_text("opened lately").clicked() {
                asked.open = Some(path.clone());
            }
        }
        ui.weak("or drop a file onto the window");
        ui.separator();
        if ui.button("Reset all settings").on_hover_text("all but what is remembered and opened lately").clicked() {
            asked.reset = true;
        }
    });
}
