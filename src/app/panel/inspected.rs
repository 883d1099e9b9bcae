//! What was picked: the site, the patch that is drawn there, its ancestors, and the parents of its nearest vertex.

use super::super::inspection::{Inspected, Link};
use super::super::outlines::Line;
use super::numbers::{distance, site};
use egui::{Align2, Context, Grid, Id, LayerId, Order, ScrollArea, Shape, Ui, Window};

/// Most that the list of parents takes, in points.
const CHAIN_HEIGHT: f32 = 160.0;

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
        ui.separator();
        ui.weak("the nearest vertex and its parents:");
        ScrollArea::vertical().max_height(CHAIN_HEIGHT).show(ui, |ui| list(ui, &picked.chain));
        ui.weak("white: the patch; grey: those that it is part of; pink: the parents");
    });
    open
}

/// The vertices of a chain: where in the patch's grid, from where they are awake, and whether they are.
fn list(ui: &mut Ui, chain: &[Link]) {
    Grid::new("chain").num_columns(3).spacing([10.0, 1.0]).striped(true).show(ui, |ui| {
        for link in chain {
            ui.label(format!("{}, {}", link.grid[0], link.grid[1]));
            ui.label(link.awake_m.map_or("at any distance".to_owned(), |metres| format!("within {}", distance(metres))));
            ui.label(match link.weight {
                None => "asleep".to_owned(),
                Some(0.0) => "awake".to_owned(),
                Some(weight) => format!("awake, {:.0} % at its parent", 100.0 * weight),
            });
            ui.end_row();
        }
    });
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
