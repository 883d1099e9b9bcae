//! A film that is drawn beside the window, by a `terrane record` of its own. In: a planet file, a path and a view. Out: an mp4, or a folder of
//! pictures where ffmpeg is missing; and a word when it is done.

use anyhow::Context as _;
use std::fs::File;
use std::io::{Read as _, Seek as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use terrane_planet::draw::view_line::ViewLine;

/// Size of films, in pixels: what most players show whole.
const SIZE: &str = "1280x720";

/// A film that is being drawn. It goes on when the window is closed.
pub(super) struct Filming {
    /// The film.
    pub(super) out: PathBuf,
    process: Child,
    /// What it says of what goes wrong.
    words: File,
}

impl Filming {
    /// Begins to draw the path of a file, on a GPU as `--gpu` names it.
    pub(super) fn begin(planet: &Path, path: &Path, view: &ViewLine, gpu: Option<&str>) -> anyhow::Result<Filming> {
        let has_ffmpeg = Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
        let out = if has_ffmpeg { path.with_extension("mp4") } else { path.with_extension("") };
        if !has_ffmpeg {
            std::fs::create_dir_all(&out).with_context(|| format!("cannot make the folder {}", out.display()))?;
        }
        let mut record = Command::new(std::env::current_exe().context("cannot find this program")?);
        record.arg("record").arg(planet).arg("--path").arg(path).arg("--out").arg(&out).args(options(view, gpu));
        let words = tempfile::tempfile().context("cannot make a temporary file")?;
        let process = record.stdin(Stdio::null()).stdout(Stdio::null()).stderr(words.try_clone()?).spawn();
        Ok(Filming { out, process: process.context("cannot start terrane record")?, words })
    }

    /// What became of it, once it is done.
    pub(super) fn news(&mut self) -> Option<String> {
        let status = self.process.try_wait().ok()??;
        if status.success() {
            return Some(format!("the film is done: {}", self.out.display()));
        }
        let mut said = String::new();
        let _ = self.words.rewind().and_then(|()| self.words.read_to_string(&mut said));
        Some(format!("no film: {}", said.lines().last().unwrap_or("terrane record failed")))
    }
}

/// How the film is drawn: as the window draws, but for its size and the time of its waves.
fn options(view: &ViewLine, gpu: Option<&str>) -> Vec<String> {
    let view = ViewLine { size: None, time: None, ..view.clone() };
    let options = ["--size", SIZE, "--view", &view.to_string()].map(str::to_owned);
    options.into_iter().chain(gpu.map(|gpu| format!("--gpu={gpu}"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_drawn_on_the_gpu_that_the_window_was_given() {
        let view = "terrane:1/planet=Terra/at=46,8/altitude=900/size=64x48".parse().unwrap();
        let usual = options(&view, None);
        assert!(usual[..3] == ["--size", SIZE, "--view"] && usual.len() == 4 && !usual[3].contains("64x48"), "{usual:?}");
        assert_eq!(options(&view, Some("llvmpipe")), [&usual[..], &["--gpu=llvmpipe".to_owned()]].concat());
    }
}
