//! What the panel asks for that the window cannot do alone, done by its host: views that are remembered, other planets, paths and films.

use super::flight::Flight;
use super::panel::{Asked, PathWish};
use super::App;

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
        if let Some(what) = &asked.open {
            self.open_other(what);
        }
    }

    /// Flies to a view, or over another planet.
    pub(super) fn open_other(&mut self, what: &str) {
        let (Some(flight), host) = (&mut self.flight, &mut self.options.host) else { return };
        flight.touch();
        if flight.scene.edits().is_busy() {
            return flight.panel.say("the ground is being changed: wait for it, and open it then".to_owned());
        }
        let view = match host.view(what) {
            Ok(view) => view,
            Err(problem) => return flight.panel.say(problem),
        };
        let elsewhere =
            view.as_ref().and_then(|view| view.planet.clone()).filter(|name| *name != flight.scene.planet().recipe.name);
        let what = match (&view, &elsewhere) {
            (Some(view), None) => return flight.show_view(view),
            (_, Some(planet)) => planet,
            (None, None) => what,
        };
        let opened = host.open(what).and_then(|opened| flight.open(&opened).map_err(|error| error.to_string()).map(|()| opened));
        match opened {
            Ok(opened) => {
                self.options.file = opened.file;
                self.options.settings.note_opened(&opened.name);
                flight.panel.recent = self.options.settings.recent.clone();
                flight.panel.say(format!("over {}", flight.scene.planet().recipe.name));
                view.iter().for_each(|view| flight.show_view(view));
            }
            Err(problem) => flight.panel.say(problem),
        }
        flight.touch();
    }
}
