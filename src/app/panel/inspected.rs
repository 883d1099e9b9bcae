//! What was picked: the site, the patch that is drawn there, and its ancestors.

use super::super::inspection::Inspected;
use super::super::outlines::Line;
use super::numbers::{distance, site};
use egui::{Align2, Context, Grid, Id, LayerId, Order, Shape, Window};

/// Shows it at the right of the picture. False when it was closed.
pub(super) fn show(ctx: &Context, picked: &Inspected) -> bool {
    let mut open = true;
    let window = Window::new("Picked").anchor(Align2::RIGHT_TOP, [-8.0, 8.0]).resizable(false).collapsible(false);
    window.open(&mut open).show(ctx, |ui| {
        Grid::new("picked").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
            let mut row = |name: &str, value: String| {
                ui.weak(name);
                ui.label(value);
                ui.end_row();
            };
            row("at", site(picked.site));
            row("ground", picked.height_m.map_or("not known".to_owned(), distance));
            row("patch", format!("{} (level {})", picked.patch, picked.patch.level));
            row("samples", format!("{} apart", distance(picked.spacing_m)));
            let [low, high] = picked.heights_m.map(distance);
            row("its ground", format!("{low} to {high}"));
            let [prefix, all] = picked.vertices;
            row("vertices", format!("{prefix} of {all} in its prefix"));
            let [sides, detail] = picked.splits_m.map(distance);
            row("splits at", format!("{sides} by its sides, {detail} by its grid"));
        });
        ui.weak("white: the patch; grey: those that it is part of");
    });
    open
}

/// Draws lines below everything else of the interface.
pub(super) fn draw(ctx: &Context, lines: &[Line]) {
    let painter = ctx.layer_painter(LayerId::new(Order::Background, Id::new("lines")));
    let scale = ctx.pixels_per_point();
    for line in lines {
        let points = line.points.iter().map(|[x, y]| egui::pos2(x / scale, y / scale)).collect();
        painter.add(Shape::line(points, egui::Stroke::new(line.width, line.color)));
    }
}
