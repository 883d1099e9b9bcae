//! The tool that changes the ground, and what becomes of it.

use super::super::earthwork::{words, Tool, Work};
use super::super::facts::Facts;
use super::super::keys::Command;
use super::Asked;
use egui::{Button, CollapsingHeader, Slider, Ui};

/// Metres that the tool digs or heaps up at most, as a share of its radius.
const STEEPEST: f64 = 1.0;

pub(super) fn show(ui: &mut Ui, facts: &Facts, tool: &mut Tool, asked: &mut Asked) {
    CollapsingHeader::new("Ground").default_open(false).show(ui, |ui| {
        ui.checkbox(&mut tool.held, "a click changes the ground");
        ui.horizontal(|ui| {
            for work in Work::ALL {
                ui.selectable_value(&mut tool.work, work, work.name());
            }
        });
        let radii = Tool::radii(facts.radius_m);
        ui.add(Slider::new(&mut tool.radius_m, radii).logarithmic(true).max_decimals(0).suffix(" m").text("radius"));
        let depths = 0.5..=(STEEPEST * tool.radius_m).max(1.0);
        let depth = Slider::new(&mut tool.depth_m, depths).logarithmic(true).max_decimals(1).suffix(" m").text("depth");
        ui.add_enabled(tool.work != Work::Flatten, depth);
        ui.horizontal(|ui| {
            let mut button = |name: &str, number: usize, command: Command| {
                let on = number > 0 && !facts.edits.is_busy();
                if ui.add_enabled(on, Button::new(format!("{name} ({number})"))).clicked() {
                    asked.commands.push(command);
                }
            };
            button("Undo", facts.edits.undoable, Command::Undo);
            button("Redo", facts.edits.redoable, Command::Redo);
        });
        if let Some(words) = words(&facts.edits) {
            ui.label(words);
        } else if let Some(latest) = facts.edits.latest {
            ui.weak(format!("the ground had changed after {:.2} s", latest.as_secs_f64()));
        }
    });
}
