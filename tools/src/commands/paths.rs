//! Camera paths that commands follow: files, those that come with the command, and those that every planet has.

use anyhow::Context as _;
use std::path::{Path, PathBuf};
use terrane_planet::draw::camera_path::{CameraPath, Route};
use terrane_planet::planet::Planet;

/// Paths that come with the command, at sites of Terra.
const BUILT_IN: [(&str, &str); 4] = [
    ("descent", include_str!("../../paths/descent.json")),
    ("flyover", include_str!("../../paths/flyover.json")),
    ("ground", include_str!("../../paths/ground.json")),
    ("plunge", include_str!("../../paths/plunge.json")),
];

/// A path as it was given, which may depend on the planet.
pub(crate) struct GivenPath {
    given: PathBuf,
    route: Route,
}

impl GivenPath {
    /// The path of a file, or the built-in one of that name.
    pub(crate) fn read(given: &Path) -> anyhow::Result<GivenPath> {
        let built_in = BUILT_IN.iter().find(|(name, _)| given.as_os_str() == *name);
        let text = match built_in {
            Some((_, text)) => (*text).to_owned(),
            None => std::fs::read_to_string(given).with_context(|| {
                let names = BUILT_IN.map(|(name, _)| name).join(", ");
                format!("cannot read the camera path {} (built-in paths: {names})", given.display())
            })?,
        };
        let route =
            Route::from_json(&text).with_context(|| format!("{}: neither a list of keyframes nor a path", given.display()))?;
        let path = GivenPath { given: given.to_owned(), route };
        // What is wrong with a path is said before a planet is opened or made.
        path.over_radius(1.0)?;
        Ok(path)
    }

    /// The path over a planet.
    pub(crate) fn over(&self, planet: &Planet) -> anyhow::Result<CameraPath> {
        self.over_radius(planet.recipe.radius)
    }

    fn over_radius(&self, radius_m: f64) -> anyhow::Result<CameraPath> {
        let path = self.route.path(radius_m);
        path.with_context(|| format!("{}: not a camera path", self.given.display()))
    }
}
