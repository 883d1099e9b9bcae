//! A camera path that the window plays, and what its frames cost.

use std::time::{Duration, Instant};
use terrane_planet::draw::camera_path::{CameraPath, Waypoint};

/// A frame of the window, as it was shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlyFrame {
    /// Seconds since the first frame.
    pub time_s: f64,
    /// Milliseconds since the frame before.
    pub interval_ms: f64,
    /// Milliseconds of the CPU for everything but waiting.
    pub cpu_ms: f64,
    /// Whether the viewer moved.
    pub moving: bool,
    /// Pixels drawn along a side for each of the window's.
    pub density: f64,
    /// Patches drawn.
    pub patches: usize,
    /// Patches on their way.
    pub pending: usize,
    /// Allocations of GPU memory since the frame before.
    pub allocations: u64,
}

/// A path that is being played, and how long the viewer stands at its end before the window closes; for ever if `None`.
pub(super) struct Playback {
    path: CameraPath,
    stand: Option<Duration>,
    begun: Option<Instant>,
}

impl Playback {
    /// Begins with the next frame.
    pub(super) fn new(path: CameraPath, stand: Option<Duration>) -> Playback {
        Playback { path, stand, begun: None }
    }

    fn seconds(&self) -> f64 {
        let (first, last) = self.path.span();
        last - first
    }

    /// Where the viewer is at a time, while they move.
    pub(super) fn at(&mut self, now: Instant) -> Option<Waypoint> {
        let fresh = self.begun.is_none();
        let passed = now.duration_since(*self.begun.get_or_insert(now)).as_secs_f64();
        let moves = fresh || self.is_moving(now);
        moves.then(|| self.path.at(self.path.span().0 + passed))
    }

    /// Whether the path goes on.
    pub(super) fn is_moving(&self, now: Instant) -> bool {
        self.begun.is_none_or(|begun| now.duration_since(begun).as_secs_f64() < self.seconds())
    }

    /// When the window closes by itself.
    pub(super) fn closes(&self) -> Option<Instant> {
        Some(self.begun? + Duration::from_secs_f64(self.seconds()) + self.stand?)
    }
}
