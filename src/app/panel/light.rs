//! Light and what it meets: sun, exposure, tone, and the layers of the picture that can be left out.

use super::super::calendar::{parse_clock, parse_day, Moment, MINUTES, YEARS};
use super::super::choices::Choices;
use super::super::facts::Facts;
use crate::frame::{sun_over, sun_seen_from};
use egui::{CollapsingHeader, DragValue, Slider, SliderClamping, Ui};
use glam::DVec3;
use terrane_planet::draw::layout::Tone;
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::globe::sun;

/// Cosine of the angle within which the sun stands where it was put.
const THERE: f64 = 1.0 - 1e-9;

/// The sun by date and time of day, as over the Earth with a planet's axial tilt.
fn by_date(ui: &mut Ui, tilt: f64, date: &mut Option<i64>, sun: &mut DVec3) {
    let mut moment = date.map_or_else(Moment::now, Moment::of);
    let before = moment;
    let days = Slider::new(&mut moment.day, 1..=before.days())
        .custom_formatter(|day, _| Moment { day: day as u16, ..before }.day_name())
        .custom_parser(|text| parse_day(before.year, text).map(f64::from));
    let mut changed = ui.add(days.text("date")).changed();
    let minutes = Slider::new(&mut moment.minute, 0..=MINUTES - 1)
        .custom_formatter(|minute, _| Moment { minute: minute as u16, ..before }.clock())
        .custom_parser(|text| parse_clock(text).map(f64::from));
    changed |= ui.add(minutes.text("UTC")).changed();
    ui.horizontal(|ui| {
        changed |= ui.add(DragValue::new(&mut moment.year).range(YEARS).prefix("year ")).changed();
        if ui.button("Now").clicked() {
            (moment, changed) = (Moment::now(), true);
        }
    });
    if changed {
        *date = Some(moment.seconds());
        *sun = sun::direction(moment.seconds() as f64, tilt);
    }
    if date.is_none_or(|seconds| sun::direction(seconds as f64, tilt).dot(*sun) < THERE) {
        ui.weak("the sun stands where it was put, not by the date");
    }
}

pub(super) fn show(ui: &mut Ui, facts: &Facts, choices: &mut Choices) {
    let look = &mut choices.look;
    CollapsingHeader::new("Light").default_open(false).show(ui, |ui| {
        let below = direction_at(facts.site[0], facts.site[1]);
        let [mut azimuth, mut elevation] = sun_seen_from(below, look.sun);
        let turned = ui.add(Slider::new(&mut azimuth, -180.0..=180.0).suffix("°").text("sun from north")).changed();
        let raised = ui.add(Slider::new(&mut elevation, -90.0..=90.0).suffix("°").text("sun's height")).changed();
        if turned || raised {
            look.sun = sun_over(below, azimuth, elevation);
            choices.date = None;
        }
        by_date(ui, facts.tilt, &mut choices.date, &mut look.sun);
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
