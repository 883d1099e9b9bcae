//! What there is to say of a flight: numbers and lines for the interface, the view as text, and what to choose again another time.

use super::facts::Facts;
use super::flight::{Flight, Selection, USUAL_TOLERANCE};
use super::host::Settings;
use super::inspection::{drawn_at, inspect, Inspected};
use super::outlines::{Line, Outlines};
use super::pacing::Scale;
use super::view_line;
use egui::Color32;
use terrane_planet::draw::layout::Tone;
use terrane_planet::draw::view_line::ViewLine;
use terrane_planet::globe::sphere::latitude_longitude;

impl Flight {
    /// What is seen, as text that shows it elsewhere.
    pub(super) fn view_line(&self) -> ViewLine {
        let line = ViewLine {
            // The ground may have been edited since the planet was opened.
            recipe: Some(self.scene.planet().header().checksum()),
            time: Some(self.renderer.time),
            no_geomorphs: !self.choices.geomorphs,
            orientation: self.choices.orientation,
            error: Some(self.choices.tolerance),
            ..self.line.clone()
        };
        view_line::of(line, &self.viewer, self.scene.planet().recipe.radius, &self.choices.look)
    }

    /// What the interface says of this frame.
    pub(super) fn facts(&self) -> Facts {
        let (pose, recipe, tally) = (&self.viewer.pose, &self.scene.planet().recipe, self.scene.tally());
        let (latitude, longitude) = latitude_longitude(pose.up());
        let picked = self.inspected();
        let mut levels = Vec::new();
        for patch in self.tables.iter().flat_map(|tables| &tables.patches) {
            let level = patch.level as usize;
            levels.resize(levels.len().max(level + 1), 0);
            levels[level] += 1;
        }
        Facts {
            planet: recipe.name.clone(),
            radius_m: recipe.radius,
            tilt: recipe.axial_tilt,
            site: [latitude, longitude],
            height_m: pose.position.length() - recipe.radius,
            altitude_m: self.viewer.altitude(&self.surface()),
            ground_m: self.scene.ground().height_at(pose.up()),
            look: [pose.heading().to_degrees(), pose.pitch.to_degrees()],
            fov: self.viewer.lens.fov.to_degrees(),
            manner: self.viewer.manner(),
            speed: self.viewer.speed(),
            places: self.viewer.history.has(),
            named: recipe.places.clone(),
            plays: self.playback.is_some(),
            has: [recipe.atmosphere.is_some(), recipe.sea.is_some(), recipe.clouds.is_some()],
            counters: self.counters,
            prefix_vertices: self.tables.as_ref().map_or(0, |tables| tables.vertices),
            levels,
            pending: self.scene.pending(),
            read: tally.read,
            built: tally.built,
            bytes: [self.scene.gpu_bytes(), self.scene.host_bytes()],
            allocated: self.context.allocated_bytes(),
            stages: self.stages,
            density: self.density,
            device: self.context.device_info().name.clone(),
            frozen: self.selection != Selection::Follows,
            edits: self.scene.edits(),
            lines: self.lines(picked.as_ref()),
            picked,
        }
    }

    fn inspected(&self) -> Option<Inspected> {
        let (tables, site) = (self.tables.as_ref()?, self.picked?);
        let at = drawn_at(tables, site)?;
        let anatomy = self.anatomy.as_ref().filter(|anatomy| anatomy.is_of(&self.scene, tables.leaves[at].id))?;
        let frozen = self.frozen.as_ref().filter(|_| self.selection == Selection::Frozen);
        let view = frozen.map_or_else(|| self.view(), |frozen| frozen.view);
        inspect(&self.scene, &view, tables, at, anatomy, site)
    }

    /// Lines over the picture.
    fn lines(&self, picked: Option<&Inspected>) -> Vec<Line> {
        let mut outlines = Outlines::new(&self.scene, self.choices.look.sea, self.viewer.pose.camera(&self.viewer.lens));
        if let (Some(frozen), Selection::Frozen) = (&self.frozen, self.selection) {
            outlines.add_frozen(frozen);
        }
        if let Some(picked) = picked {
            let ancestors = std::iter::successors(picked.patch.parent(), |id| id.parent());
            ancestors.for_each(|id| outlines.add_patch(id, Color32::from_gray(130), 1.0));
            outlines.add_patch(picked.patch, Color32::WHITE, 2.0);
            outlines.add_chain(&picked.chain);
        }
        let tool = &self.panel.tool;
        if tool.held {
            let site = self.viewer.site_under_cursor(&self.surface());
            site.into_iter().for_each(|site| outlines.add_circle(site, tool.radius_m, Color32::from_rgb(255, 170, 60)));
        }
        if self.panel.open && self.playback.is_none() {
            let path = self.panel.board.path(self.scene.planet().recipe.radius);
            path.iter().for_each(|path| outlines.add_path(path));
        }
        outlines.lines
    }

    /// What to choose again in the next window.
    pub(super) fn settings(&self) -> Settings {
        let choices = &self.choices;
        Settings {
            panel: self.panel.open,
            speed: self.viewer.speed(),
            tolerance: Some(choices.tolerance).filter(|tolerance| *tolerance != USUAL_TOLERANCE),
            geomorphs: choices.geomorphs,
            scale: if let Scale::Fixed(density) = choices.scale { Some(density) } else { None },
            tone: Some(choices.look.tone).filter(|tone| *tone != Tone::Neutral).map(|tone| tone.name().to_owned()),
            date: choices.date,
            recent: self.panel.recent.clone(),
        }
    }
}
