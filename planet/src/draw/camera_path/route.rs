//! A path as its JSON has it. In: text. Out: keyframes and how time passes between them; and the text again.

use super::{CameraPath, Keyframe, PathError};
use serde::{Deserialize, Serialize};

/// How time passes along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pace {
    /// Every keyframe is passed at its time.
    #[default]
    Timed,
    /// Keyframes say the order and the whole duration; in between speed is in proportion to altitude.
    Constant,
}

/// Keyframes, and how time passes between them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Route {
    /// How time passes.
    #[serde(default)]
    pub pace: Pace,
    /// Keyframes in order of time.
    pub keyframes: Vec<Keyframe>,
}

impl Route {
    /// Keyframes that are passed at their times.
    pub fn timed(keyframes: Vec<Keyframe>) -> Route {
        Route { pace: Pace::Timed, keyframes }
    }

    /// Reads `{"pace": "constant", "keyframes": […]}`, or a list of keyframes alone, which are passed at their times.
    ///
    /// # Errors
    /// For text that is neither, with line and column. Numbers are checked by [`Route::path`].
    pub fn from_json(text: &str) -> Result<Route, serde_json::Error> {
        if text.trim_start().starts_with('[') {
            return serde_json::from_str(text).map(Route::timed);
        }
        serde_json::from_str(text)
    }

    /// Text for [`Route::from_json`], a line a keyframe: the numbers come back to the bit. Those that no JSON has, infinite or none, do not.
    pub fn to_json(&self) -> String {
        // Keyframes are plain numbers under plain keys: what serde_json may refuse is not among them.
        let line = |keyframe: &Keyframe| format!("  {}", serde_json::to_string(keyframe).unwrap_or_default());
        let lines: Vec<String> = self.keyframes.iter().map(line).collect();
        let list = format!("[\n{}\n]", lines.join(",\n"));
        match self.pace {
            Pace::Timed => list + "\n",
            Pace::Constant => format!("{{ \"pace\": \"constant\", \"keyframes\": {list} }}\n"),
        }
    }

    /// The path, over a planet of a radius in metres.
    ///
    /// # Errors
    /// As [`CameraPath::new`].
    pub fn path(&self, radius_m: f64) -> Result<CameraPath, PathError> {
        match self.pace {
            Pace::Timed => CameraPath::new(&self.keyframes),
            Pace::Constant => CameraPath::at_constant_pace(&self.keyframes, radius_m),
        }
    }
}
