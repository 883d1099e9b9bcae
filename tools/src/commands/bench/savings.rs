//! What each of selection's economies saves: the frames of a path with one of them left out at a time, and with the orientation
//! term, which is not on by itself.

use serde_json::{json, Value};
use terrane::measure::FrameCost;
use terrane_planet::draw::view::View;
use terrane_planet::planet::Planet;

/// A change of a view of a planet.
pub(super) type Change = fn(View, &Planet) -> View;

/// The frames to compare, by what differs; first those as they are.
pub(super) const VARIANTS: [(&str, Change); 4] = [
    ("as drawn", |view, _| view),
    ("without frustum falloff", |view, _| view.without_falloff()),
    ("without horizon culling", |view, _| view.without_horizon()),
    ("with orientation term", |view, planet| view.with_orientation(planet.ground_radius())),
];

/// A quantity, and how it is found; `None` where a frame lacks it.
type Quantity = (&'static str, fn(&FrameCost) -> Option<f64>);

const QUANTITIES: [Quantity; 7] = [
    ("patches", |c| Some(c.patches as f64)),
    ("awake vertices", |c| Some(f64::from(c.awake))),
    ("prefix vertices", |c| Some(f64::from(c.prefix_vertices))),
    ("candidate triangles", |c| Some(f64::from(c.candidate_triangles))),
    ("triangles", |c| Some(f64::from(c.triangles))),
    ("mesh stages ms", FrameCost::mesh_ms),
    ("frame ms", |c| Some(c.frame_ms)),
];

/// Mean over the frames that have it, and the largest change of any frame against the frames as they are, in per cent.
fn mean_and_change(value: fn(&FrameCost) -> Option<f64>, costs: &[FrameCost], plain: &[FrameCost]) -> (f64, f64) {
    let known: Vec<f64> = costs.iter().filter_map(value).collect();
    let changes = costs.iter().zip(plain).filter_map(|(c, p)| Some(100.0 * (value(c)? / value(p)? - 1.0)));
    let largest = changes.filter(|c| c.is_finite()).fold(0.0, |most: f64, c| if c.abs() > most.abs() { c } else { most });
    (known.iter().sum::<f64>() / known.len().max(1) as f64, largest)
}

/// Prints means over the path, with their change and the largest change in any frame. `costs` are those of [`VARIANTS`].
pub(super) fn print(costs: &[Vec<FrameCost>]) {
    println!("\nmean over the path (change; largest change in a frame)");
    for (name, value) in QUANTITIES {
        println!("{name}");
        let (base, _) = mean_and_change(value, &costs[0], &costs[0]);
        for ((variant, _), frames) in VARIANTS.iter().zip(costs) {
            let (mean, largest) = mean_and_change(value, frames, &costs[0]);
            let change = 100.0 * (mean / base - 1.0);
            println!("    {variant:<26} {mean:>12.1} {change:>+8.1} % {largest:>+8.1} %");
        }
    }
}

/// The same as JSON.
pub(super) fn report(costs: &[Vec<FrameCost>]) -> Value {
    let of = |frames: &[FrameCost]| -> Value {
        let entry = |(name, value): &Quantity| {
            let (mean, largest) = mean_and_change(*value, frames, &costs[0]);
            ((*name).to_owned(), json!({ "mean": mean, "largest_change_percent": largest }))
        };
        QUANTITIES.iter().map(entry).collect::<serde_json::Map<_, _>>().into()
    };
    VARIANTS
        .iter()
        .zip(costs)
        .map(|((name, _), frames)| ((*name).to_owned(), of(frames)))
        .collect::<serde_json::Map<_, _>>()
        .into()
}
