//! The plot of the study: error against faces, both logarithmic, a line a cost; the largest errors on the left, the root mean
//! square ones on the right. SVG by hand: it has nothing but lines and words.

use super::Series;
use crate::svg::{self, dot, label, logarithmic, polyline, rule, title};
use std::fmt::Write as _;
use terrane_heightfield::classic::Cost;
use terrane_heightfield::Deviation;

/// Least and greatest faces of the axis.
const FACES: [f64; 2] = [8.0, 3300.0];

/// Least and greatest error of the axis, in sample spacings. Lines end where they leave it: at the full mesh all errors are 0.
const ERRORS: [f64; 2] = [0.002, 12.0];

/// Width and height of one panel.
const PANEL: [f64; 2] = [400.0, 340.0];

/// Left sides of the panels, and their top.
const LEFTS: [f64; 2] = [64.0, 524.0];
const TOP: f64 = 64.0;

const SIZE: [f64; 2] = [960.0, 486.0];

/// Color of a cost: three that most color-blind readers can tell apart (Okabe and Ito 2008).
fn color(cost: Cost) -> &'static str {
    match cost {
        Cost::Certified => "#0072b2",
        Cost::Quadric => "#d55e00",
        Cost::Spring => "#009e73",
    }
}

/// Which error a panel shows.
type Measure = fn(&Deviation) -> f64;

/// Draws the plot.
pub(crate) fn draw(all: &[Series]) -> String {
    let mut svg = svg::open(SIZE);
    let panels: [(&str, Measure); 2] = [("Largest error", |d| d.max), ("Root mean square error", |d| d.rms)];
    for (left, (title, error)) in LEFTS.into_iter().zip(panels) {
        let panel = Panel { left };
        panel.axes(&mut svg, title);
        for series in all {
            panel.line(&mut svg, series, error);
        }
    }
    legend(&mut svg, all);
    svg.push_str("</svg>\n");
    svg
}

/// One diagram.
struct Panel {
    left: f64,
}

impl Panel {
    fn x(&self, faces: f64) -> f64 {
        logarithmic(faces, FACES, [self.left, self.left + PANEL[0]])
    }

    fn y(error: f64) -> f64 {
        logarithmic(error, ERRORS, [TOP + PANEL[1], TOP])
    }

    fn axes(&self, svg: &mut String, name: &str) {
        let (left, right, bottom) = (self.left, self.left + PANEL[0], TOP + PANEL[1]);
        for faces in [10, 30, 100, 300, 1000, 3000] {
            let x = self.x(f64::from(faces));
            rule(svg, [x, TOP], [x, bottom], "#e3e1da");
            label(svg, [x, bottom + 18.0], "middle", &faces.to_string());
        }
        for error in [0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0] {
            let y = Panel::y(error);
            rule(svg, [left, y], [right, y], "#e3e1da");
            label(svg, [left - 7.0, y + 4.5], "end", &error.to_string());
        }
        rule(svg, [left, bottom], [right, bottom], "#444");
        rule(svg, [left, TOP], [left, bottom], "#444");
        label(svg, [(left + right) / 2.0, bottom + 38.0], "middle", "faces");
        title(svg, [left, TOP - 14.0], name);
    }

    /// A line as long as it stays on the axes, with dots at the pictured meshes.
    fn line(&self, svg: &mut String, series: &Series, error: Measure) {
        let within = |[low, high]: [f64; 2], value: f64| (low..=high).contains(&value);
        let seen = |&(faces, error): &(usize, f64)| within(FACES, faces as f64) && within(ERRORS, error);
        let points = series.line.iter().map(|(faces, deviation)| (*faces, error(deviation)));
        let color = color(series.cost);
        let point = |(faces, error): (usize, f64)| [self.x(faces as f64), Panel::y(error)];
        polyline(svg, points.filter(seen).map(point), color);
        let dots = series.pictured.iter().map(|sample| (sample.surface.faces.len(), error(&sample.deviation)));
        dots.filter(seen).for_each(|sample| dot(svg, point(sample), color));
    }
}

fn legend(svg: &mut String, all: &[Series]) {
    label(svg, [SIZE[0] - 36.0, SIZE[1] - 14.0], "end", "errors in sample spacings; dots: the meshes of the contact sheet");
    for (index, series) in all.iter().enumerate() {
        let x = LEFTS[0] + 120.0 * index as f64;
        let (y, color) = (SIZE[1] - 18.0, color(series.cost));
        _ = writeln!(svg, "<path d=\"M{x:.1} {y:.1}h26\" stroke=\"{color}\" stroke-width=\"2.2\"/>");
        dot(svg, [x + 13.0, y], color);
        label(svg, [x + 33.0, y + 4.5], "start", series.cost.name());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_begin_and_end_at_the_panel_and_rise_upwards() {
        let panel = Panel { left: LEFTS[1] };
        assert_eq!([panel.x(FACES[0]), panel.x(FACES[1])], [LEFTS[1], LEFTS[1] + PANEL[0]]);
        assert_eq!([Panel::y(ERRORS[1]), Panel::y(ERRORS[0])], [TOP, TOP + PANEL[1]]);
        assert!(Panel::y(1.0) < Panel::y(0.1));
    }
}
