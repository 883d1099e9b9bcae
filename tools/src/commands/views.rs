//! `--view`: a view as one line of text, or the picture that carries it.

use anyhow::{Context as _, Error};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use terrane::stills::read_view;
use terrane_planet::draw::view_line::{ViewLine, SCHEME};
use terrane_planet::planet::Planet;

/// What stands for the value of `--view`, and its help.
pub(crate) const VALUE: &str = "TEXT|PICTURE.png";
pub(crate) const HELP: &str =
    "A view: text such as terrane:1/at=46,8/altitude=900, or a PNG that terrane drew; options beside it go first";

/// The view that a text is, or that a picture was drawn from.
pub(crate) fn given(text: &str) -> Result<ViewLine, String> {
    let words = |error: Error| format!("{error:#}");
    if text.trim_start().starts_with(SCHEME) || !Path::new(text).exists() {
        return text.parse().map_err(|error| words(Error::new(error).context("neither a picture nor a view")));
    }
    let line = read(Path::new(text)).map_err(words)?;
    line.parse().map_err(|error| words(Error::new(error).context(format!("the text in {text}"))))
}

fn read(path: &Path) -> anyhow::Result<String> {
    let read = File::open(path).map_err(Error::new).and_then(|file| Ok(read_view(BufReader::new(file))?));
    let found = read.with_context(|| format!("cannot read {} as a PNG, expected a picture of terrane", path.display()))?;
    found.with_context(|| {
        format!("{}: found no view in it, expected a picture that `terrane shot` or a window saved", path.display())
    })
}

/// Puts into a view which planet it shows.
pub(crate) fn note_planet(line: &mut ViewLine, planet: &Planet) {
    line.planet = Some(planet.recipe.name.clone());
    line.recipe = Some(planet.header().checksum());
}

/// Says on stderr if a view is of another planet: its picture will be another, too.
pub(crate) fn check_planet(line: &ViewLine, planet: &Planet) {
    let (name, recipe) = (&planet.recipe.name, planet.header().checksum());
    match (&line.planet, line.recipe) {
        (Some(found), _) if found != name => eprintln!("terrane: the view is of {found}, and this is {name}"),
        (_, Some(found)) if found != recipe => {
            eprintln!(
                "terrane: the view is of another {name}, recipe {found:08x}, and this is {recipe:08x}: the ground may differ"
            )
        }
        _ => {}
    }
}
