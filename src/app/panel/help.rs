//! The list of keys.

use super::super::keys::Keys;
use egui::{Align2, Context, Grid, ScrollArea, Window};

/// Shows it over the middle of the picture.
pub(super) fn show(ctx: &Context, keys: &Keys, open: &mut bool) {
    let height = ctx.content_rect().height();
    let window = Window::new("Keys and mouse").anchor(Align2::CENTER_CENTER, [0.0, 0.0]).resizable(false).collapsible(false);
    window.open(open).show(ctx, |ui| {
        ScrollArea::vertical().max_height(height - 90.0).show(ui, |ui| {
            Grid::new("keys").num_columns(2).striped(true).spacing([16.0, 2.0]).show(ui, |ui| {
                for (keys, words) in keys.rows() {
                    ui.monospace(keys);
                    ui.label(words);
                    ui.end_row();
                }
            });
        });
    });
}
