//! What the plots share: lines, words and logarithmic axes, as SVG on a white ground.

use std::fmt::Write as _;

/// Opens a picture.
pub(crate) fn open([width, height]: [f64; 2]) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#222\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n"
    )
}

/// A straight line.
pub(crate) fn rule(svg: &mut String, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], color: &str) {
    _ = writeln!(svg, "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>");
}

/// Words whose `anchor` (start, middle or end) is at a position.
pub(crate) fn label(svg: &mut String, [x, y]: [f64; 2], anchor: &str, text: &str) {
    _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>");
}

/// A title over a panel.
pub(crate) fn title(svg: &mut String, [x, y]: [f64; 2], text: &str) {
    _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"15\" font-weight=\"bold\">{text}</text>");
}

/// A line through points.
pub(crate) fn polyline(svg: &mut String, points: impl IntoIterator<Item = [f64; 2]>, color: &str) {
    let points: Vec<String> = points.into_iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2.2\" stroke-linejoin=\"round\"/>",
        points.join(" ")
    );
}

/// A dot.
pub(crate) fn dot(svg: &mut String, [x, y]: [f64; 2], color: &str) {
    _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\" fill=\"{color}\"/>");
}

/// Where a value stands between two positions on a logarithmic axis.
pub(crate) fn logarithmic(value: f64, [low, high]: [f64; 2], [from, to]: [f64; 2]) -> f64 {
    from + (to - from) * (value / low).ln() / (high / low).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithmic_axes_begin_and_end_at_their_positions() {
        let at = |value: f64| logarithmic(value, [0.01, 100.0], [300.0, 100.0]);
        assert_eq!([at(0.01), at(1.0), at(100.0)], [300.0, 200.0, 100.0]);
    }
}
