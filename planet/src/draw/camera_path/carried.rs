//! A direction that goes along with a camera: the sun of a path that leads round the planet, which would else see half of it by night. In: a
//! path and a direction at its end. Out: the direction at any time.

use super::CameraPath;
use glam::{DQuat, DVec3};

/// Degrees over the ground from a path's end beyond which it leads round the planet.
const FAR: f64 = 40.0;

/// Steps in which a path is followed.
const STEPS: usize = 2048;

/// A direction carried along a path: seen from below the camera it keeps its elevation, and turns only as the ground does.
#[derive(Clone, Debug)]
pub struct Carried {
    span: (f64, f64),
    directions: Vec<DVec3>,
}

impl CameraPath {
    /// A unit direction at the path's end, carried back along the way over the ground (parallel transport).
    pub fn carry(&self, direction: DVec3) -> Carried {
        let ups = self.ups();
        let mut directions = vec![direction];
        for pair in ups.windows(2).rev() {
            let last = directions[directions.len() - 1];
            directions.push(DQuat::from_rotation_arc(pair[1], pair[0]) * last);
        }
        directions.reverse();
        Carried { span: self.span(), directions }
    }

    /// Whether the path leads so far round the planet that a sun over its end would be low or set somewhere on the way.
    pub fn leads_round(&self) -> bool {
        self.reach().to_degrees() > FAR
    }

    /// The largest angle over the ground between the path's end and where it comes by, in radians.
    pub fn reach(&self) -> f64 {
        let end = self.at(self.span().1).up;
        self.ups().iter().map(|up| up.angle_between(end)).fold(0.0, f64::max)
    }

    fn ups(&self) -> Vec<DVec3> {
        let (first, last) = self.span();
        (0..=STEPS).map(|k| self.at(first + (last - first) * (k as f64 / STEPS as f64)).up).collect()
    }
}

impl Carried {
    /// The unit direction at a time; times outside the span are those of its ends.
    pub fn at(&self, time_s: f64) -> DVec3 {
        let (first, last) = self.span;
        let step = ((time_s - first) / (last - first)).clamp(0.0, 1.0) * STEPS as f64;
        let from = (step as usize).min(STEPS - 1);
        self.directions[from].lerp(self.directions[from + 1], step - from as f64).normalize()
    }
}
