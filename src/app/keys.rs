//! What the keys do, in one table for the handler and for the help.

use glam::DVec3;
use std::collections::HashSet;
use terrane_planet::draw::layout::Mode;
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};

/// The help, as the overlay shows it.
pub const HELP: &str = "\
F1           show or hide this help
Esc          quit
Tab          orbit, or free flight
drag         orbit: move the ground; free flight: look around
right drag   look around
wheel, + -   orbit: zoom
WASD, Q E    free flight: move; down and up (also Ctrl and Space)
Shift        free flight: faster
1 to 6       shaded, wire, levels, normals, albedo, depth
M            the next of them
F, L         wire, levels: on and off
C            copy the view as text: for shot, fly and record --view
K            clouds: on and off
G            geomorphs: on and off
Z            freeze the selection, to look at it from elsewhere
P, F12       save a picture
[ ]          move the sun
";

/// What a key press asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Command {
    /// End the program.
    Quit,
    /// Show or hide the help.
    Help,
    /// The other camera.
    SwitchCamera,
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
    /// Save a picture.
    Screenshot,
    /// Move the sun by steps along its daily course.
    Sun(f64),
    /// Zoom by notches.
    Zoom(f64),
}

/// Keys that are held to move. Positions on the keyboard, not letters.
fn is_movement(code: KeyCode) -> bool {
    use KeyCode as K;
    matches!(code, K::KeyW | K::KeyA | K::KeyS | K::KeyD | K::KeyQ | K::KeyE | K::Space)
        || matches!(code, K::ControlLeft | K::ControlRight | K::ShiftLeft | K::ShiftRight)
}

/// What pressing a key asks for, if anything. Digits go by their position, because not all keyboards type them unshifted.
pub(super) fn command(physical: PhysicalKey, logical: &Key) -> Option<Command> {
    if let PhysicalKey::Code(code) = physical {
        let digits = [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3, KeyCode::Digit4, KeyCode::Digit5, KeyCode::Digit6];
        if let Some(number) = digits.iter().position(|digit| *digit == code) {
            return Some(Command::Show(Mode::ALL[number]));
        }
        match code {
            KeyCode::BracketLeft => return Some(Command::Sun(-1.0)),
            KeyCode::BracketRight => return Some(Command::Sun(1.0)),
            _ if is_movement(code) => return None,
            _ => {}
        }
    }
    match logical {
        Key::Named(NamedKey::Escape) => Some(Command::Quit),
        Key::Named(NamedKey::F1) => Some(Command::Help),
        Key::Named(NamedKey::Tab) => Some(Command::SwitchCamera),
        Key::Named(NamedKey::F12) => Some(Command::Screenshot),
        Key::Character(text) => match text.to_lowercase().as_str() {
            "m" => Some(Command::ShowNext),
            "f" => Some(Command::Toggle(Mode::Wire)),
            "l" => Some(Command::Toggle(Mode::Levels)),
            "c" => Some(Command::CopyView),
            "k" => Some(Command::Clouds),
            "g" => Some(Command::Geomorphs),
            "z" => Some(Command::Freeze),
            "p" => Some(Command::Screenshot),
            "+" | "=" => Some(Command::Zoom(1.0)),
            "-" => Some(Command::Zoom(-1.0)),
            _ => None,
        },
        _ => None,
    }
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
        if down && is_movement(code) {
            self.0.insert(code);
        } else {
            self.0.remove(&code);
        }
    }

    /// Forgets all, as when the window loses the keyboard.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Where to: right, up and ahead, each from -1 to 1.
    pub(super) fn wish(&self) -> DVec3 {
        use KeyCode as K;
        let any = |keys: &[K]| f64::from(u8::from(keys.iter().any(|key| self.0.contains(key))));
        DVec3::new(
            any(&[K::KeyD]) - any(&[K::KeyA]),
            any(&[K::KeyE, K::Space]) - any(&[K::KeyQ, K::ControlLeft, K::ControlRight]),
            any(&[K::KeyW]) - any(&[K::KeyS]),
        )
    }

    /// Whether to hurry.
    pub(super) fn hurry(&self) -> bool {
        self.0.contains(&KeyCode::ShiftLeft) || self.0.contains(&KeyCode::ShiftRight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_has_a_key_and_cycling_visits_all() {
        let digit = |code| command(PhysicalKey::Code(code), &Key::Character("&".into()));
        assert_eq!(digit(KeyCode::Digit6), Some(Command::Show(Mode::Depth)));
        let visited: Vec<Mode> = std::iter::successors(Some(Mode::Shaded), |mode| Some(next_mode(*mode))).take(7).collect();
        assert_eq!((&visited[..6], visited[6]), (Mode::ALL, Mode::Shaded));
    }

    #[test]
    fn keys_that_move_command_nothing_whatever_they_type() {
        assert_eq!(command(PhysicalKey::Code(KeyCode::KeyW), &Key::Character("z".into())), None);
        assert_eq!(command(PhysicalKey::Code(KeyCode::KeyY), &Key::Character("z".into())), Some(Command::Freeze));
    }

    #[test]
    fn held_keys_add_up_and_cancel() {
        let mut held = Held::default();
        for code in [KeyCode::KeyW, KeyCode::KeyD, KeyCode::KeyA, KeyCode::ShiftLeft] {
            held.set(PhysicalKey::Code(code), true);
        }
        assert_eq!((held.wish(), held.hurry()), (DVec3::Z, true));
        held.set(PhysicalKey::Code(KeyCode::KeyA), false);
        assert_eq!(held.wish(), DVec3::new(1.0, 0.0, 1.0));
        held.clear();
        assert_eq!((held.wish(), held.hurry()), (DVec3::ZERO, false));
    }
}
