//! `terrane fly`: the planet in a window.

use super::drawing::DrawOptions;
use super::output::{check_output, Output};
use super::viewing::{report_messages, CameraOptions, Exposure};
use super::{pictures, Run};
use crate::Outcome;
use std::path::{Path, PathBuf};
use terrane::app::{fly, FlyOptions, HELP};
use terrane_planet::planet::Planet;
use terrane_planet::store::PlanetFile;

/// Fly over a planet in a window.
#[derive(clap::Args)]
#[command(after_help = format!("Keys and mouse:\n{HELP}"))]
pub(crate) struct Fly {
    /// Planet file.
    file: PathBuf,
    #[command(flatten)]
    camera: CameraOptions,
    #[command(flatten)]
    draw: DrawOptions,
    /// Folder for the pictures that P and F12 save.
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    screenshots: PathBuf,
}

impl Run for Fly {
    fn run(self) -> anyhow::Result<Outcome> {
        check_output("--screenshots", &self.screenshots, Output::Folder)?;
        let planet = Planet::from_header(PlanetFile::open(&self.file)?.header())?;
        let camera = self.camera.camera(&planet)?;
        let folder = self.screenshots;
        let (report, ended) = fly(FlyOptions {
            file: self.file,
            context: self.draw.gpu.options(),
            camera,
            scene: self.draw.patches.options()?,
            look: self.draw.look.look(&planet.recipe, self.camera.site(), Exposure::Auto),
            tolerance: self.camera.error,
            geomorphs: self.draw.mesh.geomorphs(),
            orientation: self.draw.mesh.orientation(),
            save: Box::new(move |size, pixels| save(&folder, size, pixels).map_err(|error| format!("not saved: {error:#}"))),
        });
        let reported = report_messages(&report.messages);
        ended?;
        reported?;
        println!("{} frames in {:.1} s", report.frames, report.seconds);
        Ok(Outcome::Done)
    }
}

/// Saves a picture under the first number that is free.
fn save(folder: &Path, size: [u32; 2], pixels: &[u8]) -> anyhow::Result<String> {
    let mut paths = (1u32..).map(|number| folder.join(format!("terrane-{number}.png")));
    let path = paths.find(|path| !path.exists()).unwrap_or_else(|| folder.join("terrane.png"));
    pictures::write_png(&path, size, pixels)?;
    Ok(format!("saved {}", path.display()))
}
