//! The `[atmosphere]` table of a recipe: a thin shell of molecules and aerosols, exponential in height, and a layer of ozone. In: the
//! table. Out: an [`Atmosphere`]. The model is that of Bruneton (2017).

use super::error::RecipeError;
use super::reader::Reader;

/// Aerosol absorption as a share of scattering, where a recipe says nothing.
const MIE_ABSORPTION_SHARE: f64 = 0.11;
/// Asymmetry of aerosol scattering, where a recipe says nothing.
const MIE_G: f64 = 0.8;
/// Middle and width of the ozone layer in metres, where a recipe says nothing: the Earth's.
const OZONE: [f64; 2] = [25e3, 30e3];
/// Reflectance of the ground as the air sees it, where a recipe says nothing.
const GROUND_ALBEDO: f64 = 0.15;

/// A thin shell of gas, exponential in height above the radius.
#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    /// Height in metres over which the molecules thin out by a factor e.
    pub scale_height_m: f64,
    /// Rayleigh scattering at the datum for red, green, blue, per metre.
    pub rayleigh: [f64; 3],
    /// Aerosol scattering at the datum for red, green, blue, per metre.
    pub mie: [f64; 3],
    /// Aerosol absorption at the datum for red, green, blue, per metre.
    pub mie_absorption: [f64; 3],
    /// Asymmetry of aerosol scattering: 0 the same to all sides, towards 1 ever more forwards.
    pub mie_g: f64,
    /// Height in metres over which the aerosols thin out by a factor e.
    pub mie_scale_height_m: f64,
    /// Absorption in the middle of the ozone layer for red, green, blue, per metre.
    pub ozone: [f64; 3],
    /// Height in metres of the middle of the ozone layer.
    pub ozone_height_m: f64,
    /// Thickness in metres of the ozone layer; its density falls from the middle to 0 at both edges in straight lines.
    pub ozone_width_m: f64,
    /// Reflectance of the ground, for light that is scattered more than once.
    pub ground_albedo: f64,
}

impl Atmosphere {
    pub(super) fn read(reader: &Reader<'_>) -> Result<Self, RecipeError> {
        let mie = reader.number_or_numbers("mie_per_m", 0.0..=1.0)?;
        let absorption = if reader.has("mie_absorption_per_m") {
            reader.number_or_numbers("mie_absorption_per_m", 0.0..=1.0)?
        } else {
            mie.map(|scattering| MIE_ABSORPTION_SHARE * scattering)
        };
        let ozone = if reader.has("ozone_per_m") { reader.numbers("ozone_per_m", 0.0..=1.0)? } else { [0.0; 3] };
        let atmosphere = Self {
            scale_height_m: reader.number("scale_height_m", 1.0..=1e6)?,
            rayleigh: reader.numbers("rayleigh_per_m", 0.0..=1.0)?,
            mie,
            mie_absorption: absorption,
            mie_g: reader.number_or("mie_g", -0.95..=0.95, MIE_G)?,
            mie_scale_height_m: reader.number("mie_scale_height_m", 1.0..=1e6)?,
            ozone,
            ozone_height_m: reader.number_or("ozone_height_m", 0.0..=1e6, OZONE[0])?,
            ozone_width_m: reader.number_or("ozone_width_m", 1.0..=1e6, OZONE[1])?,
            ground_albedo: reader.number_or("ground_albedo", 0.0..=1.0, GROUND_ALBEDO)?,
        };
        reader.finish()?;
        Ok(atmosphere)
    }
}

#[cfg(test)]
mod tests {
    use crate::recipe::Recipe;
    use std::path::Path;

    fn read(more: &str) -> Result<Recipe, String> {
        let text = include_str!("../../recipes/tiny.toml").replace("[atmosphere]\n", &format!("[atmosphere]\n{more}\n"));
        Recipe::from_toml(&text, "tiny.toml", Path::new("")).map_err(|e| e.to_string())
    }

    #[test]
    fn recipes_from_before_ozone_keep_their_air() {
        let air = read("").unwrap().atmosphere.unwrap();
        assert_eq!((air.mie, air.ozone, air.mie_g), ([4e-5; 3], [0.0; 3], 0.8));
        assert!((air.mie_absorption[1] - 4.4e-6).abs() < 1e-12);
    }

    #[test]
    fn every_key_is_read_and_checked() {
        let more = "mie_absorption_per_m = [1e-6, 2e-6, 3e-6]\nozone_per_m = [4e-6, 5e-6, 6e-6]\nozone_height_m = 700.0\n\
                    ozone_width_m = 300.0\nmie_g = 0.5\nground_albedo = 0.4";
        let air = read(more).unwrap().atmosphere.unwrap();
        assert_eq!((air.mie_absorption, air.ozone), ([1e-6, 2e-6, 3e-6], [4e-6, 5e-6, 6e-6]));
        assert_eq!((air.ozone_height_m, air.ozone_width_m, air.mie_g, air.ground_albedo), (700.0, 300.0, 0.5, 0.4));
        for wrong in ["mie_g = 1.0", "ozone_per_m = 1e-6", "mie_absorption_per_m = [1e-6, 2e-6]", "ground_albedo = -0.1"] {
            let key = wrong.split(' ').next().unwrap();
            assert!(read(wrong).unwrap_err().contains(key), "{wrong}");
        }
    }

    #[test]
    fn dust_may_have_a_colour() {
        let text = include_str!("../../recipes/tiny.toml").replace("mie_per_m = 4.0e-5", "mie_per_m = [6e-5, 5e-5, 3e-5]");
        let recipe = Recipe::from_toml(&text, "tiny.toml", Path::new("")).unwrap();
        assert_eq!(recipe.atmosphere.unwrap().mie, [6e-5, 5e-5, 3e-5]);
    }
}
