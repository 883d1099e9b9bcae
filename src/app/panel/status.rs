//! What is always shown: one line of status, what is being built as a thin line below the picture, and states that are out of the ordinary.

use super::super::choices::Choices;
use super::super::facts::Facts;
use super::super::keys::{Command, Keys};
use super::super::viewer::Manner;
use super::frames::FrameTimes;
use super::numbers::{count, distance, rate};
use egui::{pos2, Align2, Area, Color32, Context, Id, LayerId, Order, Rect};
use terrane_planet::draw::layout::Mode;

/// Height of the line that says how much is built, in points.
const LINE: f32 = 3.0;
/// Its colour.
const DONE: Color32 = Color32::from_rgb(120, 190, 255);

/// State of the line.
#[derive(Default)]
pub(super) struct Status {
    /// Most patches that were pending since none were.
    most_pending: usize,
}

impl Status {
    pub(super) fn show(&mut self, ctx: &Context, facts: &Facts, choices: &Choices, times: &FrameTimes, keys: &Keys) {
        let area = Area::new(Id::new("status")).anchor(Align2::LEFT_TOP, [8.0, 4.0]).interactable(false).fade_in(false);
        area.show(ctx, |ui| {
            egui::Frame::window(ui.style()).inner_margin(egui::Margin::symmetric(6, 2)).show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.strong(&facts.planet);
                    ui.label(distance(facts.altitude_m));
                    if times.smoothed() > 0.0 {
                        ui.label(rate(times.smoothed()));
                    }
                    ui.label(format!("{} triangles", count(facts.counters.wanted)));
                    for state in unusual(facts, choices, keys) {
                        ui.colored_label(ui.visuals().warn_fg_color, state);
                    }
                    ui.weak(format!("{} keys  {} panel", keys.of_command(Command::Help), keys.of_command(Command::Panel)));
                });
            });
        });
        self.show_pending(ctx, facts);
    }

    fn show_pending(&mut self, ctx: &Context, facts: &Facts) {
        self.most_pending = if facts.pending == 0 { 0 } else { self.most_pending.max(facts.pending) };
        if facts.pending == 0 {
            return;
        }
        let picture = ctx.content_rect();
        let painter = ctx.layer_painter(LayerId::new(Order::Background, Id::new("pending")));
        let share = 1.0 - facts.pending as f32 / self.most_pending as f32;
        let (top, end) = (picture.bottom() - LINE, picture.left() + picture.width() * share);
        painter.rect_filled(Rect::from_min_max(pos2(picture.left(), top), picture.max), 0.0, Color32::from_black_alpha(120));
        painter.rect_filled(Rect::from_min_max(pos2(picture.left(), top), pos2(end, picture.bottom())), 0.0, DONE);
        let area = Area::new(Id::new("building")).anchor(Align2::RIGHT_BOTTOM, [-8.0, -8.0]).interactable(false).fade_in(false);
        area.show(ctx, |ui| {
            egui::Frame::window(ui.style()).inner_margin(egui::Margin::symmetric(6, 2)).show(ui, |ui| {
                ui.add(egui::Label::new(format!("{} patches on their way", facts.pending)).extend());
            });
        });
    }
}

/// What differs from the usual.
fn unusual(facts: &Facts, choices: &Choices, keys: &Keys) -> Vec<String> {
    let mode = choices.look.mode;
    let freeze = keys.of_command(Command::Freeze);
    let states = [
        (mode != Mode::Shaded, mode.name().to_owned()),
        (facts.manner != Manner::Orbit, facts.manner.name().to_owned()),
        (!choices.geomorphs, "no geomorphs".to_owned()),
        (facts.frozen, format!("selection frozen: {freeze} thaws it")),
        (facts.counters.wanted > facts.counters.capacity, "more triangles than fit: some are missing".to_owned()),
        (facts.density < 1.0, format!("scale {}", facts.density)),
    ];
    states.into_iter().filter_map(|(on, text)| on.then_some(text)).collect()
}
