//! A flight that goes on over another planet, over its planet as it was edited, or on another device.

use super::choices::Choices;
use super::flight::{Flight, Selection};
use super::host::Opened;
use super::keys::Keys;
use super::panel::Panel;
use super::pose::Pose;
use super::viewer::Viewer;
use super::AppError;
use crate::frame::Look;
use crate::scene::{Scene, SceneOptions, Scope};
use std::path::Path;
use terrane_planet::draw::view::Camera;
use terrane_planet::draw::view_line::ViewLine;

/// What does not go with a device.
pub(super) struct Survivors {
    pub(super) viewer: Viewer,
    panel: Panel,
    choices: Choices,
    home: Pose,
    line: ViewLine,
}

impl Flight {
    /// Flies over another planet from now on. What was chosen stays, but for the sun.
    ///
    /// # Errors
    /// A file that cannot be opened: the planet before stays. Device loss.
    pub(super) fn open(&mut self, opened: &Opened) -> Result<(), AppError> {
        self.context.wait_idle()?;
        self.options.published.clone_from(&opened.published);
        let options = SceneOptions { scope: Scope::Flight, ..self.options.clone() };
        self.scene = Scene::open(&self.context, &opened.file, options)?;
        self.scene.bear_edits_of_others();
        self.viewer.appear(&Camera { size: self.viewer.lens.size, ..opened.camera });
        self.home = self.viewer.pose;
        self.choices.look = Look { sun: opened.look.sun, ..self.choices.look };
        self.choices.date = opened.view.date();
        self.line = opened.view.clone();
        (self.tables, self.selection, self.playback) = (None, Selection::Follows, None);
        (self.picked, self.frozen) = (None, None);
        self.window.set_title(&format!("Terrane: {}", opened.file.display()));
        self.touch();
        Ok(())
    }

    /// Goes on where it is, over what its planet's file says by now.
    ///
    /// # Errors
    /// A file that cannot be opened, or that is edited meanwhile. Device loss.
    pub(super) fn read_anew(&mut self, file: &Path) -> Result<(), AppError> {
        self.context.wait_idle()?;
        let options = SceneOptions { scope: Scope::Flight, ..self.options.clone() };
        self.scene = Scene::open(&self.context, file, options)?;
        self.scene.bear_edits_of_others();
        (self.tables, self.selection) = (None, Selection::Follows);
        (self.picked, self.frozen) = (None, None);
        self.touch();
        Ok(())
    }

    /// What is left of it when its device is lost.
    pub(super) fn survivors(&mut self, keys: Keys) -> Survivors {
        let camera = self.viewer.pose.camera(&self.viewer.lens);
        Survivors {
            panel: std::mem::replace(&mut self.panel, Panel::new(false)),
            viewer: std::mem::replace(&mut self.viewer, Viewer::new(&camera, keys)),
            choices: self.choices,
            home: self.home,
            line: self.line.clone(),
        }
    }

    /// Goes on where another flight was, on another device.
    pub(super) fn take_over(&mut self, survivors: Survivors) {
        let Survivors { viewer, panel, choices, home, line } = survivors;
        (self.viewer, self.panel, self.choices, self.home, self.line) = (viewer, panel, choices, home, line);
        self.follow_scale();
    }

    /// Draws as many pixels from now on as was chosen.
    pub(super) fn follow_scale(&mut self) {
        self.pacing.set_scale(self.choices.scale);
    }
}
