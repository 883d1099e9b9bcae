//! Where recorded frames go: a folder of numbered PNGs, a film that `ffmpeg` makes of them, or a strip.

use super::output::{check_output, Output};
use super::pictures;
use super::strip::Strip;
use anyhow::{bail, ensure, Context as _};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use terrane::stills::{Pixels, Still};

/// How `ffmpeg` is told to encode a container: its name there and the options. Four times smaller is seen; twice as large is not.
const CONTAINERS: [(&str, &[&str]); 2] = [
    ("mp4", &["-c:v", "libx264", "-preset", "slow", "-crf", "16", "-movflags", "+faststart"]),
    ("webm", &["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1"]),
];

/// The RGB of frames as films store it: told to players, which guess otherwise.
const COLOURS: [&str; 10] = [
    "-vf",
    "scale=out_color_matrix=bt709:out_range=tv",
    "-colorspace",
    "bt709",
    "-color_primaries",
    "bt709",
    "-color_trc",
    "iec61966-2-1",
    "-pix_fmt",
    "yuv420p",
];

/// Where frames go.
pub(crate) enum Film {
    /// A folder of numbered pictures.
    Folder {
        /// The folder.
        folder: PathBuf,
    },
    /// A film in the making.
    Encoder(Box<Encoder>),
    /// Frames side by side.
    Strip(Strip),
}

/// A running `ffmpeg`.
pub(crate) struct Encoder {
    child: Child,
    frames: Option<ChildStdin>,
    part: PathBuf,
    out: PathBuf,
}

/// The container that a name asks for, if it names a film.
pub(crate) fn container(out: &Path) -> Option<&'static str> {
    let extension = out.extension()?.to_string_lossy().to_lowercase();
    CONTAINERS.iter().map(|(name, _)| *name).find(|name| *name == extension)
}

impl Film {
    /// A folder, made if it is not there.
    pub(crate) fn folder(folder: &Path) -> anyhow::Result<Film> {
        check_output("--out", folder, Output::Folder)?;
        Ok(Film::Folder { folder: folder.to_owned() })
    }

    /// A film of frames of a size, so many a second. Fails at once where it cannot be made.
    pub(crate) fn encoder(out: &Path, [width, height]: [u32; 2], fps: f64) -> anyhow::Result<Film> {
        let name = container(out).context("no name of a film; please report this")?;
        ensure!(
            width % 2 == 0 && height % 2 == 0,
            "--size: {width}x{height}: films store colours of two by two pixels; make both sides even"
        );
        let options = CONTAINERS.iter().find(|(container, _)| *container == name).map_or(&[][..], |(_, options)| options);
        let file = out.file_name().with_context(|| format!("{} names no file", out.display()))?;
        let part = out.with_file_name(format!(".{}.part", file.to_string_lossy()));
        check_output("--out", out, Output::File(&[name]))?;
        let (size, rate) = (format!("{width}x{height}"), fps.to_string());
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y", "-f", "rawvideo", "-pix_fmt", "rgba", "-s", &size]);
        command.args(["-r", &rate, "-i", "-"]).args(options).args(COLOURS).args(["-f", name]).arg(&part);
        command.stdin(Stdio::piped()).stdout(Stdio::null());
        // Ctrl-C is for us: the film of the frames so far is to be finished.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        // A broken pipe is an error with a message, not the end of this process.
        #[cfg(unix)]
        signal_hook::flag::register(signal_hook::consts::SIGPIPE, Default::default()).context("cannot listen for SIGPIPE")?;
        let mut child = command.spawn().map_err(|error| spawn_problem(&error, name))?;
        let frames = child.stdin.take();
        Ok(Film::Encoder(Box::new(Encoder { child, frames, part, out: out.to_owned() })))
    }

    /// Whether the frame of a number, from 1, is there already.
    pub(crate) fn has(&self, number: usize) -> bool {
        matches!(self, Film::Folder { folder, .. } if frame_path(folder, number).exists())
    }

    /// Takes in the frame of a number.
    pub(crate) fn add(&mut self, number: usize, still: &Still) -> anyhow::Result<()> {
        match self {
            Film::Folder { folder } => {
                let path = frame_path(folder, number);
                pictures::write_still(&path, still).with_context(|| format!("cannot write the frame {}", path.display()))
            }
            Film::Encoder(encoder) => encoder.add(still),
            Film::Strip(strip) => strip.add(number, still),
        }
    }

    /// Finishes a film; call it for an interrupted one too.
    pub(crate) fn finish(self) -> anyhow::Result<()> {
        match self {
            Film::Folder { .. } => Ok(()),
            Film::Encoder(encoder) => encoder.finish(),
            Film::Strip(strip) => strip.finish(),
        }
    }
}

impl Encoder {
    fn add(&mut self, still: &Still) -> anyhow::Result<()> {
        let Pixels::Eight(rgba) = &still.pixels else { bail!("a frame that is not of 8 bits; please report this") };
        let Some(frames) = &mut self.frames else { bail!("a frame after the film's end; please report this") };
        let written = frames.write_all(rgba);
        if written.is_err() {
            self.frames = None;
            let ended = self.child.wait().map_or_else(|error| error.to_string(), |status| status.to_string());
            written.with_context(|| format!("ffmpeg took no more frames ({ended}); what it said stands above"))?;
        }
        Ok(())
    }

    fn finish(mut self) -> anyhow::Result<()> {
        self.frames = None;
        let status = self.child.wait().context("cannot wait for ffmpeg")?;
        if !status.success() {
            bail!("ffmpeg could not finish {} ({status}); what it said stands above", self.out.display());
        }
        std::fs::rename(&self.part, &self.out).with_context(|| format!("cannot write the film {}", self.out.display()))
    }
}

impl Drop for Encoder {
    /// A film that was not finished leaves nothing behind.
    fn drop(&mut self) {
        self.frames = None;
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.part);
    }
}

/// Where the frame of a number goes.
fn frame_path(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("{number:06}.png"))
}

fn spawn_problem(error: &std::io::Error, name: &str) -> anyhow::Error {
    if error.kind() == ErrorKind::NotFound {
        return anyhow::anyhow!(
            "ffmpeg was not found, and it makes the .{name}; install it (Debian, Ubuntu: apt install ffmpeg; Fedora: dnf install \
             ffmpeg-free; macOS: brew install ffmpeg; Windows: winget install ffmpeg), or record a folder of pictures: --out frames"
        );
    }
    anyhow::anyhow!("cannot start ffmpeg: {error}")
}
