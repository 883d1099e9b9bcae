//! What the panel asks for that the window cannot do alone, done by its host: views that are remembered, other planets, paths and films.

use super::flight::Flight;
use super::panel::{Asked, PathWish};
use super::App;
use terrane_planet::draw::view_line::ViewLine;

impl App {
    /// Asks the host for what the panel was asked for.
    pub(super) fn ask_host(&mut self, asked: &Asked) {
        let (Some(flight), host) = (&mut self.flight, &mut self.options.host) else { return };
        if let Some(name) = &asked.forget {
            let said = host.remove_bookmark(name).map_or_else(|problem| problem, |()| format!("forgot {name}"));
            flight.panel.say(said);
            flight.panel.set_bookmarks(host.bookmarks());
        }
        if let Some(wish) = &asked.path {
            flight.follow_path_wish(wish);
            let radius = flight.scene.planet().recipe.radius;
            let whole = |flight: &Flight| flight.panel.board.path(radius).map(drop).map_err(|error| error.to_string());
            let said = match wish {
                PathWish::Save(name) => whole(flight).and_then(|()| host.save_path(name, &flight.panel.board.route())),
                PathWish::Load(name) => host.load_path(name).map(|route| {
                    flight.panel.board.take(route);
                    format!("{name} is the path now")
                }),
                PathWish::Film(name) => whole(flight)
                    .and_then(|()| host.film(&self.options.file, name, &flight.panel.board.route(), &flight.film_view())),
                PathWish::Take(_) | PathWish::Visit(_) => Ok(String::new()),
            };
            let said = said.unwrap_or_else(|problem| problem);
            if !said.is_empty() {
                flight.panel.say(said);
            }
        }
        if asked.reset {
            flight.reset();
            flight.panel.say("all settings are as they are at first".to_owned());
        }
        if let Some(view) = &asked.view {
            self.open_view(view);
        }
        if let Some(what) = &asked.open {
            self.open_other(what);
        }
    }

    /// Flies to a view, or over another planet.
    pub(super) fn open_other(&mut self, what: &str) {
        match self.options.host.view(what) {
            Ok(Some(view)) => self.open_view(&view),
            Ok(None) => drop(self.open_planet(what)),
            Err(problem) => self.say(problem),
        }
    }

    /// Flies to a view, over its planet: that is opened first if it is another.
    fn open_view(&mut self, view: &ViewLine) {
        let here = self.flight.as_ref().map(|flight| &flight.scene.planet().recipe.name);
        let elsewhere = view.planet.as_ref().filter(|name| Some(*name) != here);
        if elsewhere.is_none_or(|planet| self.open_planet(planet)) {
            self.flight.iter_mut().for_each(|flight| flight.show_view(view));
        }
    }

    /// Flies over another planet. False if it stays the one that it was.
    fn open_planet(&mut self, what: &str) -> bool {
        let (Some(flight), host) = (&mut self.flight, &mut self.options.host) else { return false };
        if flight.scene.edits().is_busy() {
            self.say("the ground is being changed: wait for it, and open it then".to_owned());
            return false;
        }
        match host.open(what).and_then(|opened| flight.open(&opened).map_err(|error| error.to_string()).map(|()| opened)) {
            Ok(opened) => {
                self.options.file = opened.file;
                self.options.scene.published = opened.published;
                self.options.settings.note_opened(&opened.name);
                flight.panel.recent = self.options.settings.recent.clone();
                let over = format!("over {}", flight.scene.planet().recipe.name);
                self.say(over);
                true
            }
            Err(problem) => {
                self.say(problem);
                false
            }
        }
    }

    /// Says something to the user for a while.
    fn say(&mut self, message: String) {
        if let Some(flight) = &mut self.flight {
            flight.panel.say(message);
            flight.touch_interface();
        }
    }
}
