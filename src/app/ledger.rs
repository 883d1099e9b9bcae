//! What the frames of a window cost: of each that is done, for the pace; and, where it was asked for, a row each.

use super::pacing::Cost;
use super::playback::FlyFrame;
use crate::frame::PerStage;
use crate::vulkan::{Timestamps, FRAMES_IN_FLIGHT};
use std::time::Instant;

/// Longest time between the end of a frame on the CPU and the beginning of the next for the two to follow at once, in milliseconds.
const AT_ONCE_MS: f64 = 3.0;

/// A frame on its way.
#[derive(Clone, Copy)]
struct Sent {
    density: f64,
    cpu_ms: f64,
}

/// The books of a window.
#[derive(Default)]
pub(super) struct Ledger {
    sent: [Option<Sent>; FRAMES_IN_FLIGHT],
    /// When the frame before began, and when the CPU was done with it.
    before: Option<(Instant, Instant)>,
    /// The row of each frame.
    pub(super) rows: Vec<FlyFrame>,
    allocations: u64,
}

impl Ledger {
    /// A frame begins at `now`, in a slot whose earlier frame is done and took such times on the GPU. What that frame cost.
    pub(super) fn settle(&mut self, slot: usize, times: &Timestamps, now: Instant) -> Option<Cost> {
        let sent = self.sent[slot].take()?;
        let stages = PerStage::gpu_ms(times);
        let sum = |pixels: bool| -> f64 {
            stages.iter().filter(|(s, _)| s.works_on_pixels() == pixels).filter_map(|(_, ms)| *ms).sum()
        };
        let (pixels_ms, rest) = (sum(true), sum(false) + sent.cpu_ms);
        // What no stage counts, such as the work on vertices of software renderers, shows in how frames follow one another.
        let interval = self.before.filter(|(_, done)| milliseconds(*done, now) < AT_ONCE_MS + pixels_ms + rest);
        let fixed_ms = interval.map_or(rest, |(begun, _)| rest.max(milliseconds(begun, now) - pixels_ms));
        Some(Cost { density: sent.density, pixels_ms, fixed_ms })
    }

    /// A frame that began at `row.time_s` seconds after the first was recorded, and is on its way. `acquired` is when it began.
    pub(super) fn send(&mut self, slot: usize, acquired: Instant, allocations: u64, row: Option<FlyFrame>, density: f64) {
        let now = Instant::now();
        let cpu_ms = milliseconds(acquired, now);
        self.sent[slot] = Some(Sent { density, cpu_ms });
        if let Some(row) = row {
            let interval_ms = self.before.map_or(0.0, |(begun, _)| milliseconds(begun, acquired));
            self.rows.push(FlyFrame { interval_ms, cpu_ms, allocations: allocations - self.allocations, ..row });
        }
        (self.before, self.allocations) = (Some((acquired, now)), allocations);
    }
}

fn milliseconds(from: Instant, to: Instant) -> f64 {
    to.saturating_duration_since(from).as_secs_f64() * 1e3
}
