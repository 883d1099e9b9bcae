//! What shading needs to know of planet, camera and sun.

use glam::DVec3;
use terrane_planet::layout::{Mode, Shading, NO_SEA};
use terrane_planet::recipe::Recipe;
use terrane_planet::view::{local_frame, Camera};

/// Scale heights of air that are worth marching through.
const AIR_SCALE_HEIGHTS: f64 = 10.0;

/// How a frame looks, apart from the view.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// What is drawn.
    pub mode: Mode,
    /// Unit vector towards the sun, planet-fixed.
    pub sun: DVec3,
    /// Factor from radiance to display.
    pub exposure: f32,
}

/// Factor from radiance to display for pictures in daylight.
pub const DAYLIGHT: f32 = 0.6;

/// The sun as seen from a place: degrees clockwise from north, and degrees above the horizon.
pub fn sun_over(place: DVec3, azimuth: f64, elevation: f64) -> DVec3 {
    let frame = local_frame(place);
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    (frame.y_axis * a.cos() + frame.x_axis * a.sin()) * e.cos() + frame.z_axis * e.sin()
}

/// Fills the shading block of a frame.
pub fn shading(recipe: &Recipe, camera: &Camera, look: &Look) -> Shading {
    let (h, v) = camera.half_extents();
    let vector = |d: DVec3| d.as_vec3().to_array();
    let colour = |c: [f64; 3]| c.map(|x| x as f32);
    let mut shading = Shading {
        // The shaders divide by its length.
        camera: vector(if camera.position.length() < 1.0 { local_frame(camera.position).z_axis } else { camera.position }),
        mode: look.mode as u32,
        sun: vector(look.sun),
        altitude: (camera.position.length() - recipe.radius) as f32,
        right: vector(camera.right() * h),
        radius: recipe.radius as f32,
        up: vector(camera.up * v),
        sea_level: NO_SEA,
        forward: vector(camera.forward),
        exposure: look.exposure,
        size: camera.size.map(|s| s as f32),
        ..Shading::default()
    };
    if let Some(sea) = &recipe.sea {
        shading.sea_level = sea.level_m as f32;
        shading.shallow = colour(sea.shallow);
        shading.deep = colour(sea.deep);
    }
    if let Some(air) = &recipe.atmosphere {
        shading.scale_height = air.scale_height_m as f32;
        shading.rayleigh = colour(air.rayleigh);
        shading.mie = air.mie as f32;
        shading.mie_scale_height = air.mie_scale_height_m as f32;
        shading.air_top = (air.scale_height_m * AIR_SCALE_HEIGHTS) as f32;
    }
    shading
}
