//! `terrane height`: the ground at a site.

use super::planets::CELLS;
use super::viewing::numbers;
use super::Run;
use crate::Outcome;
use anyhow::ensure;
use glam::DVec3;
use serde_json::json;
use std::path::{Path, PathBuf};
use terrane_planet::globe::patch::{PatchId, MAX_LEVEL};
use terrane_planet::globe::sphere::direction_at;
use terrane_planet::ground::NormalSite;
use terrane_planet::planet::Planet;
use terrane_planet::store::{is_planet_file, PlanetFile};

/// Metres to the points on each side from which a normal follows.
const SPACING_M: f64 = 1.0;

/// Print the height of the ground at a site, its normal, and how finely the file knows it. Needs no GPU.
///
/// Heights are metres above the datum, the sphere of the planet's radius, computed from the terrain itself and not from a mesh. The
/// normal is that of the ground between points --spacing metres to each side, as east, north and up.
#[derive(clap::Args)]
pub(crate) struct Height {
    /// Planet file, or a recipe: a TOML file, or the name of one that comes with the command.
    file: PathBuf,
    /// Site in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = numbers::<2>, allow_hyphen_values = true)]
    at: [f64; 2],
    /// Metres to the points on each side from which the normal follows.
    #[arg(long, value_name = "M", default_value_t = SPACING_M)]
    spacing: f64,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The planet of a file or of a recipe, and the file.
pub(crate) fn open_planet(path: &Path) -> anyhow::Result<(Planet, Option<PlanetFile>)> {
    if !is_planet_file(path) {
        return Ok((Planet::from_recipe(super::recipes::load_recipe(path)?, CELLS)?, None));
    }
    let file = PlanetFile::open(path)?;
    Ok((Planet::from_header(file.header())?, Some(file)))
}

/// Refuses a site that is on no planet.
pub(crate) fn check_site([latitude, longitude]: [f64; 2]) -> anyhow::Result<()> {
    ensure!((-90.0..=90.0).contains(&latitude), "--at: latitude {latitude}, expected -90 to 90 degrees");
    ensure!((-360.0..=360.0).contains(&longitude), "--at: longitude {longitude}, expected -180 to 180 degrees");
    Ok(())
}

impl Run for Height {
    fn run(self) -> anyhow::Result<Outcome> {
        check_site(self.at)?;
        ensure!((1e-3..=1e6).contains(&self.spacing), "--spacing: found {}, expected 0.001 to 1000000 metres", self.spacing);
        let (planet, file) = open_planet(&self.file)?;
        let up = direction_at(self.at[0], self.at[1]);
        let height = planet.terrain.height(up);
        let normal = planet.ground().normals(&[NormalSite { up, spacing: self.spacing }])[0];
        let normal = in_local_axes(normal, self.at);
        let stored = file.map(|file| stored_spacing(&planet, &file, up)).transpose()?.flatten();
        self.print(&planet, height, normal, stored);
        Ok(Outcome::Done)
    }
}

/// Components of a vector towards east, north and up at a site.
fn in_local_axes(v: DVec3, [latitude, longitude]: [f64; 2]) -> DVec3 {
    let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (latitude.to_radians().sin_cos(), longitude.to_radians().sin_cos());
    let east = DVec3::new(-sin_lon, cos_lon, 0.0);
    let north = DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
    DVec3::new(v.dot(east), v.dot(north), v.dot(direction_at(latitude, longitude)))
}

/// Metres between the samples of the finest patch over a site that a file holds.
fn stored_spacing(planet: &Planet, file: &PlanetFile, up: DVec3) -> anyhow::Result<Option<f64>> {
    for level in (0..=MAX_LEVEL).rev() {
        if file.contains(PatchId::containing(up, level))? {
            return Ok(Some(planet.lattice.sample_spacing(planet.cells, level) * planet.lattice.unit));
        }
    }
    Ok(None)
}

impl Height {
    fn print(&self, planet: &Planet, height: f64, normal: DVec3, stored: Option<f64>) {
        let [latitude, longitude] = self.at;
        let sea = planet.recipe.sea.as_ref().map(|sea| sea.level_m);
        let slope = normal.z.clamp(-1.0, 1.0).acos().to_degrees();
        if self.json {
            let result = json!({
                "file": self.file, "latitude": latitude, "longitude": longitude, "height_m": height, "sea_level_m": sea,
                "under_water": sea.is_some_and(|level| height < level), "normal": normal.to_array(), "slope_deg": slope,
                "normal_spacing_m": self.spacing, "stored_spacing_m": stored, "radius_m": planet.recipe.radius,
            });
            println!("{result}");
            return;
        }
        println!("{latitude}, {longitude}: {height:.3} m above the datum, a sphere of {} m", planet.recipe.radius);
        if let Some(level) = sea.filter(|level| height < *level) {
            println!("under water: the sea's surface is at {level} m");
        }
        let [east, north, up] = normal.to_array();
        println!(
            "normal {east:.4} east, {north:.4} north, {up:.4} up ({slope:.2} degrees steep), over {} m to each side",
            self.spacing
        );
        match stored {
            Some(metres) => println!("finest samples in the file: {metres:.3} m apart"),
            None => println!("no samples of it are stored: computed from the recipe"),
        }
    }
}
