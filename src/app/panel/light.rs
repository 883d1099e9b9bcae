//! Light and what it meets: sun, exposure, tone, and the layers of the picture that can be left out.

use super::super::choices::Choices;
use super::super::facts::Facts;
use crate::frame::{sun_over, sun_seen_from};
use egui::{CollapsingHeader, Slider, SliderClamping, Ui};
use terrane_planet::draw::layout::Tone;
use terrane_planet::globe::sphere::direction_at;

pub(super) fn show(ui: &mut Ui, facts: &Facts, choices: &mut Choices) {
    let look = &mut choices.look;
    CollapsingHeader::new("Light").default_open(false).show(ui, |ui| {
        let below = direction_at(facts.site[0], facts.site[1]);
        let [mut azimuth, mut elevation] = sun_seen_from(below, look.sun);
        let turned = ui.add(Slider::new(&mut azimuth, -180.0..=180.0).suffix("°").text("sun from north")).changed();
        let raised = ui.add(Slider::new(&mut elevation, -90.0..=90.0).suffix("°").text("sun's height")).changed();
        if turned || raised {
            look.sun = sun_over(below, azimuth, elevation);
        }
        let mut metered = look.metering.is_some();
        if ui.checkbox(&mut metered, "exposure by the picture too").changed() {
            look.metering = metered.then_some(0.0);
        }
        ui.add(Slider::new(&mut look.exposure, 0.05..=20.0).clamping(SliderClamping::Edits).logarithmic(true).text("exposure"));
        ui.horizontal(|ui| {
            for tone in Tone::ALL {
                ui.selectable_value(&mut look.tone, tone, tone.name());
            }
        });
        let [air, sea, clouds] = facts.has;
        ui.horizontal_wrapped(|ui| {
            ui.add_enabled(clouds, egui::Checkbox::new(&mut look.clouds, "clouds"));
            ui.add_enabled(sea, egui::Checkbox::new(&mut look.sea, "sea"));
            ui.add_enabled(air, egui::Checkbox::new(&mut look.air, "air"));
            ui.checkbox(&mut look.shadows, "shadows");
        });
    });
}
