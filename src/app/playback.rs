//! A camera path that the window plays, and what its frames cost.

use crate::frame::{sun_over, sun_seen_from};
use glam::DVec3;
use std::time::{Duration, Instant};
use terrane_planet::draw::camera_path::{CameraPath, Carried, Waypoint};

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
    /// Where the sun goes with the camera.
    sun: Option<Carried>,
    begun: Option<Instant>,
    /// Whether a frame has shown its end.
    arrived: bool,
}

impl Playback {
    /// Begins with the next frame.
    pub(super) fn new(path: CameraPath, stand: Option<Duration>) -> Playback {
        Playback { path, stand, sun: None, begun: None, arrived: false }
    }

    /// Lets a sun, as it is seen from a site now, go with the camera if the path leads so far that it would set.
    pub(super) fn lit(mut self, site: DVec3, sun: DVec3) -> Playback {
        let [azimuth, elevation] = sun_seen_from(site, sun);
        let over_end = || sun_over(self.path.at(self.path.span().1).up, azimuth, elevation);
        self.sun = self.path.leads_round().then(|| self.path.carry(over_end()));
        self
    }

    /// Where the sun stands, if it goes with the camera.
    pub(super) fn sun(&self, waypoint: &Waypoint) -> Option<DVec3> {
        self.sun.as_ref().map(|sun| sun.at(waypoint.time_s))
    }

    fn seconds(&self) -> f64 {
        let (first, last) = self.path.span();
        last - first
    }

    /// Where the viewer is at a time, until they have come to the end, however late the frame is that shows it.
    pub(super) fn at(&mut self, now: Instant) -> Option<Waypoint> {
        let passed = now.duration_since(*self.begun.get_or_insert(now)).as_secs_f64();
        let arrives = passed >= self.seconds();
        let has_arrived = std::mem::replace(&mut self.arrived, arrives);
        (!has_arrived).then(|| self.path.at(self.path.span().0 + passed))
    }

    /// Whether a frame is to come that shows the viewer elsewhere.
    pub(super) fn is_moving(&self) -> bool {
        !self.arrived
    }

    /// Whether its frames are reported.
    pub(super) fn is_reported(&self) -> bool {
        self.stand.is_some()
    }

    /// Whether nothing comes after its end, and it has come there.
    pub(super) fn is_over(&self) -> bool {
        self.stand.is_none() && self.arrived
    }

    /// When the window closes by itself.
    pub(super) fn closes(&self) -> Option<Instant> {
        Some(self.begun? + Duration::from_secs_f64(self.seconds()) + self.stand?)
    }
}
