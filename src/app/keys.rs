//! What the keys do: one table for the handler, for the help, and for the file that changes it.
//!
//! In: a TOML file such as `terrane fly --keys` prints. Out: which command or motion a key stands for.

use super::chord::Chord;
use glam::DVec3;
use std::collections::{BTreeMap, HashSet};
use std::fmt::Write as _;
use terrane_planet::draw::layout::Mode;
use thiserror::Error;
use winit::keyboard::{Key, KeyCode, ModifiersState, PhysicalKey};

/// What a key press, or a button of the panel, asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Command {
    /// Close what is open, or end the program.
    Quit,
    /// Show or hide the help.
    Help,
    /// Show or hide the panel.
    Panel,
    /// Show or hide everything but the picture.
    Hide,
    /// Type where to go.
    GoTo,
    /// The next of the cameras.
    SwitchCamera,
    /// Fly back to where the window began.
    Home,
    /// Turn towards north.
    North,
    /// Look at the horizon.
    Horizon,
    /// Fly to the place before, or to the one after it.
    Back,
    Forward,
    /// Remember this view.
    Bookmark,
    /// A mode.
    Show(Mode),
    /// The next mode.
    ShowNext,
    /// A mode, or the shaded one if it is on already.
    Toggle(Mode),
    /// Copy the view as text.
    CopyView,
    /// Clouds on or off.
    Clouds,
    /// Geomorphs on or off.
    Geomorphs,
    /// Freeze or thaw the selection.
    Freeze,
    /// Pick what is under the cursor, or no longer.
    Inspect,
    /// Add a keyframe to the path where the viewer is; play the path, or stop.
    AddKeyframe,
    Play,
    /// Film the path.
    Film,
    /// Take the tool that changes the ground in hand, or put it away.
    Tool,
    /// Without the last edit of the ground, or with the one undone last.
    Undo,
    Redo,
    /// Save a picture; with the interface in it, if `true`.
    Screenshot(bool),
    /// Fill the screen, or no longer.
    Fullscreen,
    /// Move the sun by steps along its daily course.
    Sun(f64),
    /// Zoom by notches.
    Zoom(f64),
}

/// Where keys that are held move the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Ahead,
    Behind,
    Left,
    Right,
    Up,
    Down,
    Hurry,
}

/// Something that keys can do: its name in files, its keys unless a file says otherwise, and what it is in words.
struct Action<T> {
    name: &'static str,
    keys: &'static [&'static str],
    words: &'static str,
    does: T,
}

const fn action<T>(name: &'static str, keys: &'static [&'static str], words: &'static str, does: T) -> Action<T> {
    Action { name, keys, words, does }
}

const COMMANDS: [Action<Command>; 41] = [
    action("help", &["F1"], "show or hide this list", Command::Help),
    action("panel", &["F2"], "show or hide the panel", Command::Panel),
    action("hide", &["F3"], "show or hide everything but the picture", Command::Hide),
    action("go_to", &["G"], "go to a place: latitude and longitude, a height, or a view", Command::GoTo),
    action("camera", &["Tab"], "orbit, free flight, or walk", Command::SwitchCamera),
    action("home", &["Home"], "fly back to where the window began", Command::Home),
    action("north", &["N"], "turn towards north", Command::North),
    action("horizon", &["H"], "look at the horizon", Command::Horizon),
    action("back", &["Alt+ArrowLeft", "Backspace"], "fly to the place before", Command::Back),
    action("forward", &["Alt+ArrowRight"], "fly to the place after it", Command::Forward),
    action("bookmark", &["B"], "remember this view", Command::Bookmark),
    action("copy_view", &["C"], "copy the view as text: for shot, fly and record --view", Command::CopyView),
    action("picture", &["P", "F12"], "save a picture", Command::Screenshot(false)),
    action("picture_of_window", &["Shift+P"], "save a picture with panel and text in it", Command::Screenshot(true)),
    action("fullscreen", &["F11"], "fill the screen, or no longer", Command::Fullscreen),
    action("shaded", &["Digit1"], "the ground as it looks", Command::Show(Mode::Shaded)),
    action("wire", &["Digit2"], "triangles", Command::Show(Mode::Wire)),
    action("levels", &["Digit3"], "levels of patches", Command::Show(Mode::Levels)),
    action("normals", &["Digit4"], "normals", Command::Show(Mode::Normals)),
    action("albedo", &["Digit5"], "albedo", Command::Show(Mode::Albedo)),
    action("depth", &["Digit6"], "depth", Command::Show(Mode::Depth)),
    action("wake", &["Digit7"], "how long vertices have been awake", Command::Show(Mode::Wake)),
    action("error", &["Digit8"], "how much of the tolerance the mesh's error takes", Command::Show(Mode::Error)),
    action("next_mode", &["M"], "the next of them", Command::ShowNext),
    action("toggle_wire", &["F"], "triangles on and off", Command::Toggle(Mode::Wire)),
    action("toggle_levels", &["L"], "levels on and off", Command::Toggle(Mode::Levels)),
    action("clouds", &["K"], "clouds on and off", Command::Clouds),
    action("geomorphs", &["T"], "geomorphs on and off", Command::Geomorphs),
    action("freeze", &["Z"], "freeze the selection, to look at it from elsewhere", Command::Freeze),
    action("inspect", &["I"], "pick what is under the cursor: its patch and what is known of it", Command::Inspect),
    action("add_keyframe", &["R"], "add a keyframe to the path, where the viewer is", Command::AddKeyframe),
    action("play", &["Enter"], "play the path, or stop", Command::Play),
    action("film", &["Shift+R"], "film the path: an mp4 beside the pictures", Command::Film),
    action("tool", &["X"], "take the tool in hand that changes the ground with a click, or put it away", Command::Tool),
    action("undo", &["Ctrl+Z"], "undo the last change of the ground", Command::Undo),
    action("redo", &["Ctrl+Y", "Ctrl+Shift+Z"], "do it again", Command::Redo),
    action("sun_earlier", &["BracketLeft"], "move the sun back", Command::Sun(-1.0)),
    action("sun_later", &["BracketRight"], "move the sun on", Command::Sun(1.0)),
    action("zoom_in", &["+", "="], "orbit: come nearer", Command::Zoom(1.0)),
    action("zoom_out", &["-"], "orbit: go away", Command::Zoom(-1.0)),
    action("quit", &["Escape"], "close what is open, or the window", Command::Quit),
];

const MOTIONS: [Action<Motion>; 7] = [
    action("ahead", &["KeyW", "ArrowUp"], "free flight, walk: move ahead", Motion::Ahead),
    action("behind", &["KeyS", "ArrowDown"], "back", Motion::Behind),
    action("left", &["KeyA", "ArrowLeft"], "to the left", Motion::Left),
    action("right", &["KeyD", "ArrowRight"], "to the right", Motion::Right),
    action("up", &["KeyE", "Space"], "up", Motion::Up),
    action("down", &["KeyQ"], "down", Motion::Down),
    action("hurry", &["ShiftLeft", "ShiftRight"], "faster", Motion::Hurry),
];

/// What the mouse does.
pub(super) const MOUSE: [(&str, &str); 5] = [
    ("drag", "orbit: move the ground; free flight, walk: look around"),
    ("right drag", "look around"),
    ("double click", "fly to what is there"),
    ("wheel", "orbit: zoom to the cursor; free flight, walk: speed"),
    ("drop a file", "open a planet or a view"),
];

/// Why a file of keys cannot be used.
#[derive(Debug, Error)]
pub enum KeysError {
    /// It is no TOML of the right shape.
    #[error("not a table of keys: {0}; `terrane fly --keys` prints one")]
    Shape(#[from] toml::de::Error),
    /// Nothing is called that.
    #[error("'{name}' is nothing that keys do, expected one of {expected}")]
    Name {
        /// What was found.
        name: String,
        /// All names.
        expected: String,
    },
    /// There is no such key.
    #[error("{name}: '{found}' is no key, expected {expected}")]
    Key {
        /// For what.
        name: String,
        /// What was found.
        found: String,
        /// What it can be.
        expected: &'static str,
    },
    /// A key for two things.
    #[error("'{key}' is given to both {first} and {second}; take it from one of them")]
    Twice {
        /// The key.
        key: String,
        /// What it does.
        first: &'static str,
        /// What it was to do, too.
        second: &'static str,
    },
}

/// Which key does what.
#[derive(Clone, Debug)]
pub struct Keys {
    commands: Vec<(Chord, Command)>,
    motions: Vec<(KeyCode, Motion)>,
    /// The keys of every name, in the order of the tables.
    named: Vec<(&'static str, Vec<String>, &'static str)>,
}

impl Default for Keys {
    fn default() -> Keys {
        // The tables are right: a test looks at them.
        Keys::of(&BTreeMap::new()).unwrap_or(Keys { commands: Vec::new(), motions: Vec::new(), named: Vec::new() })
    }
}

impl Keys {
    /// The usual keys, but for what a TOML file says otherwise: lists of keys by name.
    ///
    /// # Errors
    /// A name or a key that does not exist, or a key with two meanings.
    pub fn from_toml(text: &str) -> Result<Keys, KeysError> {
        let changed: BTreeMap<String, Vec<String>> = toml::from_str(text)?;
        let names: Vec<&str> = COMMANDS.iter().map(|a| a.name).chain(MOTIONS.iter().map(|a| a.name)).collect();
        match changed.keys().find(|name| !names.contains(&name.as_str())) {
            Some(name) => Err(KeysError::Name { name: name.clone(), expected: names.join(", ") }),
            None => Keys::of(&changed),
        }
    }

    fn of(changed: &BTreeMap<String, Vec<String>>) -> Result<Keys, KeysError> {
        let mut keys = Keys { commands: Vec::new(), motions: Vec::new(), named: Vec::new() };
        let written = |name: &str, usual: &[&str]| {
            changed.get(name).cloned().unwrap_or_else(|| usual.iter().map(|key| (*key).to_owned()).collect())
        };
        let wrong =
            |name: &str, found: &str, expected| KeysError::Key { name: name.to_owned(), found: found.to_owned(), expected };
        for Action { name, keys: usual, words, does } in &COMMANDS {
            let list = written(name, usual);
            for key in &list {
                let chord: Chord = key.parse().map_err(|expected| wrong(name, key, expected))?;
                keys.commands.push((chord, *does));
            }
            keys.named.push((name, list, words));
        }
        for Action { name, keys: usual, words, does } in &MOTIONS {
            let list = written(name, usual);
            for key in &list {
                let code =
                    Chord::position(key).ok_or_else(|| wrong(name, key, "a position on the keyboard such as KeyW or ArrowUp"))?;
                keys.motions.push((code, *does));
            }
            keys.named.push((name, list, words));
        }
        keys.check_once()?;
        Ok(keys)
    }

    fn check_once(&self) -> Result<(), KeysError> {
        let mut seen: BTreeMap<String, &'static str> = BTreeMap::new();
        for (name, keys, _) in &self.named {
            for key in keys {
                if let Some(first) = seen.insert(key.to_lowercase(), name) {
                    return Err(KeysError::Twice { key: key.clone(), first, second: name });
                }
            }
        }
        Ok(())
    }

    /// The keys as a TOML file, with what each does beside it.
    pub fn to_toml(&self) -> String {
        let mut text = String::from(
            "# Keys of terrane fly. Letters stand for what a key types, names such as KeyW for its place on a keyboard of the United States;\n\
             # Ctrl+, Shift+ and Alt+ may go before. An empty list takes all keys away.\n",
        );
        for (name, keys, words) in &self.named {
            let list: Vec<String> = keys.iter().map(|key| format!("{key:?}")).collect();
            let _ = writeln!(text, "{:<42} # {words}", format!("{name} = [{}]", list.join(", ")));
        }
        text
    }

    /// Keys and what they do, as rows; the mouse after them.
    pub(super) fn rows(&self) -> impl Iterator<Item = (String, &'static str)> + '_ {
        let keys = self.named.iter().filter(|(_, keys, _)| !keys.is_empty());
        let keys = keys.map(|(_, keys, words)| (keys.iter().map(|key| key_name(key)).collect::<Vec<_>>().join(", "), *words));
        keys.chain(MOUSE.iter().map(|(what, words)| ((*what).to_owned(), *words)))
    }

    /// The keys as text of two columns.
    pub fn help(&self) -> String {
        self.rows().fold(String::new(), |text, (keys, words)| format!("{text}{keys:<26} {words}\n"))
    }

    /// The keys of a command, such as `F2`.
    pub(super) fn of_command(&self, command: Command) -> String {
        let at = COMMANDS.iter().position(|action| action.does == command);
        at.and_then(|at| self.named.get(at))
            .map_or(String::new(), |(_, keys, _)| keys.iter().map(|key| key_name(key)).collect::<Vec<_>>().join(", "))
    }

    /// What pressing a key asks for, if anything. Where keys move the viewer, those that do mean nothing by what they happen to type.
    pub(super) fn command(&self, physical: PhysicalKey, logical: &Key, held: ModifiersState, moves: bool) -> Option<Command> {
        let moves = moves && matches!(physical, PhysicalKey::Code(code) if self.motion(code).is_some());
        let fits = |chord: &Chord| chord.fits(physical, logical, held) && !(moves && chord.goes_by_text());
        let all = self.commands.iter().filter(|(chord, _)| fits(chord));
        // With Shift held, what asks for it goes first; else Shift only hurries.
        all.max_by_key(|(chord, _)| chord.asks_for_shift()).map(|(_, command)| *command)
    }

    fn motion(&self, code: KeyCode) -> Option<Motion> {
        self.motions.iter().find(|(key, _)| *key == code).map(|(_, motion)| *motion)
    }

    /// Where held keys move: right, up and ahead, each from -1 to 1.
    pub(super) fn wish(&self, held: &Held) -> DVec3 {
        let any = |motion: Motion| f64::from(u8::from(held.0.iter().any(|code| self.motion(*code) == Some(motion))));
        DVec3::new(
            any(Motion::Right) - any(Motion::Left),
            any(Motion::Up) - any(Motion::Down),
            any(Motion::Ahead) - any(Motion::Behind),
        )
    }

    /// Whether held keys hurry.
    pub(super) fn hurries(&self, held: &Held) -> bool {
        held.0.iter().any(|code| self.motion(*code) == Some(Motion::Hurry))
    }
}

/// A key as the help calls it.
fn key_name(key: &str) -> String {
    key.replace("BracketLeft", "[")
        .replace("BracketRight", "]")
        .replace("Arrow", "")
        .replace("Key", "")
        .replace("Digit", "")
        .replace("Escape", "Esc")
}

/// The mode after another.
pub(super) fn next_mode(mode: Mode) -> Mode {
    let at = Mode::ALL.iter().position(|m| *m == mode).unwrap_or(0);
    Mode::ALL[(at + 1) % Mode::ALL.len()]
}

/// The keys that are held down.
#[derive(Default)]
pub(super) struct Held(HashSet<KeyCode>);

impl Held {
    /// Notes a key going down or up.
    pub(super) fn set(&mut self, physical: PhysicalKey, down: bool) {
        let PhysicalKey::Code(code) = physical else { return };
        if down {
            self.0.insert(code);
        } else {
            self.0.remove(&code);
        }
    }

    /// Forgets all, as when the window loses the keyboard.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use winit::keyboard::NamedKey;

    const NONE: ModifiersState = ModifiersState::empty();

    fn typed(keys: &Keys, code: KeyCode, text: &str, held: ModifiersState) -> Option<Command> {
        keys.command(PhysicalKey::Code(code), &Key::Character(text.into()), held, false)
    }

    #[test]
    fn the_usual_keys_are_all_there_and_come_back_from_their_file() {
        let keys = Keys::default();
        assert_eq!(keys.named.len(), COMMANDS.len() + MOTIONS.len());
        assert_eq!(Keys::from_toml(&keys.to_toml()).unwrap().named, keys.named);
    }

    #[test]
    fn every_mode_has_a_key_and_cycling_visits_all() {
        let keys = Keys::default();
        assert_eq!(typed(&keys, KeyCode::Digit8, "&", NONE), Some(Command::Show(Mode::Error)));
        let visited: Vec<Mode> = std::iter::successors(Some(Mode::Shaded), |mode| Some(next_mode(*mode))).take(9).collect();
        assert_eq!((&visited[..8], visited[8]), (Mode::ALL, Mode::Shaded));
    }

    #[test]
    fn letters_go_by_what_they_type_and_shift_means_something_only_where_it_is_asked_for() {
        let keys = Keys::default();
        assert_eq!(typed(&keys, KeyCode::KeyY, "z", NONE), Some(Command::Freeze));
        assert_eq!(typed(&keys, KeyCode::KeyY, "Z", ModifiersState::SHIFT), Some(Command::Freeze));
        assert_eq!(typed(&keys, KeyCode::KeyP, "P", ModifiersState::SHIFT), Some(Command::Screenshot(true)));
        assert_eq!(typed(&keys, KeyCode::KeyP, "p", NONE), Some(Command::Screenshot(false)));
        assert_eq!(typed(&keys, KeyCode::KeyP, "p", ModifiersState::CONTROL), None);
        let arrow = |held| keys.command(PhysicalKey::Code(KeyCode::ArrowLeft), &Key::Named(NamedKey::ArrowLeft), held, true);
        assert_eq!((arrow(NONE), arrow(ModifiersState::ALT)), (None, Some(Command::Back)));
    }

    #[test]
    fn keys_that_move_command_nothing_whatever_they_type() {
        let keys = Keys::default();
        let pressed = |code, moves| keys.command(PhysicalKey::Code(code), &Key::Character("z".into()), NONE, moves);
        // As on a keyboard of France.
        assert_eq!([pressed(KeyCode::KeyW, true), pressed(KeyCode::KeyW, false)], [None, Some(Command::Freeze)]);
        assert_eq!(pressed(KeyCode::KeyY, true), Some(Command::Freeze));
    }

    #[test]
    fn a_file_changes_what_it_names_and_nothing_else() {
        let keys = Keys::from_toml("freeze = [\"J\"]\nahead = [\"KeyZ\"]\n").unwrap();
        assert_eq!(typed(&keys, KeyCode::KeyJ, "j", NONE), Some(Command::Freeze));
        assert_eq!(typed(&keys, KeyCode::KeyZ, "z", NONE), None);
        assert_eq!(typed(&keys, KeyCode::KeyN, "n", NONE), Some(Command::North));
        let mut held = Held::default();
        held.set(PhysicalKey::Code(KeyCode::KeyZ), true);
        assert_eq!(keys.wish(&held), DVec3::Z);
    }

    #[test]
    fn a_file_that_cannot_be_meant_is_refused_with_what_is_wrong() {
        let message = |text: &str| Keys::from_toml(text).unwrap_err().to_string();
        assert!(message("freeze = 3").contains("not a table of keys"));
        assert!(message("frieze = []").contains("'frieze' is nothing that keys do"));
        assert!(message("freeze = [\"Hyper+Z\"]").contains("'Hyper+Z' is no key"));
        assert!(message("ahead = [\"w\"]").contains("a position on the keyboard"));
        assert!(message("freeze = [\"n\"]").contains("given to both north and freeze"), "{}", message("freeze = [\"n\"]"));
    }

    #[test]
    fn held_keys_add_up_and_cancel() {
        let (keys, mut held) = (Keys::default(), Held::default());
        for code in [KeyCode::KeyW, KeyCode::KeyD, KeyCode::KeyA, KeyCode::ShiftLeft] {
            held.set(PhysicalKey::Code(code), true);
        }
        assert_eq!((keys.wish(&held), keys.hurries(&held)), (DVec3::Z, true));
        held.set(PhysicalKey::Code(KeyCode::KeyA), false);
        assert_eq!(keys.wish(&held), DVec3::new(1.0, 0.0, 1.0));
        held.clear();
        assert_eq!((keys.wish(&held), keys.hurries(&held)), (DVec3::ZERO, false));
    }
}
