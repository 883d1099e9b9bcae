//! A straight line through times that span orders of magnitude.

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fit {
    /// Most over least count.
    pub(super) factor: f64,
    /// Milliseconds that any count costs.
    pub(super) constant_ms: f64,
    /// Milliseconds for each one more.
    pub(super) ms_each: f64,
    /// Largest deviation of a time from the line, as a share of the line.
    pub(super) deviation: f64,
    /// Slope of the line through the logarithms.
    pub(super) exponent: f64,
}

/// Fits a line of least relative squares to (count, milliseconds), all positive; `None` if there are fewer than two counts.
pub(super) fn fit(points: &[[f64; 2]]) -> Option<Fit> {
    // Divided by their times, all points ask for 1: constant · (1 / ms) + each · (count / ms) = 1.
    let scaled = points.iter().map(|&[count, ms]| [1.0 / ms, count / ms]);
    let sums = scaled.fold([0.0; 5], |s, [x, y]| [s[0] + x * x, s[1] + x * y, s[2] + y * y, s[3] + x, s[4] + y]);
    let [xx, xy, yy, x, y] = sums;
    let determinant = xx * yy - xy * xy;
    let counts = points.iter().map(|p| p[0]);
    let (least, most) = counts.fold((f64::INFINITY, 0.0f64), |(low, high), c| (low.min(c), high.max(c)));
    if least >= most || determinant <= 0.0 {
        return None;
    }
    let (constant_ms, ms_each) = ((x * yy - y * xy) / determinant, (y * xx - x * xy) / determinant);
    let deviation = points.iter().map(|&[count, ms]| (ms / (constant_ms + ms_each * count) - 1.0).abs()).fold(0.0, f64::max);
    Some(Fit { factor: most / least, constant_ms, ms_each, deviation, exponent: exponent(points) })
}

fn exponent(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let mean = |k: usize| logs.iter().map(|l| l[k]).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let over = logs.iter().map(|l| (l[0] - x) * (l[1] - y)).sum::<f64>();
    over / logs.iter().map(|l| (l[0] - x) * (l[0] - x)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_found_and_curves_deviate() {
        let counts = [10.0, 100.0, 1e3, 1e4, 1e5];
        let line = fit(&counts.map(|n| [n, 0.25 + 3e-4 * n])).unwrap();
        assert!(
            (line.constant_ms - 0.25).abs() < 1e-9 && (line.ms_each - 3e-4).abs() < 1e-12 && line.deviation < 1e-9,
            "{line:?}"
        );
        assert!((line.factor - 1e4).abs() < 1e-6);
        let square = fit(&counts.map(|n| [n, 1e-6 * n * n])).unwrap();
        assert!((square.exponent - 2.0).abs() < 1e-9 && square.deviation > 0.5, "{square:?}");
    }

    #[test]
    fn one_count_has_no_growth() {
        assert_eq!(fit(&[[5.0, 1.0], [5.0, 1.1]]), None);
    }
}
