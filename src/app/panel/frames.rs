//! What frames cost: a graph of their times, percentiles, GPU milliseconds by stage, and what they draw.

use super::super::facts::Facts;
use super::numbers::{count, rate};
use egui::{pos2, vec2, CollapsingHeader, Color32, Grid, ProgressBar, Rect, Sense, Stroke, Ui};
use std::collections::VecDeque;

/// Frames that the graph shows.
const SHOWN: usize = 240;
/// Weight of the latest second in the frame rate.
const RATE_RESPONSE: f64 = 2.0;
/// Height of the graph, and of the bars of levels, in points.
const GRAPH: f32 = 48.0;
const BARS: f32 = 30.0;

/// Times of the latest frames.
#[derive(Default)]
pub(super) struct FrameTimes {
    seconds: VecDeque<f64>,
    smoothed: f64,
}

impl FrameTimes {
    pub(super) fn count(&mut self, seconds: f64) {
        if self.seconds.len() == SHOWN {
            self.seconds.pop_front();
        }
        self.seconds.push_back(seconds);
        let weight = if self.smoothed == 0.0 { 1.0 } else { 1.0 - (-RATE_RESPONSE * seconds).exp() };
        self.smoothed += (seconds - self.smoothed) * weight;
    }

    /// Seconds a frame takes, smoothed.
    pub(super) fn smoothed(&self) -> f64 {
        self.smoothed
    }

    /// The times that so many of a hundred frames keep to, in milliseconds.
    fn percentiles(&self, percents: [usize; 3]) -> [f64; 3] {
        let mut sorted: Vec<f64> = self.seconds.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        percents.map(|percent| {
            sorted.get((sorted.len() * percent / 100).min(sorted.len().saturating_sub(1))).map_or(0.0, |s| s * 1e3)
        })
    }
}

pub(super) fn show(ui: &mut Ui, facts: &Facts, times: &FrameTimes) {
    CollapsingHeader::new("Frames").default_open(true).show(ui, |ui| {
        graph(ui, times);
        let [p50, p95, p99] = times.percentiles([50, 95, 99]);
        ui.label(format!("{}   p50 {p50:.1}  p95 {p95:.1}  p99 {p99:.1} ms", rate(times.smoothed())));
        // What follows in brackets is about the driver.
        ui.weak(facts.device.split(" (").next().unwrap_or_default());
        ui.collapsing("GPU time by stage", |ui| stages(ui, facts));
        Grid::new("mesh").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
            let mut row = |name: &str, value: String| {
                ui.weak(name);
                ui.label(value);
                ui.end_row();
            };
            row("triangles", count(facts.counters.wanted));
            row("vertices awake", format!("{} of {} in prefixes", count(facts.counters.awake), count(facts.prefix_vertices)));
            row("patches", format!("{} drawn, {} to come", facts.patches(), facts.pending));
            row("since it opened", format!("{} read, {} built", facts.read, facts.built));
        });
        levels(ui, facts);
        for (name, (taken, most)) in ["GPU, patches", "host, patches"].into_iter().zip(facts.bytes) {
            let share = taken as f32 / most.max(1) as f32;
            let text = format!("{name}: {} of {} MB", taken / 1_000_000, most / 1_000_000);
            ui.add(ProgressBar::new(share).desired_height(14.0).text(egui::RichText::new(text).small()));
        }
        ui.weak(format!("GPU, everything: {} MB", facts.allocated / 1_000_000));
    });
}

/// A bar a frame, in colours of how it compares with the median.
fn graph(ui: &mut Ui, times: &FrameTimes) {
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), GRAPH), Sense::hover());
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(120));
    let [p50, _, p99] = times.percentiles([50, 95, 99]);
    let most = (1.3 * p99).max(2.0 * p50).max(1.0);
    let step = area.width() / SHOWN as f32;
    for (at, seconds) in times.seconds.iter().enumerate() {
        let ms = seconds * 1e3;
        let height = GRAPH * (ms / most).min(1.0) as f32;
        let colour = if ms > 2.0 * p50 { Color32::from_rgb(240, 110, 90) } else { Color32::from_rgb(120, 190, 255) };
        let left = area.left() + step * at as f32;
        painter.rect_filled(
            Rect::from_min_max(pos2(left, area.bottom() - height), pos2(left + step.max(1.0), area.bottom())),
            0.0,
            colour,
        );
    }
    let y = area.bottom() - GRAPH * (p50 / most) as f32;
    painter.line_segment([pos2(area.left(), y), pos2(area.right(), y)], Stroke::new(1.0, Color32::from_white_alpha(90)));
}

fn stages(ui: &mut Ui, facts: &Facts) {
    Grid::new("stages").num_columns(2).spacing([10.0, 0.0]).show(ui, |ui| {
        let whole: f64 = facts.stages.iter().filter_map(|(_, ms)| *ms).sum();
        for (stage, ms) in facts.stages.iter() {
            if let Some(ms) = ms {
                ui.weak(stage.name());
                ui.monospace(format!("{ms:>8.2} ms"));
                ui.end_row();
            }
        }
        ui.strong("all");
        ui.monospace(format!("{whole:>8.2} ms"));
        ui.end_row();
    });
}

/// A bar for each level that is drawn.
fn levels(ui: &mut Ui, facts: &Facts) {
    let Some(most) = facts.levels.iter().max().filter(|most| **most > 0) else { return };
    ui.weak("patches by level");
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), BARS + 14.0), Sense::hover());
    let painter = ui.painter_at(area);
    let step = area.width() / facts.levels.len().max(8) as f32;
    for (level, number) in facts.levels.iter().enumerate() {
        let height = BARS * *number as f32 / *most as f32;
        let (left, bottom) = (area.left() + step * level as f32, area.top() + BARS);
        painter.rect_filled(
            Rect::from_min_max(pos2(left + 1.0, bottom - height), pos2(left + step - 1.0, bottom)),
            1.0,
            Color32::from_rgb(150, 170, 120),
        );
        let font = egui::FontId::proportional(9.0);
        painter.text(pos2(left + 0.5 * step, bottom + 1.0), egui::Align2::CENTER_TOP, level.to_string(), font, Color32::GRAY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_rate_settles_on_that_of_the_frames() {
        let mut times = FrameTimes::default();
        times.count(1.0);
        (0..600).for_each(|_| times.count(1.0 / 60.0));
        assert!((times.smoothed() * 60.0 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn percentiles_are_of_the_frames_that_are_shown() {
        let mut times = FrameTimes::default();
        assert_eq!(times.percentiles([50, 95, 99]), [0.0; 3]);
        (0..1000).for_each(|_| times.count(5.0));
        (1..=SHOWN).for_each(|k| times.count(k as f64 * 1e-3));
        assert_eq!(times.percentiles([0, 50, 100]).map(|ms| ms.round()), [1.0, 121.0, 240.0]);
    }
}
