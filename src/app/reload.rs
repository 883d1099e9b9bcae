//! Drawing with shaders as they are edited (feature `hot-reload`).
//!
//! In: what the watch of their folder found. Out: a flight that draws with them from the next frame on, or goes on as before and says why.
//! After a lost device the program's own shaders are drawn with until the next change: an edited one may be why it was lost.

use super::flight::Flight;
use crate::hot_reload::ShaderWatch;
use crate::vulkan::Replacements;

impl Flight {
    /// Draws with the shaders that the watch found meanwhile, if any.
    pub(super) fn follow_shaders(&mut self, watch: &ShaderWatch) {
        let Some(found) = watch.news() else { return };
        let said = match found.and_then(|shaders| self.take_shaders(shaders)) {
            Ok(()) => "drawing with the shaders as they are now".to_owned(),
            Err(problem) => {
                // The panel shows it for a while only.
                tracing::error!("shaders stay as they were: {problem}");
                format!("shaders stay as they were:\n{problem}")
            }
        };
        self.panel.say(said);
        self.touch();
    }

    fn take_shaders(&mut self, shaders: Replacements) -> Result<(), String> {
        self.renderer.reload(shaders).map_err(|error| error.to_string())
    }
}
