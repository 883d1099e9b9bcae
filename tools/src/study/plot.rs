//! The plot of the study: error against faces, both logarithmic, a line a cost; the largest errors on the left, the root mean
//! square ones on the right. SVG by hand: it has nothing but lines and words.

use super::Series;
use std::fmt::Write as _;
use terrane_planet::classic::Cost;
use terrane_planet::heightfield::Deviation;

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
    let [width, height] = SIZE;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    );
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
        self.left + PANEL[0] * (faces / FACES[0]).ln() / (FACES[1] / FACES[0]).ln()
    }

    fn y(error: f64) -> f64 {
        TOP + PANEL[1] * (ERRORS[1] / error).ln() / (ERRORS[1] / ERRORS[0]).ln()
    }

    fn axes(&self, svg: &mut String, title: &str) {
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
        _ = writeln!(svg, "<text x=\"{left:.1}\" y=\"{:.1}\" font-size=\"15\" font-weight=\"bold\">{title}</text>", TOP - 14.0);
    }

    /// A line as long as it stays on the axes, with dots at the pictured meshes.
    fn line(&self, svg: &mut String, series: &Series, error: Measure) {
        let within = |[low, high]: [f64; 2], value: f64| (low..=high).contains(&value);
        let seen = |&(faces, error): &(usize, f64)| within(FACES, faces as f64) && within(ERRORS, error);
        let points = series.line.iter().map(|(faces, deviation)| (*faces, error(deviation)));
        let points: Vec<String> =
            points.filter(seen).map(|(faces, error)| format!("{:.1},{:.1}", self.x(faces as f64), Panel::y(error))).collect();
        let color = color(series.cost);
        _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2.2\" stroke-linejoin=\"round\"/>",
            points.join(" ")
        );
        let dots = series.pictured.iter().map(|sample| (sample.surface.faces.len(), error(&sample.deviation)));
        for (faces, error) in dots.filter(seen) {
            let (x, y) = (self.x(faces as f64), Panel::y(error));
            _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\" fill=\"{color}\"/>");
        }
    }
}

fn legend(svg: &mut String, all: &[Series]) {
    label(svg, [SIZE[0] - 36.0, SIZE[1] - 14.0], "end", "errors in sample spacings; dots: the meshes of the contact sheet");
    for (place, series) in all.iter().enumerate() {
        let x = LEFTS[0] + 120.0 * place as f64;
        let (y, color) = (SIZE[1] - 18.0, color(series.cost));
        _ = writeln!(svg, "<path d=\"M{x:.1} {y:.1}h26\" stroke=\"{color}\" stroke-width=\"2.2\"/>");
        _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"3.6\" fill=\"{color}\"/>", x + 13.0);
        label(svg, [x + 33.0, y + 4.5], "start", series.cost.name());
    }
}

fn rule(svg: &mut String, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], color: &str) {
    _ = writeln!(svg, "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>");
}

fn label(svg: &mut String, [x, y]: [f64; 2], anchor: &str, text: &str) {
    _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>");
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
