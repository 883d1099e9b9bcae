//! Camera paths: made here, played, saved for `record` and `bench`, and filmed.

use super::super::facts::Facts;
use super::super::keys::Command;
use super::super::storyboard::{Revision, Storyboard};
use super::numbers::distance;
use super::Asked;
use egui::{CollapsingHeader, DragValue, Grid, TextEdit, Ui};
use terrane_planet::draw::camera_path::{Keyframe, Pace};
use terrane_planet::draw::view_line::Stand;
use terrane_planet::planet::Journey;

/// What is to become of the path.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) enum PathWish {
    /// Work on a journey over this planet.
    Take(Journey),
    /// Save it, read it, or film it, under a name.
    Save(String),
    Load(String),
    Film(String),
    /// Fly to this keyframe.
    Visit(usize),
}

/// What is typed and chosen beside the path.
#[derive(Default)]
pub(super) struct PathForm {
    name: String,
    /// Whether keyframes stand at heights above the datum rather than altitudes above the ground.
    pub(super) level: bool,
}

impl PathForm {
    /// The name that was typed, or the usual one.
    pub(super) fn name(&self) -> String {
        let typed = self.name.trim();
        if typed.is_empty() { "path" } else { typed }.to_owned()
    }
}

pub(super) fn show(ui: &mut Ui, facts: &Facts, board: &mut Storyboard, form: &mut PathForm, asked: &mut Asked) {
    CollapsingHeader::new("Path").default_open(false).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            for (name, journey) in Journey::ALL {
                if ui.button(name).on_hover_text("over this planet").clicked() {
                    asked.path = Some(PathWish::Take(journey));
                }
            }
        });
        ui.horizontal_wrapped(|ui| {
            if ui.button("Add keyframe").on_hover_text("where the viewer is").clicked() {
                asked.commands.push(Command::AddKeyframe);
            }
            if ui.button(if facts.plays { "Stop" } else { "Play" }).clicked() {
                asked.commands.push(Command::Play);
            }
            if ui.button("Clear").clicked() {
                asked.revisions.push(Revision::Clear);
            }
        });
        ui.checkbox(&mut form.level, "level: keyframes at heights above the datum");
        let mut constant = board.pace == Pace::Constant;
        if ui.checkbox(&mut constant, "constant pace, in proportion to altitude").changed() {
            board.pace = if constant { Pace::Constant } else { Pace::Timed };
        }
        list(ui, board, asked);
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(&mut form.name).hint_text("name").desired_width(90.0));
            if ui.button("Save").on_hover_text("as JSON, beside the pictures").clicked() {
                asked.path = Some(PathWish::Save(form.name()));
            }
            if ui.button("Load").clicked() {
                asked.path = Some(PathWish::Load(form.name()));
            }
            if ui.button("Film").on_hover_text("an mp4 beside the pictures, drawn in the background").clicked() {
                asked.path = Some(PathWish::Film(form.name()));
            }
        });
    });
}

fn list(ui: &mut Ui, board: &Storyboard, asked: &mut Asked) {
    Grid::new("keyframes").num_columns(3).spacing([6.0, 2.0]).striped(true).show(ui, |ui| {
        for (at, keyframe) in board.keyframes().iter().enumerate() {
            let mut time_s = keyframe.time_s;
            if ui.add(DragValue::new(&mut time_s).speed(0.1).suffix(" s").max_decimals(1)).changed() {
                asked.revisions.push(Revision::Time(at, time_s));
            }
            if ui.link(words(keyframe)).on_hover_text("fly there").clicked() {
                asked.path = Some(PathWish::Visit(at));
            }
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                let mut button = |text: &str, hint: &str, revision: Revision| {
                    if ui.small_button(text).on_hover_text(hint).clicked() {
                        asked.revisions.push(revision);
                    }
                };
                button("⌖", "put it where the viewer is", Revision::Set(at));
                button("⬇", "exchange it with the next", Revision::Exchange(at));
                button("🗑", "take it away", Revision::Remove(at));
            });
            ui.end_row();
        }
    });
}

/// Where a keyframe is.
fn words(keyframe: &Keyframe) -> String {
    let stand = match keyframe.stand {
        Stand::Altitude(metres) => distance(metres),
        Stand::Height(metres) => format!("={}", distance(metres)),
    };
    format!("{:.2}, {:.2}  {stand}", keyframe.latitude, keyframe.longitude)
}
