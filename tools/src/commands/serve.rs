//! `terrane serve`: a planet over HTTP.

use super::building::{stop_on_signals, Report};
use super::planets::built_planet_file;
use super::Run;
use crate::network::{serve, Limits, Served};
use crate::Outcome;
use anyhow::{ensure, Context as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Instant;
use terrane_planet::published::{publish, PublishError, MANIFEST};
use terrane_planet::store::PlanetFile;

/// Serve a planet over HTTP, read-only: `terrane fly http://HOST:PORT/planet.json` draws it elsewhere.
///
/// A planet file, a recipe or a name is published into the user's cache first (see `terrane publish`); a folder that is published already is
/// served as it is. It listens on this machine alone unless told otherwise. More than it may answer is turned away with 503 and Retry-After;
/// /metrics says what it did. Ctrl-C lets answers that are on their way arrive.
#[derive(clap::Args)]
pub(crate) struct Serve {
    /// Planet file, recipe or name, or the folder of a planet that is published.
    #[arg(value_name = "FILE|RECIPE|NAME|DIR")]
    planet: PathBuf,
    /// Where to listen; port 0 takes one that is free.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:8080")]
    addr: SocketAddr,
    /// Folder of 3D Tiles to serve under /tiles/.
    #[arg(long, value_name = "DIR")]
    tiles: Option<PathBuf>,
    /// Requests answered at a time.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u16).range(1..=4096))]
    at_once: u16,
    /// Requests answered a second.
    #[arg(long, value_name = "N", default_value_t = 5000.0)]
    rate: f64,
    /// Megabytes sent a second.
    #[arg(long, value_name = "MB", default_value_t = 1000.0)]
    bandwidth: f64,
}

impl Run for Serve {
    fn run(self) -> anyhow::Result<Outcome> {
        for (option, value) in [("--rate", self.rate), ("--bandwidth", self.bandwidth)] {
            ensure!(value.is_finite() && value > 0.0, "{option}: found {value}, expected a number above 0");
        }
        if let Some(tiles) = &self.tiles {
            ensure!(tiles.join("tileset.json").is_file(), "--tiles: there is no tileset.json in {}", tiles.display());
        }
        let manifest = self.planet.join(MANIFEST);
        let place = if manifest.is_file() { None } else { Some(built_planet_file(Some(&self.planet), None)?) };
        let stop = stop_on_signals()?;
        let (folder, name) = if let Some(place) = place {
            let file = PlanetFile::open(place.path())?;
            let name = file.header().name.clone();
            let folders = directories::ProjectDirs::from("", "", "terrane")
                .context("there is no home folder to publish in: use terrane publish, and serve its folder")?;
            let folder = folders.cache_dir().join("published").join(file.header().file_name());
            let (report, begun) = (Report::new(&name), Instant::now());
            let published = publish(&file, &folder, false, &|done, total| report.step(done, total, begun.elapsed()), &stop);
            report.finish();
            match published {
                Err(PublishError::Stopped) => return Ok(Outcome::Interrupted),
                other => other?,
            };
            (folder, name)
        } else {
            (self.planet.clone(), name_of(&manifest)?)
        };
        let limits = Limits { at_once: self.at_once.into(), per_second: self.rate, bytes_per_second: self.bandwidth * 1e6 };
        let say = |address: SocketAddr| println!("{name} is at http://{address}/ : terrane fly http://{address}/{MANIFEST}");
        serve(Served { folder, tiles: self.tiles, name: name.clone() }, self.addr, limits, stop, &say)?;
        Ok(Outcome::Done)
    }
}

/// The planet of a `planet.json`.
fn name_of(manifest: &Path) -> anyhow::Result<String> {
    let bytes = std::fs::read(manifest).with_context(|| format!("cannot read {}", manifest.display()))?;
    let manifest = terrane_planet::published::Manifest::parse(&bytes).with_context(|| format!("{}", manifest.display()))?;
    Ok(manifest.name)
}
