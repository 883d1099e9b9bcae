//! Remembered views: a folder of small PNGs, each named as the user named it, that carry their view as all pictures of terrane do.

use super::super::pictures;
use super::super::views::given;
use anyhow::{ensure, Context as _};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use terrane::app::{Bookmark, Picture};

/// Most characters of a name.
const LONGEST_NAME: usize = 80;

/// The folder.
pub(super) struct Shelf(PathBuf);

impl Shelf {
    /// The user's. None without a home folder.
    pub(super) fn of_user() -> Option<Shelf> {
        directories::ProjectDirs::from("", "", "terrane").map(|folders| Shelf(folders.data_dir().join("views")))
    }

    /// All views, by name. What is no picture of terrane is passed over.
    pub(super) fn all(&self) -> Vec<Bookmark> {
        let files = std::fs::read_dir(&self.0).into_iter().flatten().flatten();
        let mut all: Vec<Bookmark> = files.filter_map(|entry| read(&entry.path())).collect();
        all.sort_by(|a, b| a.name.cmp(&b.name));
        all
    }

    /// Puts a view there, under another name if that is taken.
    pub(super) fn add(&self, bookmark: &Bookmark) -> anyhow::Result<()> {
        std::fs::create_dir_all(&self.0).with_context(|| format!("cannot make the folder {}", self.0.display()))?;
        let name = file_name(&bookmark.name);
        ensure!(!name.is_empty(), "a name of nothing but dots and blanks, expected letters or digits");
        let numbered = (1u32..).map(|number| if number == 1 { name.clone() } else { format!("{name} {number}") });
        let mut paths = numbered.map(|name| self.0.join(format!("{name}.png")));
        let path = paths.find(|path| !path.exists()).context("no name is free")?;
        let Picture { size, rgba } = &bookmark.thumbnail;
        pictures::write_png(&path, *size, rgba, Some(&bookmark.view))
    }

    /// Takes a view away.
    pub(super) fn remove(&self, name: &str) -> anyhow::Result<()> {
        // Names of what is there come from its files, and lead nowhere else.
        let path = self.0.join(format!("{name}.png"));
        ensure!(path.parent() == Some(self.0.as_path()), "'{name}' is no name of a view");
        std::fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))
    }
}

/// A name that every file system takes and that leads nowhere else.
pub(super) fn file_name(name: &str) -> String {
    let kept = |c: char| if c.is_control() || "/\\:*?\"<>|".contains(c) { '_' } else { c };
    let name: String = name.chars().map(kept).take(LONGEST_NAME).collect();
    name.trim_matches(|c: char| c == '.' || c.is_whitespace()).to_owned()
}

fn read(path: &Path) -> Option<Bookmark> {
    let view = given(path.to_str()?).ok()?;
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let mut rgb = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut rgb).ok()?;
    let rgba = match (info.color_type, info.bit_depth) {
        (png::ColorType::Rgb, png::BitDepth::Eight) => rgb.chunks_exact(3).flat_map(|c| [c[0], c[1], c[2], 255]).collect(),
        _ => return None,
    };
    let name = path.file_stem()?.to_str()?.to_owned();
    Some(Bookmark { name, view, thumbnail: Picture { size: [info.width, info.height], rgba } })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bookmark(name: &str) -> Bookmark {
        let view = "terrane:1/planet=Terra/at=46,8/altitude=900".parse().unwrap();
        let thumbnail = Picture { size: [4, 3], rgba: (0..48).map(|k| if k % 4 == 3 { 255 } else { 5 * k }).collect() };
        Bookmark { name: name.to_owned(), view, thumbnail }
    }

    #[test]
    fn views_come_back_by_name_with_their_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let shelf = Shelf(folder.path().join("views"));
        assert_eq!(shelf.all(), []);
        shelf.add(&bookmark("The bay, 46° N")).unwrap();
        shelf.add(&bookmark("a beach")).unwrap();
        std::fs::write(shelf.0.join("notes.txt"), "no picture").unwrap();
        std::fs::write(shelf.0.join("broken.png"), "no picture either").unwrap();
        assert_eq!(shelf.all(), [bookmark("The bay, 46° N"), bookmark("a beach")]);
        shelf.remove("a beach").unwrap();
        assert_eq!(shelf.all(), [bookmark("The bay, 46° N")]);
        assert!(format!("{:#}", shelf.remove("a beach").unwrap_err()).contains("a beach.png"));
    }

    #[test]
    fn a_name_that_is_taken_gets_a_number_and_none_leads_elsewhere() {
        let folder = tempfile::tempdir().unwrap();
        let shelf = Shelf(folder.path().to_owned());
        for name in ["../x/y", "../x/y", "..", ""] {
            assert_eq!(shelf.add(&bookmark(name)).is_ok(), name.len() > 2, "{name}");
        }
        let names: Vec<String> = shelf.all().into_iter().map(|bookmark| bookmark.name).collect();
        assert_eq!(names, ["_x_y", "_x_y 2"]);
    }
}
