//! Files of the user's folder of settings: `window.toml`, what was chosen in the last window, and `keys.toml`, which key does what.

use super::super::pictures::write_whole;
use anyhow::Context as _;
use std::path::PathBuf;
use terrane::app::{Keys, Settings};

/// A file of the folder. None without a home folder.
fn file(name: &str) -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "terrane").map(|folders| folders.config_dir().join(name))
}

/// What was chosen in the last window. A file that cannot be used is said on stderr, and its choices are the usual ones.
pub(super) fn load() -> Settings {
    let Some(path) = file("window.toml").filter(|path| path.exists()) else { return Settings::default() };
    let read = || -> anyhow::Result<Settings> { Ok(toml::from_str(&std::fs::read_to_string(&path)?)?) };
    read().unwrap_or_else(|error| {
        eprintln!("terrane: {}: {error:#}: the usual settings are taken", path.display());
        Settings::default()
    })
}

/// Keeps what was chosen.
pub(super) fn keep(settings: &Settings) -> anyhow::Result<()> {
    let Some(path) = file("window.toml") else { return Ok(()) };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    write_whole(&path, toml::to_string(settings)?.as_bytes()).with_context(|| format!("cannot write {}", path.display()))
}

/// The usual keys, but for what the user's file says otherwise.
pub(super) fn keys() -> anyhow::Result<Keys> {
    let Some(file) = file("keys.toml").filter(|file| file.exists()) else { return Ok(Keys::default()) };
    let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read the keys {}", file.display()))?;
    Keys::from_toml(&text).with_context(|| format!("{}", file.display()))
}
