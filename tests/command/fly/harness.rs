//! A window on an X server of its own, and a hand for mouse and keys.

use super::common::{command, text};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Longest wait for an event that should come at once.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);
/// Time for a few frames of a software renderer under validation.
pub(super) const FRAMES: Duration = Duration::from_millis(700);
/// First size of the window.
pub(super) const SIZE: (u32, u32) = (320, 240);
/// Size of the screen.
pub(super) const SCREEN: (u32, u32) = (800, 600);

pub(super) fn terrane(arguments: &[&str]) -> Command {
    let mut command = command(arguments);
    command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env_remove("RUST_LOG");
    // What the user of this machine, or another test, chose before is nothing to a test.
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let own = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fly-{}-{number}", std::process::id()));
    command.env("XDG_CONFIG_HOME", own.join("config")).env("XDG_DATA_HOME", own.join("data"));
    command
}

pub(super) fn bake(folder: &Path) -> PathBuf {
    let planet = folder.join("tiny.planet");
    let recipe = Path::new(env!("CARGO_MANIFEST_DIR")).join("../planet/recipes/tiny.toml");
    let mut command = terrane(&["bake", "--cells", "32", "--levels", "2", "--out"]);
    let output = command.arg(&planet).arg(recipe).output().expect("terrane runs");
    assert!(output.status.success(), "{}", text(&output.stderr));
    planet
}

/// A process that ends with the test.
pub(super) struct Owned(pub(super) Child);

impl Drop for Owned {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Held by the test whose window is open: frames of one must not wait for those of another.
static TURN: Mutex<()> = Mutex::new(());

/// An X server, for one test at a time.
pub(super) struct Server {
    _process: Owned,
    _turn: MutexGuard<'static, ()>,
}

/// An X server on a display number that it finds by itself. None if there is no Xvfb.
pub(super) fn display() -> Option<(Server, String)> {
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut command = Command::new("Xvfb");
    // Without -noreset the server resets when its last client leaves, and drops a client that connects at that moment.
    let screen = format!("{}x{}x24", SCREEN.0, SCREEN.1);
    command.args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-noreset"]);
    let mut server = Owned(command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().ok()?);
    let mut stdout = server.0.stdout.take().unwrap();
    let mut number = String::new();
    let mut byte = [0];
    // One line, written when the server is ready.
    while stdout.read(&mut byte).unwrap() == 1 && byte[0] != b'\n' {
        number.push(char::from(byte[0]));
    }
    assert!(!number.is_empty(), "Xvfb found no free display");
    Some((Server { _process: server, _turn: turn }, format!(":{number}")))
}

/// Sends keys and mouse events to one window.
pub(super) struct Hand {
    display: String,
    pub(super) window: String,
}

impl Hand {
    pub(super) fn xdotool(display: &str, arguments: &[&str]) -> Option<Output> {
        Command::new("xdotool").args(arguments).env("DISPLAY", display).stdin(Stdio::null()).output().ok()
    }

    /// Waits for the window and gives it the keyboard focus, because no window manager runs here.
    pub(super) fn on(display: &str, flight: &mut Owned) -> Hand {
        let begun = Instant::now();
        loop {
            let found = Hand::xdotool(display, &["search", "--onlyvisible", "--name", "Terrane"]).unwrap();
            if let Some(window) = text(&found.stdout).lines().next() {
                let hand = Hand { display: display.to_owned(), window: window.to_owned() };
                hand.does(&["windowfocus", "--sync", window]);
                return hand;
            }
            if flight.0.try_wait().unwrap().is_some() {
                let mut said = String::new();
                let _ = flight.0.stderr.take().unwrap().read_to_string(&mut said);
                panic!("it ended before its window came: {said}");
            }
            assert!(begun.elapsed() < PATIENCE, "no window");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    pub(super) fn does(&self, arguments: &[&str]) {
        let output = Hand::xdotool(&self.display, arguments).unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    }

    /// Presses a key and lets a few frames go by.
    pub(super) fn key(&self, key: &str) {
        self.does(&["key", key]);
        std::thread::sleep(FRAMES);
    }

    /// Presses the key for a picture and waits for the file.
    pub(super) fn picture(&self, path: &Path) -> Picture {
        self.picture_by("p", path)
    }

    /// Presses a key that saves a picture and waits for the file.
    pub(super) fn picture_by(&self, key: &str, path: &Path) -> Picture {
        self.does(&["key", key]);
        let begun = Instant::now();
        while !path.exists() {
            assert!(begun.elapsed() < PATIENCE, "no {}", path.display());
            std::thread::sleep(Duration::from_millis(20));
        }
        Picture::read(path)
    }
}

#[derive(PartialEq)]
pub(super) struct Picture {
    pub(super) size: (u32, u32),
    pub(super) rgb: Vec<u8>,
}

impl Picture {
    pub(super) fn read(path: &Path) -> Picture {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        Picture { size: (info.width, info.height), rgb }
    }

    pub(super) fn brightness(&self, x: u32, y: u32) -> u32 {
        let at = 3 * (y * self.size.0 + x) as usize;
        self.rgb[at..at + 3].iter().map(|channel| u32::from(*channel)).sum()
    }

    pub(super) fn colours(&self) -> usize {
        self.rgb.chunks_exact(3).collect::<std::collections::HashSet<_>>().len()
    }
}

/// Exit code and output of a flight that was told to end.
pub(super) fn end(mut flight: Owned) -> (Option<i32>, String, String) {
    let begun = Instant::now();
    let status = loop {
        if let Some(status) = flight.0.try_wait().unwrap() {
            break status;
        }
        assert!(begun.elapsed() < PATIENCE, "it did not end");
        std::thread::sleep(Duration::from_millis(20));
    };
    let (mut stdout, mut stderr) = (String::new(), String::new());
    flight.0.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
    flight.0.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    // On a machine without a GPU it says that software draws; what else it says is what counts.
    let (software, rest): (Vec<&str>, Vec<&str>) = stderr.lines().partition(|line| line.contains("the software renderer"));
    assert!(software.len() <= 1, "{stderr}");
    (status.code(), stdout, rest.join("\n"))
}
