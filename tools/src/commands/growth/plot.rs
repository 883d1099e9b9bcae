//! The plot of a growth: milliseconds of the mesh stages against awake vertices, both logarithmic.

use super::fit::Fit;
use super::Point;
use crate::svg::{self, dot, label, logarithmic, polyline, rule, title};
use terrane::frame::Stage;

const SIZE: [f64; 2] = [720.0, 480.0];

/// Left, right, top and bottom of the diagram.
const FRAME: [f64; 4] = [70.0, 560.0, 52.0, 420.0];

/// Colors of the three stages and of their sum (Okabe and Ito 2008).
const COLORS: [&str; 4] = ["#0072b2", "#009e73", "#d55e00", "#222"];

/// Draws the plot; at least one point.
pub(super) fn draw(points: &[Point], fit: &Fit) -> String {
    let [left, right, top, bottom] = FRAME;
    let counts = decades(points.iter().map(Point::awake));
    let times = decades(points.iter().flat_map(|p| p.stages.into_iter().chain([p.mesh_ms()])));
    let point = |[count, ms]: [f64; 2]| [logarithmic(count, counts, [left, right]), logarithmic(ms, times, [bottom, top])];
    let mut svg = svg::open(SIZE);
    title(&mut svg, [left, top - 18.0], "Cost of selection against what is awake");
    for count in powers(counts) {
        let [x, _] = point([count, times[0]]);
        rule(&mut svg, [x, top], [x, bottom], "#e3e1da");
        label(&mut svg, [x, bottom + 18.0], "middle", &in_words(count));
    }
    for ms in powers(times) {
        let [_, y] = point([counts[0], ms]);
        rule(&mut svg, [left, y], [right, y], "#e3e1da");
        label(&mut svg, [left - 7.0, y + 4.5], "end", &ms.to_string());
    }
    rule(&mut svg, [left, bottom], [right, bottom], "#444");
    rule(&mut svg, [left, top], [left, bottom], "#444");
    label(&mut svg, [(left + right) / 2.0, bottom + 38.0], "middle", "awake vertices");
    label(&mut svg, [left - 7.0, top - 8.0], "end", "ms");
    let names = Stage::MESH.iter().map(|stage| stage.name()).chain(["together"]);
    for (k, (name, color)) in names.zip(COLORS).enumerate() {
        let ms = |p: &Point| p.stages.get(k).copied().unwrap_or_else(|| p.mesh_ms());
        let line: Vec<[f64; 2]> = points.iter().map(|p| point([p.awake(), ms(p)])).collect();
        line.iter().for_each(|&at| dot(&mut svg, at, color));
        if let Some([x, y]) = line.last() {
            label(&mut svg, [x + 12.0, y + 4.5], "start", name);
        }
        polyline(&mut svg, line, color);
    }
    let line = format!("{:.2} ms + {:.1} ns for each, within {:.0} %", fit.constant_ms, 1e6 * fit.ms_each, 100.0 * fit.deviation);
    label(&mut svg, [left + 14.0, top + 20.0], "start", &format!("together: {line}"));
    svg.push_str("</svg>\n");
    svg
}

/// The powers of ten around some positive values.
fn decades(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
    [10f64.powf(low.log10().floor()), 10f64.powf(high.log10().ceil())]
}

/// The powers of ten of an axis.
fn powers([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (low.log10().round() as i32..=high.log10().round() as i32).map(|k| 10f64.powi(k))
}

/// A power of ten as people write it.
fn in_words(count: f64) -> String {
    match count {
        c if c >= 1e6 => format!("{} M", c / 1e6),
        c if c >= 1e3 => format!("{} k", c / 1e3),
        c => c.to_string(),
    }
}
