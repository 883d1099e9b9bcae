//! Percentiles of what the frames of a path cost.

use hdrhistogram::Histogram;
use terrane::frame::Stage;
use terrane::measure::FrameCost;

/// A quantity of a frame; `None` where a frame lacks it.
type Value = Box<dyn Fn(&FrameCost) -> Option<f64>>;

/// Largest value that histograms hold, in units of the last digit (microseconds for times); larger ones count as this.
const LARGEST: u64 = 600_000_000;

/// Percentiles of one quantity: 50, 95, 99 and the largest.
pub(super) struct Line {
    pub(super) name: String,
    /// Digits after the point that count.
    pub(super) digits: usize,
    pub(super) at: [f64; 4],
    pub(super) frames: usize,
}

/// A quantity of a frame; `None` where a frame lacks it.
struct Quantity {
    name: String,
    digits: usize,
    value: Value,
}

fn quantities() -> Vec<Quantity> {
    let sure = |name: &str, digits: usize, value: fn(&FrameCost) -> f64| Quantity {
        name: name.to_owned(),
        digits,
        value: Box::new(move |c| Some(value(c))),
    };
    let stage = |stage: Stage| Quantity {
        name: format!("gpu {} ms", stage.name()),
        digits: 3,
        value: Box::new(move |c| c.stages_ms[stage]),
    };
    let share = |c: &FrameCost| Some(100.0 * c.mesh_ms()? / c.frame_ms);
    let mut all = vec![
        sure("cpu cut ms", 3, |c| c.cut_ms),
        sure("cpu tables ms", 3, |c| c.tables_ms),
        sure("cpu record ms", 3, |c| c.record_ms),
    ];
    all.extend(Stage::ALL.map(stage));
    all.extend([
        sure("gpu wall ms", 3, |c| c.gpu_wall_ms),
        sure("frame ms", 3, |c| c.frame_ms),
        Quantity { name: "mesh stages %".to_owned(), digits: 1, value: Box::new(share) },
        sure("settle ms (apart)", 3, |c| c.settle_ms),
        sure("triangles", 0, |c| f64::from(c.triangles)),
        sure("awake vertices", 0, |c| f64::from(c.awake)),
        sure("prefix vertices", 0, |c| f64::from(c.prefix_vertices)),
        sure("candidate triangles", 0, |c| f64::from(c.candidate_triangles)),
        sure("prefix / awake", 2, |c| f64::from(c.prefix_vertices) / f64::from(c.awake.max(1))),
        sure("candidates / drawn", 2, |c| f64::from(c.candidate_triangles) / f64::from(c.triangles.max(1))),
        sure("patches", 0, |c| c.patches as f64),
        sure("resident patches", 0, |c| c.resident as f64),
    ]);
    all
}

/// Percentiles of all quantities, to three significant digits.
pub(super) fn summarise(costs: &[FrameCost]) -> anyhow::Result<Vec<Line>> {
    let mut lines = Vec::new();
    for Quantity { name, digits, value } in quantities() {
        let scale = 10f64.powi(digits as i32);
        let mut histogram = Histogram::<u64>::new_with_bounds(1, LARGEST, 3)?;
        for value in costs.iter().filter_map(value) {
            histogram.saturating_record((value * scale).round() as u64);
        }
        let at = [0.50, 0.95, 0.99, 1.0].map(|q| histogram.value_at_quantile(q) as f64 / scale);
        lines.push(Line { name, digits, at, frames: histogram.len() as usize });
    }
    Ok(lines)
}
