//! What is drawn and how finely: modes, tolerance, scale, and the frozen selection.

use super::super::choices::Choices;
use super::super::facts::Facts;
use super::super::keys::Command;
use super::super::pacing::Scale;
use super::Asked;
use egui::{CollapsingHeader, Slider, Ui};
use terrane_planet::draw::layout::Mode;
use terrane_planet::draw::view::TOLERANCE_RANGE;

/// The scales that can be chosen.
const SCALES: std::ops::RangeInclusive<f64> = 0.25..=1.0;

pub(super) fn show(ui: &mut Ui, facts: &Facts, choices: &mut Choices, asked: &mut Asked) {
    CollapsingHeader::new("Mesh").default_open(false).show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            for mode in Mode::ALL {
                ui.selectable_value(&mut choices.look.mode, *mode, mode.name());
            }
        });
        let (least, most) = TOLERANCE_RANGE;
        ui.add(Slider::new(&mut choices.tolerance, least..=most).logarithmic(true).suffix(" px").text("tolerance"));
        ui.checkbox(&mut choices.geomorphs, "geomorphs").on_hover_text("vertices slide into their positions instead of jumping");
        ui.checkbox(&mut choices.orientation, "errors as they are seen")
            .on_hover_text("fewer triangles where the ground is seen from above");
        let mut automatic = matches!(choices.scale, Scale::Within(_));
        if ui.checkbox(&mut automatic, "fewer pixels while moving, where that is needed").changed() {
            choices.scale = if automatic { choices.budget } else { Scale::Fixed(1.0) };
        }
        if let Scale::Fixed(density) = &mut choices.scale {
            ui.add(Slider::new(density, SCALES).text("scale"));
        }
        let words = if facts.frozen { "Thaw the selection" } else { "Freeze the selection" };
        if ui.button(words).on_hover_text("to look at its mesh from elsewhere").clicked() {
            asked.commands.push(Command::Freeze);
        }
    });
}
