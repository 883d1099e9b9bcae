//! Camera paths that a window saves and loads by name: JSON files beside its pictures. A file that is there with other content than this
//! window knows is left as it is.

use super::super::pictures::write_whole;
use super::bookmarks::file_name;
use anyhow::{ensure, Context as _};
use std::collections::HashMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use terrane_planet::draw::camera_path::{CameraPath, Route};

/// The folder, and what is known of it.
pub(super) struct SavedPaths {
    folder: PathBuf,
    /// What this window loaded from a file, or saved in it, last.
    known: HashMap<PathBuf, String>,
}

impl SavedPaths {
    /// Those in a folder.
    pub(super) fn of(folder: &Path) -> SavedPaths {
        SavedPaths { folder: folder.to_owned(), known: HashMap::new() }
    }

    /// The file of a name.
    pub(super) fn file(&self, name: &str) -> PathBuf {
        let name = Some(file_name(name)).filter(|name| !name.is_empty()).unwrap_or("path".to_owned());
        self.folder.join(format!("{name}.json"))
    }

    /// Saves a path, and returns its file.
    pub(super) fn save(&mut self, name: &str, route: &Route) -> anyhow::Result<PathBuf> {
        let (file, text) = (self.file(name), route.to_json());
        let there = match std::fs::read(&file) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            read => Some(read.with_context(|| format!("cannot read {}, which is there already", file.display()))?),
        };
        if let Some(there) = &there {
            let ours = self.known.get(&file).is_some_and(|known| known.as_bytes() == there);
            ensure!(
                ours || there == text.as_bytes(),
                "{} is there already, and is not what this window loaded or saved: choose another name, or load it first",
                file.display()
            );
        }
        write_whole(&file, text.as_bytes())?;
        self.known.insert(file.clone(), text);
        Ok(file)
    }

    /// Loads a path.
    pub(super) fn load(&mut self, name: &str) -> anyhow::Result<Route> {
        let file = self.file(name);
        let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
        let route = Route::from_json(&text).with_context(|| file.display().to_string())?;
        CameraPath::new(&route.keyframes).with_context(|| file.display().to_string())?;
        self.known.insert(file, text);
        Ok(route)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(latitude: f64) -> Route {
        let keyframe = |time: f64| {
            format!(
                r#"{{"time_s": {time}, "latitude": {latitude}, "longitude": {time}, "altitude_m": 900, "heading": 0, "pitch": -60, "fov": 50}}"#
            )
        };
        Route::from_json(&format!(r#"{{"keyframes": [{}, {}]}}"#, keyframe(0.0), keyframe(2.0))).unwrap()
    }

    #[test]
    fn a_path_of_somebody_else_is_never_overwritten_and_ones_own_is() {
        let folder = tempfile::tempdir().unwrap();
        let mut ours = SavedPaths::of(folder.path());
        let file = ours.save("tour", &route(1.0)).unwrap();
        ours.save("tour", &route(2.0)).unwrap();
        assert_eq!(ours.load("tour").unwrap().to_json(), route(2.0).to_json());

        let mut theirs = SavedPaths::of(folder.path());
        let refused = format!("{:#}", theirs.save("tour", &route(3.0)).unwrap_err());
        assert!(refused.contains("tour.json is there already") && refused.contains("choose another name"), "{refused}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), route(2.0).to_json());
        // The same content, a name that is free, and a path that was loaded.
        theirs.save("tour", &route(2.0)).unwrap();
        theirs.save("other", &route(3.0)).unwrap();
        let mut third = SavedPaths::of(folder.path());
        third.load("tour").unwrap();
        third.save("tour", &route(4.0)).unwrap();

        // What the first knew of it is no longer what is there.
        ours.save("tour", &route(5.0)).unwrap_err();
        std::fs::remove_file(&file).unwrap();
        ours.save("tour", &route(5.0)).unwrap();
    }
}
