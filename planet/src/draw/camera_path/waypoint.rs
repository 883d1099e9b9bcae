//! Where a camera is on its path: a place, a level direction and a pitch, none of which has a pole. In: a path, or a keyframe. Out: what
//! a planet makes cameras of, or a keyframe again.

use super::{leg, Keyframe};
use crate::draw::view::local_frame;
use crate::draw::view_line::Stand;
use crate::globe::sphere::{direction_at, latitude_longitude};
use glam::DVec3;

/// Where a camera is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Seconds, as its path counts them.
    pub time_s: f64,
    /// Unit direction from the planet's centre.
    pub up: DVec3,
    /// How far above the planet.
    pub stand: Stand,
    /// Level unit vector towards where the camera faces; across `up`, even if the camera looks straight down.
    pub ahead: DVec3,
    /// Degrees above the horizontal, -90 to 90.
    pub pitch: f64,
    /// Vertical field of view in degrees, 7 to 140.
    pub fov: f64,
}

impl Waypoint {
    /// That of a keyframe. At a pole north is where the keyframe's longitude has it.
    pub fn of(keyframe: &Keyframe) -> Waypoint {
        // Longitudes and headings that differ by whole turns give the same bits.
        let [longitude, heading] = [keyframe.longitude, keyframe.heading].map(short_way);
        let up = direction_at(keyframe.latitude, longitude).normalize();
        let (sine, cosine) = longitude.to_radians().sin_cos();
        let east = DVec3::new(-sine, cosine, 0.0);
        let (sine, cosine) = heading.to_radians().sin_cos();
        let ahead = leg::level(up.cross(east) * cosine + east * sine, up);
        let Keyframe { time_s, stand, pitch, fov, .. } = *keyframe;
        Waypoint { time_s, up, stand, ahead, pitch, fov }
    }

    /// The keyframe that stands here, its longitude and heading within -180 and 180 degrees.
    pub fn keyframe(&self) -> Keyframe {
        let (latitude, longitude) = latitude_longitude(self.up);
        let frame = local_frame(self.up);
        let heading = self.ahead.dot(frame.x_axis).atan2(self.ahead.dot(frame.y_axis)).to_degrees();
        let Waypoint { time_s, stand, pitch, fov, .. } = *self;
        Keyframe { time_s, latitude, longitude, stand, heading, pitch, fov }
    }

    /// Unit view direction, and the unit vector to the top of the picture.
    pub fn facing(&self) -> (DVec3, DVec3) {
        let (sine, cosine) = self.pitch.to_radians().sin_cos();
        let forward = self.ahead * cosine + self.up * sine;
        let top = self.up * cosine - self.ahead * sine;
        (forward.normalize(), top.normalize())
    }
}

/// An angle in degrees within -180 and 180.
fn short_way(angle: f64) -> f64 {
    angle - 360.0 * (angle / 360.0).round()
}
