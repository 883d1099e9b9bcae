//! Camera paths that commands follow: files, and those that come with the command.

use anyhow::Context as _;
use std::path::Path;
use terrane_planet::draw::camera_path::{CameraPath, Keyframe};

/// Paths that come with the command.
const BUILT_IN: [(&str, &str); 4] = [
    ("descent", include_str!("../../paths/descent.json")),
    ("flyover", include_str!("../../paths/flyover.json")),
    ("ground", include_str!("../../paths/ground.json")),
    ("plunge", include_str!("../../paths/plunge.json")),
];

/// The path of a file, or the built-in one of that name.
pub(crate) fn load_path(path: &Path) -> anyhow::Result<CameraPath> {
    let built_in = BUILT_IN.iter().find(|(name, _)| path.as_os_str() == *name);
    let text = match built_in {
        Some((_, text)) => (*text).to_owned(),
        None => std::fs::read_to_string(path).with_context(|| {
            let names = BUILT_IN.map(|(name, _)| name).join(", ");
            format!("cannot read the camera path {} (built-in paths: {names})", path.display())
        })?,
    };
    let keyframes: Vec<Keyframe> =
        serde_json::from_str(&text).with_context(|| format!("{}: not a list of keyframes", path.display()))?;
    CameraPath::new(&keyframes).with_context(|| format!("{}: not a camera path", path.display()))
}
