//! The part of a planet that is made finer than the rest, as options say it.

use terrane_planet::globe::sphere::direction_at;
use terrane_planet::store::Region;

/// A part that is made finer.
#[derive(clap::Args, Clone, Copy)]
pub(crate) struct RegionOptions {
    /// Part to make finer: latitude and longitude in degrees, radius in kilometres.
    #[arg(long, value_name = "LAT,LON,RADIUS_KM", requires = "to_level", allow_hyphen_values = true, value_parser = parse_region)]
    region: Option<RegionArgument>,
    /// Finest level inside the region.
    #[arg(long, value_name = "LEVEL", requires = "region")]
    to_level: Option<u8>,
}

impl RegionOptions {
    /// The region, if one is asked for.
    pub(crate) fn region(&self) -> Option<Region> {
        let (region, to_level) = (self.region?, self.to_level?);
        let direction = direction_at(region.latitude, region.longitude);
        Some(Region { direction, radius_m: region.radius_km * 1e3, to_level })
    }
}

/// What `--region` says.
#[derive(Clone, Copy)]
struct RegionArgument {
    latitude: f64,
    longitude: f64,
    radius_km: f64,
}

fn parse_region(text: &str) -> Result<RegionArgument, String> {
    let numbers: Vec<f64> = text.split(',').map(|part| part.trim().parse()).collect::<Result<_, _>>().unwrap_or_default();
    let &[latitude, longitude, radius_km] = numbers.as_slice() else {
        return Err("expected three numbers: latitude and longitude in degrees, radius in kilometres, such as 46.5,8,50".into());
    };
    if !(-90.0..=90.0).contains(&latitude) {
        return Err(format!("latitude {latitude}, expected -90 to 90 degrees"));
    }
    if !(-360.0..=360.0).contains(&longitude) {
        return Err(format!("longitude {longitude}, expected -180 to 180 degrees"));
    }
    if !(radius_km >= 0.0 && radius_km.is_finite()) {
        return Err(format!("radius {radius_km}, expected 0 or more kilometres"));
    }
    Ok(RegionArgument { latitude, longitude, radius_km })
}
