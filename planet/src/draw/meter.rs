//! An incident-light meter: how pictures are exposed. In: a recipe, the camera's position, the sun. Out: the factor from radiance to
//! what the tone curve takes.
//!
//! What counts is the light that falls on a level card on the ground below the camera, not what the picture shows: so a picture's parts
//! agree with the whole, dark ground stays dark and bright ground bright, and nothing has to adapt.

use super::layout::{LUMINANCE, SUN, SUN_RADIUS};
use crate::recipe::{Atmosphere, Recipe};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Irradiance below which the meter no longer follows, as a share of the sun's outside the air: that of a sun of some 18 degrees. Evenings
/// are darker than noon, and nights are dark.
const DUSK: f64 = 0.25;
/// Of the best lit level ground in sight, the share of irradiance below which the meter no longer follows: from high above a dark site
/// the day beyond the terminator must not burn out.
const IN_SIGHT: f64 = 0.4;
/// Power of the mean that joins the card and both floors without a bend: the largest of them counts almost alone.
const JOIN: i32 = 6;

/// Factor from radiance to the light of a level card of reflectance 1 below the camera at `position` (from the planet's centre, in
/// metres); `sun` is the unit vector towards the sun. A card of reflectance 0.18 comes out at 0.18 unless it is dusk or night.
pub fn exposure(recipe: &Recipe, position: DVec3, sun: DVec3) -> f64 {
    let sine = position.normalize_or(DVec3::Z).dot(sun);
    let level = recipe.radius + recipe.ground_or_sea(0.0);
    // How far down the horizon lies, and so by how much higher the sun stands where the best lit ground in sight is.
    let dip = (level / position.length().max(level)).acos();
    let best = (sine.clamp(-1.0, 1.0).asin() + dip).min(FRAC_PI_2).sin();
    let floors = [DUSK * SUN, IN_SIGHT * irradiance(recipe, best), irradiance(recipe, sine)];
    PI / floors.map(|light| light.powi(JOIN)).into_iter().sum::<f64>().powf(1.0 / f64::from(JOIN))
}

/// Luminance of the light of sun and sky on a level card at the level of the sea or the datum, where the sun's elevation has sine
/// `sine`, in the units of [`SUN`]. Within 7 % of what the air's model says (shipped recipes, the sun at least
/// twelve degrees high).
pub fn irradiance(recipe: &Recipe, sine: f64) -> f64 {
    let risen = ((sine + SUN_RADIUS) / (2.0 * SUN_RADIUS)).clamp(0.0, 1.0);
    let level = sine.max(0.0) * risen;
    let passed = recipe.atmosphere.as_ref().map_or(1.0, |air| {
        let shares = transmission(air, recipe.radius, recipe.ground_or_sea(0.0), sine.max(0.0));
        shares.iter().zip(LUMINANCE).map(|(share, weight)| share * f64::from(weight)).sum()
    });
    SUN * level * passed
}

/// Shares of sunlight that arrive on level ground at a height above the datum, scattered or not, for red, green and blue: Eddington's
/// approximation for a layer that scatters (Shettle and Weinman 1970), with forward peaks counted as unscattered (Joseph and others
/// 1976), over ground that throws some of it back; what absorbs, absorbs along the straight way.
fn transmission(air: &Atmosphere, radius: f64, height: f64, sine: f64) -> [f64; 3] {
    let [molecules, haze] = [air.scale_height_m, air.mie_scale_height_m].map(|scale| scale * (-height / scale).exp());
    // Length of the slanted way over the vertical: finite at the horizon, where it is that of a sphere.
    let way = |scale: f64| 1.0 / (sine * sine + 2.0 * scale / (PI * radius) * (1.0 - sine * sine)).sqrt();
    [0, 1, 2].map(|k| {
        let (rayleigh, mie) = (air.rayleigh[k] * molecules, air.mie[k] * haze);
        let absorbed = air.mie_absorption[k] * haze * way(air.mie_scale_height_m)
            + 0.5 * air.ozone[k] * air.ozone_width_m * way(air.ozone_height_m.max(air.ozone_width_m));
        let scattering = rayleigh + mie;
        let forward = air.mie_g * mie / scattering.max(1e-30);
        let isotropic = (1.0 - forward) * scattering;
        let straight = (-(1.0 - forward * forward) * scattering * way(air.scale_height_m)).exp();
        let through = (2.0 / 3.0 + sine + (2.0 / 3.0 - sine) * straight) / (4.0 / 3.0 + isotropic);
        let back = isotropic / (4.0 / 3.0 + isotropic);
        through * (-absorbed).exp() / (1.0 - air.ground_albedo * back)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::layout::{Mode, Tone};
    use crate::draw::tone::Curve;
    use crate::globe::sphere::direction_at;
    use crate::recipe::shipped;
    use crate::reference::tonemap::display;
    use glam::Vec3;

    const RECIPES: [&str; 5] = ["terra", "luna", "mars", "tiny", "jacksboro"];

    /// A place some metres above the datum, and the sun some degrees above its horizon.
    fn scene(recipe: &Recipe, height: f64, degrees: f64) -> (DVec3, DVec3) {
        let up = direction_at(36.62, 106.05);
        let elevation = degrees.to_radians();
        (up * (recipe.radius + height), up.any_orthonormal_vector() * elevation.cos() + up * elevation.sin())
    }

    /// Code of a level card of a reflectance below the camera.
    fn card(recipe: &Recipe, height: f64, degrees: f64, reflectance: f64) -> f32 {
        let (position, sun) = scene(recipe, height, degrees);
        let light = reflectance / PI * irradiance(recipe, degrees.to_radians().sin());
        let curve = Curve::new(Tone::Neutral, recipe.white);
        255.0 * display(Mode::Shaded, &curve, exposure(recipe, position, sun) as f32, Vec3::splat(light as f32)).x
    }

    #[test]
    fn cards_of_18_percent_are_grey_and_whites_are_white() {
        for recipe in RECIPES.map(|name| shipped::load(name).unwrap()) {
            for degrees in [20.0, 25.0, 30.0, 45.0, 60.0, 90.0] {
                let [grey, white] = [0.18, recipe.white].map(|reflectance| card(&recipe, 2.0, degrees, reflectance));
                assert!((grey - 118.0).abs() < 8.0, "{} at {degrees}: {grey}", recipe.name);
                assert!((white - 240.0).abs() < 4.0, "{} at {degrees}: {white}", recipe.name);
            }
            // From orbit too, where the sun is high.
            let white = card(&recipe, 1.4 * recipe.radius, 50.0, recipe.white);
            assert!((white - 240.0).abs() < 4.0, "{}: {white}", recipe.name);
        }
    }

    #[test]
    fn lower_suns_make_darker_pictures_and_nights_are_dark() {
        for recipe in RECIPES.map(|name| shipped::load(name).unwrap()) {
            for height in [2.0, 0.05 * recipe.radius, 1.4 * recipe.radius] {
                let codes: Vec<f32> = (-20..=90).map(|degrees| card(&recipe, height, f64::from(degrees), 0.18)).collect();
                assert!(codes.windows(2).all(|pair| pair[0] <= pair[1] + 0.5), "{} from {height} m: {codes:?}", recipe.name);
                assert!(codes[24] < 70.0 && codes[10] < 1.0, "{} from {height} m: {codes:?}", recipe.name);
            }
        }
    }

    #[test]
    fn exposure_follows_the_day_in_sight_without_a_jump() {
        let recipe = shipped::load("terra").unwrap();
        let of = |height, degrees| {
            let (position, sun) = scene(&recipe, height, degrees);
            exposure(&recipe, position, sun)
        };
        assert!(of(2.0, -60.0) < 5.0 * of(2.0, 60.0), "{} {}", of(2.0, -60.0), of(2.0, 60.0));
        // A dark site below, but day in sight.
        assert!(of(9e6, 0.0) < 0.8 * of(2.0, 0.0) && of(9e6, 50.0) > 0.97 * of(2.0, 50.0));
        for degrees in -90..90 {
            let [now, next] = [degrees, degrees + 1].map(|d| of(4e5, f64::from(d)));
            assert!((now / next).ln().abs() < 0.13, "{degrees}: {now} {next}");
        }
    }

    #[test]
    fn positions_and_suns_without_sense_give_a_number() {
        let recipe = shipped::load("terra").unwrap();
        for (position, sun) in [(DVec3::ZERO, DVec3::X), (DVec3::X * 1e30, DVec3::X), (DVec3::X, -DVec3::X)] {
            assert!(exposure(&recipe, position, sun).is_finite());
        }
    }
}
