//! Where the viewer is, how they move, and where they can go.

use super::super::facts::Facts;
use super::super::keys::Command;
use super::super::viewer::Manner;
use super::numbers::{distance, site};
use super::Asked;
use egui::{CollapsingHeader, Grid, Slider, Ui};

pub(super) fn show(ui: &mut Ui, facts: &Facts, asked: &mut Asked) {
    CollapsingHeader::new("Position").default_open(true).show(ui, |ui| {
        Grid::new("position").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
            let mut row = |name: &str, value: String| {
                ui.weak(name);
                ui.label(value);
                ui.end_row();
            };
            row("at", site(facts.site));
            row("height", format!("{} above the datum", distance(facts.height_m)));
            row("altitude", distance(facts.altitude_m));
            row("ground", facts.ground_m.map_or("not known".to_owned(), distance));
            row("look", format!("{:.1}° from north, {:.1}° up", facts.look[0].rem_euclid(360.0), facts.look[1]));
        });
        ui.horizontal_wrapped(|ui| {
            let mut button = |name: &str, on: bool, command: Command, hint: &str| {
                if ui.add_enabled(on, egui::Button::new(name)).on_hover_text(hint).clicked() {
                    asked.commands.push(command);
                }
            };
            button("Go to…", true, Command::GoTo, "latitude and longitude, or a view");
            button("Home", true, Command::Home, "where the window began");
            button("⬅", facts.places[0], Command::Back, "the place before");
            button("➡", facts.places[1], Command::Forward, "the place after");
            button("North", true, Command::North, "turn towards north");
            button("Horizon", true, Command::Horizon, "look at the horizon");
            button("Copy view", true, Command::CopyView, "as a line of text");
        });
        ui.horizontal(|ui| {
            for manner in Manner::ALL {
                if ui.selectable_label(facts.manner == manner, manner.name()).clicked() {
                    asked.manner = Some(manner);
                }
            }
        });
        let mut speed = facts.speed;
        if facts.manner != Manner::Orbit
            && ui.add(Slider::new(&mut speed, 0.01..=100.0).logarithmic(true).text("speed")).changed()
        {
            asked.speed = Some(speed);
        }
        let mut fov = facts.fov;
        if ui.add(Slider::new(&mut fov, 10.0..=120.0).suffix("°").text("field of view")).changed() {
            asked.fov = Some(fov);
        }
    });
}
