//! A key with what is held beside it, as text: `Ctrl+Shift+Z`, `F11`, `KeyW`. In: text. Out: whether a key press is meant.

use serde::de::value::{Error, StrDeserializer};
use serde::de::{Deserialize, IntoDeserializer};
use std::str::FromStr;
use winit::keyboard::{Key, KeyCode, ModifiersState, NamedKey, PhysicalKey};

/// A key with what is held beside it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chord {
    held: ModifiersState,
    key: ChordKey,
}

#[derive(Clone, Debug, PartialEq)]
enum ChordKey {
    /// By what it types, in small letters.
    Types(String),
    /// By its name.
    Named(NamedKey),
    /// By its place on the keyboard.
    At(KeyCode),
}

/// A variant of the window library's by its name.
fn named<'a, T: Deserialize<'a>>(name: &'a str) -> Option<T> {
    let deserializer: StrDeserializer<'a, Error> = name.into_deserializer();
    T::deserialize(deserializer).ok()
}

impl Chord {
    /// A place on the keyboard.
    pub(super) fn position(name: &str) -> Option<KeyCode> {
        named(name)
    }

    pub(super) fn asks_for_shift(&self) -> bool {
        self.held.shift_key()
    }

    /// Whether it goes by what a key types, wherever that is on the keyboard.
    pub(super) fn goes_by_text(&self) -> bool {
        matches!(self.key, ChordKey::Types(_))
    }

    /// Whether a press of a key means this, while others are held. Shift may be held beside keys that do not ask for it.
    pub(super) fn fits(&self, physical: PhysicalKey, logical: &Key, held: ModifiersState) -> bool {
        let key = match &self.key {
            ChordKey::Types(text) => matches!(logical, Key::Character(typed) if typed.to_lowercase() == *text),
            ChordKey::Named(name) => *logical == Key::Named(*name),
            ChordKey::At(code) => physical == PhysicalKey::Code(*code),
        };
        let others = ModifiersState::CONTROL | ModifiersState::ALT | ModifiersState::SUPER;
        key && self.held & others == held & others && (held.shift_key() || !self.held.shift_key())
    }
}

impl FromStr for Chord {
    /// What was expected.
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Chord, &'static str> {
        let mut held = ModifiersState::empty();
        let mut rest = text;
        for (prefix, modifier) in
            [("Ctrl+", ModifiersState::CONTROL), ("Alt+", ModifiersState::ALT), ("Shift+", ModifiersState::SHIFT)].repeat(3)
        {
            if let Some(shorter) = rest.strip_prefix(prefix) {
                (rest, held) = (shorter, held | modifier);
            }
        }
        let typed = || Some(rest).filter(|rest| rest.chars().count() == 1).map(|rest| ChordKey::Types(rest.to_lowercase()));
        let key = typed().or_else(|| named(rest).map(ChordKey::Named)).or_else(|| named(rest).map(ChordKey::At));
        let key =
            key.ok_or("a character, or a name such as F5, Escape, ArrowLeft or KeyW, after any of Ctrl+, Alt+ and Shift+")?;
        Ok(Chord { held, key })
    }
}
