//! Kinds of elevation files that people have: each comes out with its right spacing, heights, place and gaps, or is refused with
//! the way out. The files are made here, or are fixtures in `data/dem` where nothing at hand writes such a file. The table in
//! `docs/elevation.md` is made of what comes out: `TERRANE_UPDATE=1 cargo test -p terrane-heightfield kinds` writes it.

use crate::kinds_of_containers::containers;
use crate::kinds_of_places::places;
use crate::kinds_of_samples::samples;
use std::path::Path;
use terrane_heightfield::import::{read_with, ImportError, Imported, Options, Values};

/// A file, what its owner says, and what must come out.
pub(crate) struct Case {
    pub(crate) kind: &'static str,
    /// What the user says on the command line.
    pub(crate) flags: &'static str,
    pub(crate) name: &'static str,
    pub(crate) bytes: Vec<u8>,
    pub(crate) options: Options,
    pub(crate) expect: Expect,
}

pub(crate) enum Expect {
    Reads(Right),
    /// A refusal that says these words.
    Refused(&'static [&'static str]),
}

/// What is right of a file that is read.
#[derive(Clone)]
pub(crate) struct Right {
    pub(crate) size: [usize; 2],
    /// Metres between samples, if known.
    pub(crate) spacing: Option<[f64; 2]>,
    /// Longitude and latitude of the north-western sample, if known in degrees.
    pub(crate) corner: Option<[f64; 2]>,
    /// Lowest and highest, in metres or levels.
    pub(crate) heights: [f64; 2],
    pub(crate) levels: bool,
    pub(crate) gaps: usize,
    /// Words of which the notes must tell.
    pub(crate) notes: &'static [&'static str],
}

impl Case {
    pub(crate) fn new(kind: &'static str, name: &'static str, bytes: Vec<u8>, expect: Expect) -> Case {
        Case { kind, flags: "", name, bytes, options: Options::default(), expect }
    }

    pub(crate) fn with(self, flags: &'static str, options: Options) -> Case {
        Case { flags, options, ..self }
    }

    fn read(&self) -> Result<Imported, ImportError> {
        let image = read_with(&self.bytes, self.name, &self.options)?;
        match image.unplaced {
            // What `terrane simplify` and recipes say, unless told how far samples lie apart.
            Some(error) => Err(*error),
            None => Ok(image),
        }
    }

    /// Checks what comes out, and says it in a cell of the table.
    fn outcome(&self) -> String {
        match (self.read(), &self.expect) {
            (Ok(image), Expect::Reads(right)) => {
                right.check(self.kind, &image);
                described(&image)
            }
            (Err(error), Expect::Refused(words)) => {
                let message = error.to_string();
                for word in *words {
                    assert!(message.contains(word), "{}: {message:?} lacks {word:?}", self.kind);
                }
                format!("refused: found {}; {}", error.found, error.advice)
            }
            (Ok(image), Expect::Refused(_)) => panic!("{}: read as {}", self.kind, described(&image)),
            (Err(error), Expect::Reads(_)) => panic!("{}: {error}", self.kind),
        }
    }
}

impl Right {
    fn check(&self, kind: &str, image: &Imported) {
        let near =
            |found: f64, wanted: f64, off: f64| assert!((found - wanted).abs() <= off, "{kind}: {found}, expected {wanted}");
        assert_eq!([image.field.columns(), image.field.rows()], self.size, "{kind}");
        assert_eq!((image.no_data, image.values != Values::Metres), (self.gaps, self.levels), "{kind}");
        assert_eq!(image.spacing_m.is_some(), self.spacing.is_some(), "{kind}: {:?}", image.spacing_m);
        for (found, wanted) in image.spacing_m.into_iter().flatten().zip(self.spacing.into_iter().flatten()) {
            near(found, wanted, 2e-4 * wanted);
        }
        if let Some(wanted) = self.corner {
            let found = image.georeference.as_ref().map(|place| place.corners_deg[0]).unwrap();
            near(found[0], wanted[0], 2e-5);
            near(found[1], wanted[1], 2e-5);
        }
        for (found, wanted) in image.range.into_iter().zip(self.heights) {
            near(f64::from(found), wanted, 1e-6 * wanted.abs() + 1e-3);
        }
        // The highest ground is in the north-east of every file.
        let highest = image.field.heights().iter().position(|&h| h == image.range[1]).unwrap();
        let (column, row) = (highest % self.size[0], highest / self.size[0]);
        assert!(column >= self.size[0] / 2 && row < self.size[1] / 2, "{kind}: highest at column {column}, row {row}");
        for word in self.notes {
            assert!(image.notes.iter().any(|note| note.contains(word)), "{kind}: {:?} lack {word:?}", image.notes);
        }
        assert_eq!(self.notes.is_empty(), image.notes.is_empty(), "{kind}: {:?}", image.notes);
    }
}

/// What came out, in words.
fn described(image: &Imported) -> String {
    let spacing = match image.spacing_m {
        Some([across, along]) if (across - along).abs() < 5e-5 => format!("{across:.4} m a sample"),
        Some([across, along]) => format!("{across:.4} × {along:.4} m a sample"),
        None => "spacing unknown (`--spacing`)".into(),
    };
    let [low, high] = image.range;
    let heights = match image.values {
        Values::Metres => format!("{low} to {high} m"),
        Values::Levels { full } => format!("levels {low} to {high} of {full} (`--range`)"),
    };
    let place = image.georeference.as_ref().map(|place| format!("; {}", place.crs)).unwrap_or_default();
    let gaps = if image.no_data > 0 { format!("; {} gaps", image.no_data) } else { String::new() };
    let notes: String = image.notes.iter().map(|note| format!("; says: {note}")).collect();
    format!("{spacing}; {heights}{place}{gaps}{notes}")
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[test]
fn kinds_of_elevation_files_come_out_right_or_are_refused_with_the_way_out() {
    let cases: Vec<Case> = places().into_iter().chain(samples()).chain(containers()).collect();
    assert!(cases.len() >= 45, "{} kinds", cases.len());
    let mut table = String::from("| kind of file | said by the user | what comes out |\n|---|---|---|\n");
    for case in &cases {
        let flags = if case.flags.is_empty() { String::new() } else { format!("`{}`", case.flags) };
        table += &format!("| {} | {} | {} |\n", cell(case.kind), cell(&flags), cell(&case.outcome()));
    }
    compare_with_page(&table);
}

/// The page must hold the table; `TERRANE_UPDATE=1` puts it there.
fn compare_with_page(table: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/elevation.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once("<!-- table -->\n").unwrap();
    let (found, after) = rest.split_once("<!-- end of table -->").unwrap();
    if std::env::var_os("TERRANE_UPDATE").is_some() {
        std::fs::write(&path, format!("{before}<!-- table -->\n{table}<!-- end of table -->{after}")).unwrap();
        return;
    }
    for (found, wanted) in found.lines().zip(table.lines()) {
        assert_eq!(found, wanted, "{} is old: TERRANE_UPDATE=1 writes it", path.display());
    }
    assert_eq!(found.lines().count(), table.lines().count());
}

/// The check itself fails on what is wrong by a thousandth, by a gap, or by a turn.
#[test]
fn wrong_kinds_are_seen() {
    let file = crate::tiff_file::TiffFile::floats().at([5e5, 52e5], [10.0, 10.0]).keys(&[(1024, 1), (3072, 32_632)], &[]).bytes();
    let image = read_with(&file, "a.tif", &Options::default()).unwrap();
    let right = Right {
        size: [96, 64],
        spacing: Some([10.0; 2]),
        corner: None,
        heights: [400.0, 800.0],
        levels: false,
        gaps: 0,
        notes: &[],
    };
    right.check("right", &image);
    let fails = |wrong: Right| assert!(std::panic::catch_unwind(|| wrong.check("wrong", &image)).is_err());
    fails(Right { spacing: Some([10.01, 10.0]), ..right.clone() });
    fails(Right { heights: [400.0, 801.0], ..right.clone() });
    fails(Right { gaps: 1, ..right.clone() });
    fails(Right { size: [64, 96], ..right });
}
