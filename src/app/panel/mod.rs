//! The interface as it is laid out: a line of status, what is being built, messages, the help, and the panel with everything that can be
//! chosen.
//!
//! In: facts, and the choices so far. Out: the choices as changed, and what was asked for.

mod frames;
mod ground;
mod help;
mod inspected;
mod light;
mod mesh;
mod numbers;
mod paths;
mod planets;
mod position;
mod status;
mod views;

use super::choices::Choices;
use super::destination::{self, Destination, Site};
use super::earthwork::Tool;
use super::facts::Facts;
use super::host::Bookmark;
use super::keys::{Command, Keys};
use super::storyboard::{Revision, Storyboard};
use egui::{Align2, Area, Context, Id, Key, ScrollArea, TextEdit, Window};
use frames::FrameTimes;
use paths::PathForm;
pub(super) use paths::PathWish;
use status::Status;
use std::time::{Duration, Instant};
use terrane_planet::draw::view_line::ViewLine;
use views::Shelved;

/// How long a message stays.
const MESSAGE_TIME: Duration = Duration::from_secs(5);
/// Width of the panel, in points.
const WIDTH: f32 = 268.0;

/// What was asked for.
#[derive(Default)]
pub(super) struct Asked {
    pub(super) commands: Vec<Command>,
    pub(super) destination: Option<Site>,
    pub(super) manner: Option<super::viewer::Manner>,
    pub(super) speed: Option<f64>,
    /// Degrees.
    pub(super) fov: Option<f64>,
    /// A view to fly to.
    pub(super) view: Option<ViewLine>,
    /// The name of a view to forget.
    pub(super) forget: Option<String>,
    /// A planet, a picture or a view to open.
    pub(super) open: Option<String>,
    /// What is to be done to the keyframes of the path, and to the path.
    pub(super) revisions: Vec<Revision>,
    pub(super) path: Option<PathWish>,
    /// Whether settings are to be as they are at first.
    pub(super) reset: bool,
}

/// State of the interface.
pub(super) struct Panel {
    /// Whether the panel is shown.
    pub(super) open: bool,
    /// Whether nothing is shown.
    pub(super) hidden: bool,
    /// Whether the help is shown.
    pub(super) help: bool,
    /// What is typed as a place, while that is asked for; and why the last was none.
    going: Option<(String, String)>,
    message: Option<(String, Instant)>,
    times: FrameTimes,
    status: Status,
    /// The tool that changes the ground.
    pub(super) tool: Tool,
    /// The path that is worked on.
    pub(super) board: Storyboard,
    form: PathForm,
    shelf: Vec<Shelved>,
    /// What is typed as the name of a view, and as a planet to open.
    name: String,
    opening: String,
    /// Names of planets that can always be opened, and those opened lately.
    pub(super) planets: Vec<String>,
    pub(super) recent: Vec<String>,
}

impl Panel {
    pub(super) fn new(open: bool) -> Panel {
        Panel {
            open,
            hidden: false,
            help: false,
            going: None,
            message: None,
            times: FrameTimes::default(),
            status: Status::default(),
            tool: Tool::default(),
            board: Storyboard::default(),
            form: PathForm::default(),
            shelf: Vec::new(),
            name: String::new(),
            opening: String::new(),
            planets: Vec::new(),
            recent: Vec::new(),
        }
    }

    /// The views that the user remembers, from now on.
    pub(super) fn set_bookmarks(&mut self, bookmarks: Vec<Bookmark>) {
        self.shelf = bookmarks.into_iter().map(Shelved::new).collect();
    }

    /// The name of the path.
    pub(super) fn path_name(&self) -> String {
        self.form.name()
    }

    /// Whether keyframes are to stand at heights above the datum.
    pub(super) fn is_level(&self) -> bool {
        self.form.level
    }

    /// The name that was typed for a view, or one that tells where it is.
    pub(super) fn take_name(&mut self, site: [f64; 2]) -> String {
        let typed = std::mem::take(&mut self.name).trim().to_owned();
        if typed.is_empty() {
            numbers::site(site)
        } else {
            typed
        }
    }

    /// Shows the help, or no longer.
    pub(super) fn toggle_help(&mut self) {
        self.help = !self.help || self.hidden;
        self.hidden = false;
    }

    /// Shows the panel, or no longer.
    pub(super) fn toggle(&mut self) {
        self.open = !self.open || self.hidden;
        self.hidden = false;
    }

    /// Says something for a while.
    pub(super) fn say(&mut self, message: String) {
        self.message = Some((message, Instant::now()));
    }

    /// Counts a frame.
    pub(super) fn count_frame(&mut self, seconds: f64) {
        self.times.count(seconds);
    }

    /// Asks where to go.
    pub(super) fn ask_where(&mut self) {
        self.hidden = false;
        self.going = Some(Default::default());
    }

    /// Closes what is open over the picture. False if nothing was.
    pub(super) fn close(&mut self) -> bool {
        let open = self.help || self.going.is_some();
        self.help = false;
        self.going = None;
        open
    }

    /// When a message is to vanish.
    pub(super) fn vanishes(&self) -> Option<Instant> {
        self.message.as_ref().map(|(_, since)| *since + MESSAGE_TIME)
    }

    /// Lays out a frame.
    pub(super) fn show(&mut self, ctx: &Context, facts: &Facts, choices: &mut Choices, keys: &Keys, asked: &mut Asked) {
        if self.message.as_ref().is_some_and(|(_, since)| since.elapsed() >= MESSAGE_TIME) {
            self.message = None;
        }
        if !self.hidden {
            inspected::draw(ctx, &facts.lines);
            if facts.picked.as_ref().is_some_and(|picked| !inspected::show(ctx, picked)) {
                asked.commands.push(Command::Inspect);
            }
            self.status.show(ctx, facts, choices, &self.times, keys);
            if self.open {
                self.show_panel(ctx, facts, choices, asked);
            }
            self.show_going(ctx, facts, asked);
            if self.help {
                help::show(ctx, keys, &mut self.help);
            }
        }
        // What is said answers a key press, and is said even where all else is hidden.
        if let Some((message, _)) = &self.message {
            let area =
                Area::new(Id::new("message")).anchor(Align2::CENTER_BOTTOM, [0.0, -28.0]).interactable(false).fade_in(false);
            area.show(ctx, |ui| egui::Frame::window(ui.style()).show(ui, |ui| ui.label(message)));
        }
    }

    fn show_panel(&mut self, ctx: &Context, facts: &Facts, choices: &mut Choices, asked: &mut Asked) {
        let height = ctx.content_rect().height();
        let window = Window::new("Panel").title_bar(false).anchor(Align2::LEFT_TOP, [8.0, 30.0]).resizable(false);
        window.fixed_size([WIDTH, height - 76.0]).show(ctx, |ui| {
            ScrollArea::vertical().max_height(height - 76.0).auto_shrink([false, true]).show(ui, |ui| {
                ui.spacing_mut().slider_width = 110.0;
                position::show(ui, facts, asked);
                frames::show(ui, facts, &self.times);
                light::show(ui, facts, choices);
                mesh::show(ui, facts, choices, asked);
                paths::show(ui, facts, &mut self.board, &mut self.form, asked);
                ground::show(ui, facts, &mut self.tool, asked);
                views::show(ui, &mut self.shelf, &mut self.name, asked);
                planets::show(ui, &self.planets, &self.recent, &mut self.opening, asked);
            });
        });
    }

    /// The line to type a place into.
    fn show_going(&mut self, ctx: &Context, facts: &Facts, asked: &mut Asked) {
        let Some((text, problem)) = &mut self.going else { return };
        let mut done = false;
        let window = Window::new("Go to").anchor(Align2::CENTER_TOP, [0.0, 60.0]).resizable(false).collapsible(false);
        window.show(ctx, |ui| {
            let edit = TextEdit::singleline(text).hint_text("46 8, or 46°30'N 8°E 1200 m, or terrane:…").desired_width(340.0);
            let field = ui.add(edit);
            if field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                match destination::parse(text, &facts.named) {
                    Ok(Destination::View(view)) => (asked.view, done) = (Some(view), true),
                    Ok(Destination::Site(site)) => (asked.destination, done) = (Some(site), true),
                    Err(found) => *problem = found,
                }
            }
            done |= ui.input(|input| input.key_pressed(Key::Escape));
            field.request_focus();
            ui.set_max_width(340.0);
            ui.horizontal_wrapped(|ui| {
                for place in &facts.named {
                    if ui.link(&place.name).clicked() {
                        (asked.destination, done) = (Some(Site::of_place(place)), true);
                    }
                }
            });
            if !problem.is_empty() {
                ui.colored_label(ui.visuals().warn_fg_color, problem.as_str());
            }
        });
        if done {
            self.going = None;
        }
    }
}
