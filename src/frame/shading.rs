//! What shading needs to know of planet, camera and sun.

use glam::DVec3;
use terrane_planet::draw::layout::{Mode, Shading, Tone, NO_SEA};
use terrane_planet::draw::meter;
use terrane_planet::draw::tone::Curve;
use terrane_planet::draw::view::{local_frame, View};
use terrane_planet::maps::waves::{total_variance, REPEAT_M};
use terrane_planet::recipe::{Atmosphere, Recipe};

/// Scale heights of air above the datum that are worth drawing: what is above would be less than a step of 8 bits at the limb.
const AIR_SCALE_HEIGHTS: f64 = 12.0;
/// Scale heights below the datum that air fills at most. Bounds of terrain are wide, and tables should not be spent on air that
/// nobody sees.
const DEEPEST_SCALE_HEIGHTS: f64 = 2.0;

/// What is taken from the sines of horizons where nothing casts shadows: no sun is so low.
const NO_HORIZON: f32 = 4.0;

/// How a frame looks, apart from the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// What is drawn.
    pub mode: Mode,
    /// Unit vector towards the sun, planet-fixed.
    pub sun: DVec3,
    /// Factor on the exposure that the light at the site below the camera asks for ([`meter::exposure`]).
    pub exposure: f32,
    /// The curve from exposed light to the display.
    pub tone: Tone,
    /// How far exposure by the picture itself goes to its goal in this frame, from 0 to 1; none: it counts for nothing.
    pub metering: Option<f32>,
    /// Whether clouds are drawn, and cast shadows, where the planet has any.
    pub clouds: bool,
    /// Whether the sea is drawn, or its floor in its place.
    pub sea: bool,
    /// Whether there is air.
    pub air: bool,
    /// Whether the relief casts shadows.
    pub shadows: bool,
}

impl Look {
    /// The shaded ground under its clouds, exposed for the light there. `sun` is the unit vector towards the sun.
    pub const fn daylight(sun: DVec3) -> Look {
        Look {
            mode: Mode::Shaded,
            sun,
            exposure: 1.0,
            tone: Tone::Neutral,
            metering: None,
            clouds: true,
            sea: true,
            air: true,
            shadows: true,
        }
    }
}

/// The sun as seen from a site: degrees clockwise from north, and degrees above the horizon.
pub fn sun_over(site: DVec3, azimuth: f64, elevation: f64) -> DVec3 {
    let frame = local_frame(site);
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    (frame.y_axis * a.cos() + frame.x_axis * a.sin()) * e.cos() + frame.z_axis * e.sin()
}

/// Where a sun stands as seen from a site, as [`sun_over`] takes it: degrees clockwise from north, from -180 to 180, and above the horizon.
pub fn sun_seen_from(site: DVec3, sun: DVec3) -> [f64; 2] {
    let frame = local_frame(site);
    let [east, north, up] = [frame.x_axis, frame.y_axis, frame.z_axis].map(|axis| sun.dot(axis));
    [east.atan2(north).to_degrees(), up.atan2(east.hypot(north)).to_degrees()]
}

/// Fills the shading block of a frame; `lowest` is the height of the lowest ground above the datum in metres.
pub fn shading(recipe: &Recipe, lowest: f64, view: &View, look: &Look) -> Shading {
    let (camera, [left, top], [width, height]) = (&view.camera, view.window.origin, view.window.size);
    let (h, v) = camera.half_extents();
    let vector = |d: DVec3| d.as_vec3().to_array();
    let colour = |c: [f64; 3]| c.map(|x| x as f32);
    let frame = local_frame(camera.position);
    let sunward = look.sun.reject_from_normalized(frame.z_axis).try_normalize().unwrap_or(frame.x_axis);
    let pixels = |pixels: u32| (f64::from(pixels) * view.density) as f32;
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
        exposure: look.exposure * meter::exposure(recipe, camera.position, look.sun) as f32,
        tone: look.tone as u32,
        bend: Curve::new(look.tone, recipe.white).bend,
        vertical: vector(frame.z_axis),
        sunward: vector(sunward),
        adaptation: look.metering.unwrap_or(-1.0),
        size: camera.size.map(pixels),
        window: [left, top, width, height].map(pixels),
        anchor: camera.position.to_array().map(|x| x.rem_euclid(REPEAT_M) as f32),
        sea_variance: total_variance() as f32,
        horizon_drop: if look.shadows { 0.0 } else { NO_HORIZON },
        ..Shading::default()
    };
    if let (Some(sea), true) = (&recipe.sea, look.sea) {
        shading.sea_level = sea.level_m as f32;
        shading.shallow = colour(sea.shallow);
        shading.deep = colour(sea.deep);
    }
    if let (Some(clouds), true) = (&recipe.clouds, look.clouds) {
        shading.cloud_height = clouds.height_m as f32;
        shading.cloud_depth = clouds.optical_depth as f32;
    }
    if let (Some(air), true) = (&recipe.atmosphere, look.air) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use terrane_planet::draw::layout::{LUMINANCE, NIGHT, SUN};
    use terrane_planet::recipe::shipped;
    use terrane_planet::reference::air::Air;

    #[test]
    fn suns_are_seen_where_they_were_put() {
        for (azimuth, elevation) in [(10.0, 35.0), (-120.0, -4.5), (179.0, 80.0)] {
            let site = DVec3::new(0.3, -0.5, 0.8).normalize();
            let [found, height] = sun_seen_from(site, sun_over(site, azimuth, elevation));
            assert!((found - azimuth).abs() < 1e-9 && (height - elevation).abs() < 1e-9, "{found} {height}");
        }
    }

    /// Irradiance of sun and sky on a level card, by brute force.
    fn irradiance(air: &Air, radius: f64, elevation: f64) -> f64 {
        let (site, sun) = (DVec3::Z * radius, DVec3::new(elevation.cos(), 0.0, elevation.sin()));
        let luminance = |c: DVec3| c.dot(DVec3::from_array(LUMINANCE.map(f64::from)));
        let mut light = SUN * elevation.sin() * luminance(air.before(site, sun, f64::INFINITY, sun).1);
        for layer in 0..12 {
            for turn in 0..24 {
                let (z, azimuth) = (((f64::from(layer) + 0.5) / 12.0).sqrt(), PI * (f64::from(turn) + 0.5) / 12.0);
                let ray = DVec3::new((1.0 - z * z).sqrt() * azimuth.cos(), (1.0 - z * z).sqrt() * azimuth.sin(), z);
                light += PI / 288.0 * luminance(air.before(site, ray, f64::INFINITY, sun).0);
            }
        }
        light - luminance(DVec3::from_array(NIGHT))
    }

    #[test]
    fn the_meter_knows_the_light_of_sun_and_sky() {
        for name in ["terra", "mars", "tiny"] {
            let recipe = shipped::load(name).unwrap();
            let mut block = Shading { radius: recipe.radius as f32, sea_level: NO_SEA, ..Shading::default() };
            if let Some(sea) = &recipe.sea {
                block.sea_level = sea.level_m as f32;
            }
            add_air(&mut block, recipe.atmosphere.as_ref().unwrap(), 0.0);
            let air = Air::new(&block).unwrap();
            for degrees in [12.0f64, 20.0, 45.0, 90.0] {
                let expected = irradiance(&air, recipe.radius, degrees.to_radians());
                let found = meter::irradiance(&recipe, degrees.to_radians().sin());
                println!("{name} {degrees}: {found:.3}, {expected:.3}, {:.3}", found / expected);
                assert!((found / expected - 1.0).abs() < 0.07, "{name} at {degrees} degrees: {found}, by brute force {expected}");
            }
        }
    }
}
