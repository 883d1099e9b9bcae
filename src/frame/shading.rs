//! What shading needs to know of planet, camera and sun.

use glam::DVec3;
use terrane_planet::draw::layout::{Mode, Shading, NO_SEA};
use terrane_planet::draw::view::{local_frame, View};
use terrane_planet::maps::waves::{total_variance, REPEAT_M};
use terrane_planet::recipe::{Atmosphere, Recipe};

/// Scale heights of air above the datum that are worth drawing: what is above would be less than a step of 8 bits at the limb.
const AIR_SCALE_HEIGHTS: f64 = 12.0;
/// Scale heights below the datum that air fills at most. Bounds of terrain are wide, and tables should not be spent on air that
/// nobody sees.
const DEEPEST_SCALE_HEIGHTS: f64 = 2.0;

/// How a frame looks, apart from the view.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// What is drawn.
    pub mode: Mode,
    /// Unit vector towards the sun, planet-fixed.
    pub sun: DVec3,
    /// Factor from radiance to display; where exposure is metered, a factor on what the meter says.
    pub exposure: f32,
    /// How far metered exposure goes to its goal in this frame, from 0 to 1; none where exposure is fixed.
    pub metering: Option<f32>,
    /// Whether clouds are drawn, and cast shadows, where the planet has any.
    pub clouds: bool,
}

/// Factor from radiance to display for pictures in daylight.
pub const DAYLIGHT: f32 = 1.1;

impl Look {
    /// The shaded ground under its clouds, exposed for daylight. `sun` is the unit vector towards the sun.
    pub const fn daylight(sun: DVec3) -> Look {
        Look { mode: Mode::Shaded, sun, exposure: DAYLIGHT, metering: None, clouds: true }
    }
}

/// The sun as seen from a site: degrees clockwise from north, and degrees above the horizon.
pub fn sun_over(site: DVec3, azimuth: f64, elevation: f64) -> DVec3 {
    let frame = local_frame(site);
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    (frame.y_axis * a.cos() + frame.x_axis * a.sin()) * e.cos() + frame.z_axis * e.sin()
}

/// Fills the shading block of a frame; `lowest` is the height of the lowest ground above the datum in metres.
pub fn shading(recipe: &Recipe, lowest: f64, view: &View, look: &Look) -> Shading {
    let (camera, [left, top], [width, height]) = (&view.camera, view.window.origin, view.window.size);
    let (h, v) = camera.half_extents();
    let vector = |d: DVec3| d.as_vec3().to_array();
    let colour = |c: [f64; 3]| c.map(|x| x as f32);
    let frame = local_frame(camera.position);
    let sunward = look.sun.reject_from_normalized(frame.z_axis).try_normalize().unwrap_or(frame.x_axis);
    let mut shading = Shading {
        // The shaders divide by its length.
        camera: vector(if camera.position.length() < 1.0 { local_frame(camera.position).z_axis } else { camera.position }),
        mode: look.mode as u32,
        sun: vector(look.sun),
        height_m: (camera.position.length() - recipe.radius) as f32,
        right: vector(camera.right() * h),
        radius: recipe.radius as f32,
        up: vector(camera.up * v),
        sea_level: NO_SEA,
        forward: vector(camera.forward),
        exposure: look.exposure,
        vertical: vector(frame.z_axis),
        sunward: vector(sunward),
        adaptation: look.metering.unwrap_or(-1.0),
        size: camera.size.map(|s| s as f32),
        window: [left, top, width, height].map(|s| s as f32),
        anchor: camera.position.to_array().map(|x| x.rem_euclid(REPEAT_M) as f32),
        sea_variance: total_variance() as f32,
        ..Shading::default()
    };
    if let Some(sea) = &recipe.sea {
        shading.sea_level = sea.level_m as f32;
        shading.shallow = colour(sea.shallow);
        shading.deep = colour(sea.deep);
    }
    if let (Some(clouds), true) = (&recipe.clouds, look.clouds) {
        shading.cloud_height = clouds.height_m as f32;
        shading.cloud_depth = clouds.optical_depth as f32;
    }
    if let Some(air) = &recipe.atmosphere {
        add_air(&mut shading, air, lowest);
    }
    shading
}

/// The air, over ground that is nowhere lower than `lowest` metres above the datum.
fn add_air(shading: &mut Shading, air: &Atmosphere, lowest: f64) {
    let colour = |c: [f64; 3]| c.map(|x| x as f32);
    let sea = if shading.sea_level > NO_SEA { f64::from(shading.sea_level) } else { lowest };
    let ozone_top = if air.ozone == [0.0; 3] { 0.0 } else { air.ozone_height_m + 0.5 * air.ozone_width_m };
    shading.scale_height = air.scale_height_m as f32;
    shading.rayleigh = colour(air.rayleigh);
    shading.mie_scale_height = air.mie_scale_height_m as f32;
    shading.mie = colour(air.mie);
    shading.mie_g = air.mie_g as f32;
    shading.mie_extinction = [0, 1, 2].map(|k| (air.mie[k] + air.mie_absorption[k]) as f32);
    shading.ozone = colour(air.ozone);
    shading.ozone_height = air.ozone_height_m as f32;
    shading.ozone_reach = (0.5 * air.ozone_width_m) as f32;
    shading.air_bottom = sea.max(-DEEPEST_SCALE_HEIGHTS * air.scale_height_m) as f32;
    shading.air_top = (AIR_SCALE_HEIGHTS * air.scale_height_m.max(air.mie_scale_height_m)).max(ozone_top) as f32;
    shading.ground_albedo = air.ground_albedo as f32;
    let (bottom, top) = (f64::from(shading.air_bottom), f64::from(shading.air_top));
    let eye = f64::from(shading.height_m).clamp(bottom, top) - bottom;
    let lowest = f64::from(shading.radius) + bottom;
    shading.horizon = -((eye * (2.0 * lowest + eye)).sqrt() / (lowest + eye)).asin() as f32;
}
