//! `terrane gallery`: the pictures of the documentation, from a list.
//!
//! In: a list of views. Out: JPEGs and a page that shows them with the command line of each. The command lines are run as they are
//! printed: what the page says is what was done.

use super::output::{check_output, Output};
use super::{pictures, Run};
use crate::Outcome;
use anyhow::{bail, ensure, Context as _};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use serde::Deserialize;
use serde_json::json;
use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The list that comes with the command, and its name in messages.
const BUILT_IN: (&str, &str) = ("gallery.toml", include_str!("../../gallery.toml"));

/// Most bytes of a picture.
const MOST_BYTES: usize = 400_000;

/// Qualities to try until a picture is small enough.
const QUALITIES: [u8; 6] = [92, 88, 84, 78, 70, 60];

/// Render the gallery: a list of pictures as JPEGs of at most 400 KB, and a page with captions and the command of each.
///
/// The list is a TOML file of [[picture]] tables: `name`, `recipe` (as of `terrane bake`), `levels` (to bake beforehand, default 1), `options` (those of
/// `terrane shot`) and `caption`.
#[derive(clap::Args)]
pub(crate) struct Gallery {
    /// List of pictures [default: that of the documentation, which comes with the command].
    #[arg(long, value_name = "LIST.toml")]
    list: Option<PathBuf>,
    /// Folder for the JPEGs and the page, README.md.
    #[arg(long, value_name = "FOLDER", default_value = "docs/gallery")]
    out: PathBuf,
    /// Folder for planets and PNGs.
    #[arg(long, value_name = "FOLDER", default_value = "out")]
    work: PathBuf,
    /// Draw only the pictures of these names; the page keeps the others that are there.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Picture size in pixels, sides from 16 to 16384.
    #[arg(long, value_name = "WxH", default_value = "1920x1080")]
    size: String,
    /// Samples a pixel in each direction, 1 to 4.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=4))]
    ssaa: u32,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    picture: Vec<Entry>,
}

/// One picture.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    recipe: PathBuf,
    #[serde(default = "one")]
    levels: u8,
    options: String,
    caption: String,
}

fn one() -> u8 {
    1
}

impl Run for Gallery {
    fn run(self) -> anyhow::Result<Outcome> {
        let list = self.load()?;
        check_output("--out", &self.out, Output::Folder)?;
        check_output("--work", &self.work, Output::Folder)?;
        let mut baked = HashSet::new();
        let chosen: Vec<&Entry> = list.iter().filter(|entry| self.only.is_empty() || self.only.contains(&entry.name)).collect();
        for (number, entry) in chosen.iter().enumerate() {
            eprintln!("gallery: {} of {}, {}", number + 1, chosen.len(), entry.name);
            if baked.insert((&entry.recipe, entry.levels)) {
                run(&self.bake_line(entry))?;
            }
            run(&self.shot_line(entry))?;
            let (bytes, quality) = jpeg(&self.png(entry))?;
            let path = self.jpeg(entry);
            pictures::write_whole(&path, &bytes).with_context(|| format!("cannot write the picture {}", path.display()))?;
            eprintln!("gallery: {}, {} KB at quality {quality}", path.display(), bytes.len() / 1000);
        }
        let page = self.out.join("README.md");
        pictures::write_whole(&page, self.page(&list)?.as_bytes()).with_context(|| format!("cannot write {}", page.display()))?;
        if self.json {
            println!("{}", json!({ "page": page, "drawn": chosen.iter().map(|e| &e.name).collect::<Vec<_>>() }));
        } else {
            println!("{}: {} of {} pictures drawn", page.display(), chosen.len(), list.len());
        }
        Ok(Outcome::Done)
    }
}

impl Gallery {
    fn load(&self) -> anyhow::Result<Vec<Entry>> {
        let (file, text) = match &self.list {
            None => (BUILT_IN.0.to_owned(), BUILT_IN.1.to_owned()),
            Some(path) => {
                let text = std::fs::read_to_string(path);
                (path.display().to_string(), text.with_context(|| format!("cannot read the list {}", path.display()))?)
            }
        };
        let list: List = toml::from_str(&text).with_context(|| format!("{file}: not a list of pictures"))?;
        let mut names = HashSet::new();
        for entry in &list.picture {
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
            ensure!(
                !entry.name.is_empty() && entry.name.chars().all(plain),
                "{file}: '{}' is no name of a picture; use letters, digits, - and _",
                entry.name
            );
            ensure!(names.insert(&entry.name), "{file}: two pictures are called {}", entry.name);
        }
        for name in &self.only {
            ensure!(names.contains(name), "--only: {file} has no picture called {name}");
        }
        Ok(list.picture)
    }

    fn planet(&self, entry: &Entry) -> PathBuf {
        self.work.join(entry.recipe.file_stem().unwrap_or_default()).with_extension("planet")
    }

    fn png(&self, entry: &Entry) -> PathBuf {
        self.work.join(&entry.name).with_extension("png")
    }

    fn jpeg(&self, entry: &Entry) -> PathBuf {
        self.out.join(&entry.name).with_extension("jpg")
    }

    /// Arguments that bake an entry's planet.
    fn bake_line(&self, entry: &Entry) -> Vec<String> {
        let (recipe, planet) = (entry.recipe.display().to_string(), self.planet(entry).display().to_string());
        ["bake", &recipe, "--levels", &entry.levels.to_string(), "--out", &planet].map(str::to_owned).to_vec()
    }

    /// Arguments that draw it.
    fn shot_line(&self, entry: &Entry) -> Vec<String> {
        let mut line = vec!["shot".to_owned(), self.planet(entry).display().to_string()];
        line.extend(entry.options.split_whitespace().map(str::to_owned));
        let (ssaa, png) = (self.ssaa.to_string(), self.png(entry).display().to_string());
        line.extend(["--size", &self.size, "--ssaa", &ssaa, "--out", &png].map(str::to_owned));
        line
    }

    /// The page with all pictures that are there.
    fn page(&self, list: &[Entry]) -> anyhow::Result<String> {
        let mut page =
            "# Gallery\n\nEvery picture is what its command draws. `terrane gallery` makes all of them, and this page.\n"
                .to_owned();
        for entry in list.iter().filter(|entry| self.jpeg(entry).exists()) {
            let Entry { name, caption, .. } = entry;
            write!(page, "\n![{caption}]({name}.jpg)\n\n{caption}\n\n```sh\n")?;
            for line in [self.bake_line(entry), self.shot_line(entry)] {
                writeln!(page, "terrane {}", line.join(" "))?;
            }
            page.push_str("```\n");
        }
        Ok(page)
    }
}

/// Runs this program with arguments; what it prints goes to stderr.
fn run(line: &[String]) -> anyhow::Result<()> {
    let program = std::env::current_exe().context("cannot find this program")?;
    let output = Command::new(program).args(line).stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let output = output.with_context(|| format!("cannot run terrane {}", line.join(" ")))?;
    eprint!("{}", String::from_utf8_lossy(&output.stdout));
    ensure!(output.status.success(), "`terrane {}` failed ({}); its reason stands above", line.join(" "), output.status);
    Ok(())
}

/// A PNG of 8 bits as a JPEG that is small enough, and its quality.
fn jpeg(path: &Path) -> anyhow::Result<(Vec<u8>, u8)> {
    let file = std::fs::File::open(path).with_context(|| format!("cannot read the picture {}", path.display()))?;
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info()?;
    let mut rgb = vec![0; reader.output_buffer_size().context("a picture that is too large")?];
    let info = reader.next_frame(&mut rgb)?;
    ensure!(info.color_type == png::ColorType::Rgb, "{}: {:?}, expected RGB", path.display(), info.color_type);
    let (width, height) = (u16::try_from(info.width)?, u16::try_from(info.height)?);
    for quality in QUALITIES {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, quality);
        // Colours as sharp as the rest: coasts and horizons are edges of colour.
        encoder.set_sampling_factor(SamplingFactor::R_4_4_4);
        encoder.encode(&rgb, width, height, ColorType::Rgb)?;
        if bytes.len() <= MOST_BYTES {
            return Ok((bytes, quality));
        }
    }
    bail!("{}: more than {} KB even at quality {}; choose a smaller --size", path.display(), MOST_BYTES / 1000, QUALITIES[5])
}
