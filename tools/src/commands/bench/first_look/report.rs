//! First looks as tables and as JSON.

use super::{Picture, Sight, Turn, Usage};
use serde_json::{json, Value};
use terrane_planet::draw::view_line::Stand;

/// A row of what was measured.
pub(super) enum Row<'a> {
    /// A picture whose patches were built.
    Nothing(&'a Sight, Picture),
    /// The same once more, its patches read.
    File(&'a Sight, Picture),
    /// The same over a line.
    Line(&'a Sight, Picture),
    /// A turn on the spot.
    Turn(&'a Sight, Turn),
}

/// Prints the tables, of pictures and of turns.
pub(super) fn print(rows: &[Row]) {
    println!(
        "| view | | drawn | resident | built | surveyed | triangles | CPU s | first picture s | settled s | GPU MB of patches | \
         GPU MB | peak host MB |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for row in rows {
        match row {
            Row::Nothing(sight, picture) => print_picture(sight, "from nothing", picture),
            Row::File(sight, picture) => print_picture(sight, "from the file", picture),
            Row::Line(sight, picture) => print_picture(sight, "over the line", picture),
            Row::Turn(..) => {}
        }
    }
    println!(
        "\n| turn by 90° | surroundings after s | resident | built | holes | cracks | flipped | settled again s | CPU s | GPU MB of \
         patches | GPU MB | peak host MB |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for row in rows {
        if let Row::Turn(sight, turn) = row {
            print_turn(sight, turn);
        }
    }
}

fn print_picture(sight: &Sight, row: &str, p: &Picture) {
    let (cpu_s, peak) = (or_dash(p.usage.cpu_s, 1), or_dash(p.usage.peak_bytes.map(megabytes), 0));
    println!(
        "| {} | {row} | {} | {} | {} | {} | {} | {cpu_s} | {:.2} | {:.2} | {:.0} | {:.0} | {peak} |",
        sight.name,
        p.drawn,
        p.resident,
        p.built,
        p.surveyed,
        p.triangles,
        p.first_s,
        p.settled_s,
        megabytes(p.gpu_bytes),
        megabytes(p.allocated_bytes)
    );
}

fn print_turn(sight: &Sight, t: &Turn) {
    let (cpu_s, peak) = (or_dash(t.usage.cpu_s, 1), or_dash(t.usage.peak_bytes.map(megabytes), 0));
    let more_than = if t.surrounded { "" } else { "> " };
    println!(
        "| {} | {more_than}{:.1} | {} | {} | {} | {} | {} | {:.2} | {cpu_s} | {:.0} | {:.0} | {peak} |",
        sight.name,
        t.surroundings_s,
        t.resident,
        t.built,
        t.faults.holes,
        t.faults.cracks,
        t.faults.flipped,
        t.settled_s,
        megabytes(t.gpu_bytes),
        megabytes(t.allocated_bytes)
    );
}

impl Row<'_> {
    /// The row with its view; what the system does not say is null.
    pub(super) fn json(&self) -> Value {
        match self {
            Row::Nothing(sight, picture) => described(sight, "from nothing", picture_json(picture), &picture.usage),
            Row::File(sight, picture) => described(sight, "from the file", picture_json(picture), &picture.usage),
            Row::Line(sight, picture) => described(sight, "over the line", picture_json(picture), &picture.usage),
            Row::Turn(sight, turn) => described(sight, "turn", turn_json(turn), &turn.usage),
        }
    }
}

fn described(sight: &Sight, row: &str, mut value: Value, usage: &Usage) -> Value {
    let k = &sight.keyframe;
    let (Stand::Altitude(altitude_m) | Stand::Height(altitude_m)) = k.stand;
    value["view"] = json!({
        "name": sight.name, "latitude": k.latitude, "longitude": k.longitude, "altitude_m": altitude_m,
        "heading": k.heading, "pitch": k.pitch, "fov": k.fov,
    });
    value["row"] = row.into();
    value["cpu_s"] = usage.cpu_s.into();
    value["process_peak_bytes"] = usage.peak_bytes.into();
    value["process_bytes_before"] = usage.bytes_before.into();
    value
}

fn picture_json(p: &Picture) -> Value {
    json!({
        "patches": p.drawn, "resident_patches": p.resident, "patches_built": p.built, "patches_surveyed": p.surveyed,
        "triangles": p.triangles, "first_picture_ms": 1e3 * p.first_s, "settled_ms": 1e3 * p.settled_s,
        "patch_bytes_on_gpu": p.gpu_bytes, "allocated_bytes": p.allocated_bytes,
    })
}

fn turn_json(t: &Turn) -> Value {
    json!({
        "surroundings_s": t.surroundings_s, "surrounded": t.surrounded, "resident_patches": t.resident, "patches_built": t.built,
        "holes": t.faults.holes, "cracks": t.faults.cracks, "flipped": t.faults.flipped, "settled_at_once": t.settled_at_once,
        "settled_ms": 1e3 * t.settled_s, "patch_bytes_on_gpu": t.gpu_bytes, "allocated_bytes": t.allocated_bytes,
    })
}

fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}
