//! What the overlay says: one line of numbers, and below it what is out of the ordinary.

use super::keys::HELP;
use std::fmt::Write;
use std::time::{Duration, Instant};
use terrane_planet::draw::layout::{EmitState, Mode};

/// How long a message stays.
const MESSAGE_TIME: Duration = Duration::from_secs(5);
/// Weight of the latest second in the frame rate.
const RATE_RESPONSE: f64 = 2.0;

/// State of the overlay.
#[derive(Default)]
pub(super) struct Overlay {
    /// Whether the help is shown.
    pub(super) help: bool,
    /// Seconds a frame takes, smoothed.
    frame_seconds: f64,
    message: Option<(String, Instant)>,
}

/// What the overlay reports.
pub(super) struct Status<'a> {
    /// Metres above ground or sea.
    pub(super) altitude_m: f64,
    /// Counters of a frame that is done.
    pub(super) counters: EmitState,
    /// Patches drawn.
    pub(super) patches: usize,
    /// Patches asked for that are not there yet.
    pub(super) pending: usize,
    /// Bytes that patches take on the GPU, and in main memory; of each also the most they may take.
    pub(super) bytes: [(u64, u64); 2],
    /// Bytes of everything on the GPU.
    pub(super) allocated: u64,
    /// Pixels drawn along a side for each of the window's.
    pub(super) density: f64,
    /// Name of the device.
    pub(super) device: &'a str,
    /// Whether the view is in free flight.
    pub(super) flying: bool,
    /// Whether vertices slide into their positions.
    pub(super) geomorphs: bool,
    /// Whether the selection is frozen.
    pub(super) frozen: bool,
    /// What is drawn.
    pub(super) mode: Mode,
}

impl Overlay {
    /// Says something for a while.
    pub(super) fn say(&mut self, message: String) {
        self.message = Some((message, Instant::now()));
    }

    /// Counts a frame into the frame rate.
    pub(super) fn count_frame(&mut self, seconds: f64) {
        let weight = if self.frame_seconds == 0.0 { 1.0 } else { 1.0 - (-RATE_RESPONSE * seconds).exp() };
        self.frame_seconds += (seconds - self.frame_seconds) * weight;
    }

    /// When the message is to vanish.
    pub(super) fn vanishes(&self) -> Option<Instant> {
        self.message.as_ref().map(|(_, since)| *since + MESSAGE_TIME)
    }

    /// The text to draw.
    pub(super) fn text(&mut self, status: &Status<'_>) -> String {
        let rate = if self.frame_seconds > 0.0 { 1.0 / self.frame_seconds } else { 0.0 };
        let rate = if rate < 9.95 { format!("{rate:.1}") } else { format!("{rate:.0}") };
        let mut text = format!(
            "{}  {rate} fps  {} triangles  {} awake vertices  {} patches, {} pending\nGPU {} for patches, {} MB in all  host {}  {}\n",
            distance(status.altitude_m),
            count(status.counters.wanted),
            count(status.counters.awake),
            status.patches,
            status.pending,
            megabytes(status.bytes[0]),
            status.allocated / 1_000_000,
            megabytes(status.bytes[1]),
            // What follows in brackets is about the driver.
            status.device.split(" (").next().unwrap_or_default()
        );
        let states = [
            (status.mode != Mode::Shaded, status.mode.name()),
            (status.flying, "free flight"),
            (!status.geomorphs, "no geomorphs"),
            (status.frozen, "selection frozen: Z thaws it"),
            (status.counters.wanted > status.counters.capacity, "more triangles than fit: some are missing"),
        ];
        let scale = format!("scale {}", status.density);
        let states = states.into_iter().chain([(status.density < 1.0, scale.as_str())]);
        let states: Vec<&str> = states.filter_map(|(on, text)| on.then_some(text)).collect();
        let _ = writeln!(text, "{}", states.join(", "));
        if self.message.as_ref().is_some_and(|(_, since)| since.elapsed() >= MESSAGE_TIME) {
            self.message = None;
        }
        if let Some((message, _)) = &self.message {
            let _ = writeln!(text, "{message}");
        }
        if self.help {
            text += HELP;
        }
        text
    }
}

fn distance(metres: f64) -> String {
    match metres {
        m if m < 100.0 => format!("{m:.1} m"),
        m if m < 10e3 => format!("{m:.0} m"),
        m if m < 1000e3 => format!("{:.1} km", m / 1e3),
        m => format!("{:.0} km", m / 1e3),
    }
}

/// Bytes taken of those allowed, in megabytes.
fn megabytes((taken, most): (u64, u64)) -> String {
    format!("{} of {} MB", taken / 1_000_000, most / 1_000_000)
}

fn count(number: u32) -> String {
    match number {
        n if n < 10_000 => n.to_string(),
        n if n < 1_000_000 => format!("{:.0} k", f64::from(n) / 1e3),
        n => format!("{:.2} M", f64::from(n) / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let distances = [1.94, 1234.4, 56_780.0, 2e7].map(distance);
        assert_eq!(distances, ["1.9 m", "1234 m", "56.8 km", "20000 km"]);
        assert_eq!([9_999, 123_456, 2_345_678].map(count), ["9999", "123 k", "2.35 M"]);
    }

    #[test]
    fn the_frame_rate_settles_on_that_of_the_frames() {
        let mut overlay = Overlay::default();
        overlay.count_frame(1.0);
        (0..600).for_each(|_| overlay.count_frame(1.0 / 60.0));
        assert!((overlay.frame_seconds * 60.0 - 1.0).abs() < 1e-3);
    }
}
