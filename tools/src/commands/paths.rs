//! Camera paths that commands follow: files, those that come with the command, and those that every planet has.

use anyhow::Context as _;
use std::path::{Path, PathBuf};
use terrane_planet::draw::camera_path::{CameraPath, Route};
use terrane_planet::planet::{Journey, Planet};

/// Paths that come with the command, at sites of Terra.
const BUILT_IN: [(&str, &str); 4] = [
    ("terra-descent", include_str!("../../paths/descent.json")),
    ("flyover", include_str!("../../paths/flyover.json")),
    ("ground", include_str!("../../paths/ground.json")),
    ("plunge", include_str!("../../paths/plunge.json")),
];

/// What stands for a path in help texts, and their words.
pub(crate) const VALUE: &str = "PATH.json|NAME";
pub(crate) const HELP: &str =
    "A JSON file; or descent, coast or tour, which any planet has; or terra-descent, flyover, ground or plunge, which suit Terra";

/// A path as it was given, which may depend on the planet.
pub(crate) struct GivenPath {
    given: PathBuf,
    source: Source,
}

enum Source {
    Route(Route),
    Journey(Journey),
}

impl GivenPath {
    /// The path of a file, or the one of that name.
    pub(crate) fn read(given: &Path) -> anyhow::Result<GivenPath> {
        let is_given = |name: &str| given.as_os_str() == name;
        if let Some((_, journey)) = Journey::ALL.into_iter().find(|(name, _)| is_given(name)) {
            return Ok(GivenPath { given: given.to_owned(), source: Source::Journey(journey) });
        }
        let text = match BUILT_IN.iter().find(|(name, _)| is_given(name)) {
            Some((_, text)) => (*text).to_owned(),
            None => std::fs::read_to_string(given)
                .with_context(|| format!("cannot read the camera path {} (built-in paths: {})", given.display(), names()))?,
        };
        let route =
            Route::from_json(&text).with_context(|| format!("{}: neither a list of keyframes nor a path", given.display()))?;
        // What is wrong with a path is said before a planet is opened or made.
        CameraPath::new(&route.keyframes).with_context(|| format!("{}: not a camera path", given.display()))?;
        Ok(GivenPath { given: given.to_owned(), source: Source::Route(route) })
    }

    /// Its keyframes over a planet.
    pub(crate) fn route(&self, planet: &Planet) -> Route {
        match &self.source {
            Source::Route(route) => route.clone(),
            Source::Journey(journey) => planet.journey(*journey),
        }
    }

    /// The path over a planet.
    pub(crate) fn over(&self, planet: &Planet) -> anyhow::Result<CameraPath> {
        let path = self.route(planet).path(planet.recipe.radius);
        path.with_context(|| format!("{}: not a camera path on {}", self.given.display(), planet.recipe.name))
    }
}

/// The names of all paths that are in no file.
fn names() -> String {
    let all = Journey::ALL.iter().map(|(name, _)| *name).chain(BUILT_IN.iter().map(|(name, _)| *name));
    all.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_named_path_is_one() {
        let planet = Planet::from_recipe(terrane_planet::recipe::shipped::load("tiny").unwrap(), 16).unwrap();
        for name in names().split(", ") {
            assert!(HELP.contains(name), "{name} is in no help text");
            let path = GivenPath::read(Path::new(name)).and_then(|path| path.over(&planet));
            path.unwrap_or_else(|error| panic!("{name}: {error:#}"));
        }
    }
}
