//! The planet that a command is given: a planet file; or a recipe, the name of one, or the address of one that is published, whose file is
//! kept in the user's cache.

use super::building::Report;
use super::recipes::load_recipe;
use crate::network::{is_address, FetchCache, HttpObjects};
use anyhow::{bail, ensure, Context as _};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::Arc;
use std::time::Instant;
use tempfile::TempDir;
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::planet::bake::{bake, BakePlan};
use terrane_planet::planet::Planet;
use terrane_planet::published::{Otherwise, PublishedPlanet, PublishedRecords};
use terrane_planet::recipe::{shipped, Recipe};
use terrane_planet::store::{records, BakedPatch, PlanetFile, PlanetHeader, StoreError};

/// Cells along a patch side of a recipe's planet, as `terrane bake` has them.
pub(crate) const CELLS: u32 = 64;

/// What stands for a planet in help texts, and their words.
pub(crate) const FILE: &str = "FILE|RECIPE|NAME|URL";
pub(crate) const HELP: &str = "Planet file; or a recipe: a TOML file, or the name of one that comes with the command; or the address of the planet.json of a \
     published planet";

/// The same where a view may name the planet.
pub(crate) const WITH_VIEW: &str =
    "Planet file; or a recipe: a TOML file, or the name of one that comes with the command; or the address of the planet.json of a published \
     planet [default: that of --view]";

/// Finest level of the whole planet that is built for commands that build nothing themselves.
const LEVELS: u8 = 1;

/// Patches that are asked for at a time where all are, and written at a time.
const DOWNLOADS: usize = 16;
const DOWNLOADED_AT_ONCE: usize = 64;

/// Most bytes of published planets that the cache keeps.
const FETCHED_BYTES: u64 = 2_000_000_000;

/// Where a planet file is.
pub(crate) struct PlanetPlace {
    path: PathBuf,
    /// Where the planet was published that it is to hold.
    published: Option<Arc<PublishedPlanet>>,
    /// Where the user's cache cannot be written: a folder that goes with this.
    _folder: Option<TempDir>,
}

impl PlanetPlace {
    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Where what the file lacks is published, if it is.
    pub(crate) fn published(&self) -> Option<&Arc<PublishedPlanet>> {
        self.published.as_ref()
    }

    /// A planet file that is there.
    pub(crate) fn of_file(path: &Path) -> PlanetPlace {
        PlanetPlace { path: path.to_owned(), published: None, _folder: None }
    }
}

/// The planet file that was given, or that of a recipe, made if need be. Without either that of the planet of a view.
pub(crate) fn planet_file(given: Option<&Path>, view: Option<&ViewLine>) -> anyhow::Result<PlanetPlace> {
    let seen = view.and_then(|line| line.planet.as_deref()).map(Path::new);
    let names: Vec<&str> = shipped::names().collect();
    let Some(path) = given.or(seen) else {
        bail!("no planet: expected a planet file, a recipe or one of {}, or --view with the text of a picture", names.join(", "));
    };
    // Of those that are given alone: a picture from somewhere may not lead to a server.
    if let Some(address) = given.and_then(Path::to_str).filter(|text| is_address(text)) {
        return fetched(address);
    }
    let is_recipe = path.extension().is_some_and(|extension| extension == "toml");
    if path.is_file() && !is_recipe {
        return Ok(PlanetPlace::of_file(path));
    }
    let lower = path.to_string_lossy().to_lowercase();
    let is_name = names.contains(&lower.as_str());
    if !is_name && !is_recipe {
        bail!(
            "no planet file {}, and no recipe of that name: those that come with the command are {}",
            path.display(),
            names.join(", ")
        );
    }
    let name = if is_name { Path::new(&lower) } else { path };
    cached(&Planet::from_recipe(load_recipe(name)?, CELLS)?)
}

/// As [`planet_file`], for commands that draw only what the file holds: of recipes the coarsest levels are built.
pub(crate) fn built_planet_file(given: Option<&Path>, view: Option<&ViewLine>) -> anyhow::Result<PlanetPlace> {
    let place = planet_file(given, view)?;
    if given == Some(place.path()) {
        return Ok(place);
    }
    let header = PlanetFile::open(place.path())?.header().clone();
    let planet = Planet::from_header(&header)?;
    let mut file = PlanetFile::create_or_resume(place.path(), &header)?;
    match place.published() {
        Some(published) if published.is_of(&header) => {
            download(published, &mut file)?;
            return Ok(place);
        }
        Some(published) => eprintln!("terrane: {} is of another ground, and not fetched", published.place().display()),
        None => {}
    }
    let plan = BakePlan::new(planet.recipe.radius, LEVELS, None)?;
    let threads = super::building::Threads::default().count();
    bake(&mut file, &planet.terrain, &planet.terrain, &plan, threads, &|_| (), &AtomicBool::new(false))
        .with_context(|| format!("cannot bake {}", place.path().display()))?;
    Ok(place)
}

/// The file of a planet that is published, and where that is.
fn fetched(address: &str) -> anyhow::Result<PlanetPlace> {
    let folders = directories::ProjectDirs::from("", "", "terrane");
    let cache = folders.and_then(|folders| FetchCache::open(folders.cache_dir(), FETCHED_BYTES));
    let published = PublishedPlanet::open(Box::new(HttpObjects::new(address, cache)?))?;
    let planet = Planet::from_header(published.header())?;
    Ok(PlanetPlace { published: Some(Arc::new(published)), ..cached(&planet)? })
}

/// Fetches all that is published of a planet into its file.
fn download(published: &Arc<PublishedPlanet>, file: &mut PlanetFile) -> anyhow::Result<()> {
    let (begun, manifest) = (Instant::now(), published.manifest());
    ensure!(
        manifest.bytes <= FETCHED_BYTES,
        "{}: this command reads all of a planet, and {:.1} GB of it are published; expected at most {:.1} GB. Bake the part that you need \
         into a file, with --region",
        published.place().display(),
        manifest.bytes as f64 / 1e9,
        FETCHED_BYTES as f64 / 1e9
    );
    let (records, report) = (PublishedRecords::new(published.clone(), Otherwise::wait()), Report::new(&manifest.name));
    let (index, there) = (published.index(&|_| ())?, file.ids()?);
    let missing: Vec<PatchId> = index.iter().map(|(id, _)| *id).filter(|id| !there.contains(id)).collect();
    let patch = |&id: &PatchId| {
        let mesh = records::mesh(&records, id, &|_, _| false)?;
        let texture = records::texture(&records, id)?;
        let facts = mesh.as_ref().map(|prefix| prefix.mesh.facts);
        let facts = facts.with_context(|| format!("{}: patch {id} is not there", published.place().display()))?;
        let mesh = mesh.map(|prefix| prefix.mesh);
        Ok(BakedPatch::in_part(id, &facts, manifest.cells, mesh.as_ref(), texture.as_ref())?)
    };
    // Many at a time: they wait for each other on the line.
    let threads = rayon::ThreadPoolBuilder::new().num_threads(DOWNLOADS).build().context("cannot start threads")?;
    for (k, some) in missing.chunks(DOWNLOADED_AT_ONCE).enumerate() {
        let patches = threads.install(|| some.par_iter().map(patch).collect::<anyhow::Result<Vec<BakedPatch>>>())?;
        file.put(&patches)?;
        report.step(index.len() - missing.len() + k * DOWNLOADED_AT_ONCE + some.len(), index.len(), begun.elapsed());
    }
    report.finish();
    Ok(())
}

/// The planet's file in the user's cache; where that cannot be written, in a folder that goes with the command.
fn cached(planet: &Planet) -> anyhow::Result<PlanetPlace> {
    let header = planet.header();
    let refused = match directories::ProjectDirs::from("", "", "terrane") {
        Some(folders) => match made(folders.cache_dir(), &header) {
            Ok(path) => return Ok(PlanetPlace::of_file(&path)),
            Err(error) => format!("{error:#}"),
        },
        None => "there is no home folder".to_owned(),
    };
    eprintln!("terrane: what is built is not kept: {refused}");
    let folder = tempfile::Builder::new().prefix("terrane-").tempdir().context("cannot make a temporary folder")?;
    Ok(PlanetPlace { path: made(folder.path(), &header)?, published: None, _folder: Some(folder) })
}

/// The planet's file in a folder, sound. One that is damaged or old is replaced, which is said on stderr; so are edits of its ground.
fn made(folder: &Path, header: &PlanetHeader) -> anyhow::Result<PathBuf> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let path = folder.join(header.file_name());
    let edited = edited(&path, header)?;
    let header = edited.as_ref().unwrap_or(header);
    let sound = |path: &Path| PlanetFile::create_or_resume(path, header)?.index().map(drop);
    match sound(&path) {
        Ok(()) => {}
        Err(error @ (StoreError::System { .. } | StoreError::Database { .. })) => return Err(error.into()),
        Err(error) => {
            eprintln!("terrane: {error}: it is in the cache, and made anew");
            std::fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
            sound(&path)?;
        }
    }
    Ok(path)
}

/// What a file says of its planet if it is that of a header with edits of the ground, which stay until they are undone.
fn edited(path: &Path, header: &PlanetHeader) -> anyhow::Result<Option<PlanetHeader>> {
    if !path.exists() || !matches!(PlanetFile::create_or_resume(path, header), Err(StoreError::Edited { .. })) {
        return Ok(None);
    }
    let edited = PlanetFile::open(path)?.header().clone();
    let count = Recipe::from_parts(&edited.recipe, &edited.name, edited.assets.clone())?.undoable_edits();
    let (file, are) = (path.display(), if count == 1 { "edit" } else { "edits" });
    eprintln!("terrane: {} has {count} {are} of its ground: 'terrane edit {file} list' shows, 'undo' takes back; without that file it is as its recipe says", edited.name);
    Ok(Some(edited))
}
