//! The parts of a view's text: `key=value` or `key`, between slashes. In: text. Out: each part once, or what is wrong with it and where.

use super::{ViewLineError, SCHEME, VERSION};
use std::ops::RangeInclusive;

/// Characters of text that is no view to repeat in a message.
const SHOWN: usize = 40;

struct Part<'a> {
    /// Where it begins, in characters from 1.
    at: usize,
    text: &'a str,
}

/// The parts that were not taken yet, and what was asked for.
pub(super) struct Parts<'a> {
    all: Vec<Part<'a>>,
    taken: Vec<usize>,
    keys: Vec<&'static str>,
}

impl<'a> Parts<'a> {
    pub(super) fn of(text: &'a str) -> Result<Parts<'a>, ViewLineError> {
        let text = text.trim();
        let Some(rest) = text.strip_prefix(SCHEME) else {
            return Err(ViewLineError::Foreign { found: text.chars().take(SHOWN).collect() });
        };
        let mut texts = rest.split('/');
        let version = texts.next().unwrap_or_default();
        if version != VERSION.to_string() {
            return Err(ViewLineError::Version { found: version.chars().take(SHOWN).collect() });
        }
        let mut at = SCHEME.len() + version.len() + 2;
        let place = |text: &'a str| {
            let part = Part { at, text };
            at += text.chars().count() + 1;
            part
        };
        Ok(Parts { all: texts.map(place).collect(), taken: Vec::new(), keys: Vec::new() })
    }

    /// The value of a key, if it is there.
    pub(super) fn take<T>(
        &mut self,
        key: &'static str,
        expected: &str,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, ViewLineError> {
        let Some(part) = self.find(key)? else { return Ok(None) };
        match part.text.split_once('=') {
            Some((_, value)) => match read(value) {
                Some(read) => Ok(Some(read)),
                None => Err(part.wrong(format!("'{value}'"), expected)),
            },
            None => Err(part.wrong("no value".into(), &format!("{key}=VALUE: {expected}"))),
        }
    }

    /// A number within a range.
    pub(super) fn number(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
        expected: &str,
    ) -> Result<Option<f64>, ViewLineError> {
        self.take(key, expected, |text| text.parse().ok().filter(|number| range.contains(number)))
    }

    /// One of some whole numbers.
    pub(super) fn one_of(&mut self, key: &'static str, values: &[u32], expected: &str) -> Result<Option<u32>, ViewLineError> {
        self.take(key, expected, |text| text.parse().ok().filter(|number| values.contains(number)))
    }

    /// Whether a key without a value is there.
    pub(super) fn flag(&mut self, key: &'static str) -> Result<bool, ViewLineError> {
        match self.find(key)? {
            Some(part) if part.text != key => Err(part.wrong("a value".into(), &format!("{key} with no value"))),
            part => Ok(part.is_some()),
        }
    }

    /// Two keys that exclude one another.
    pub(super) fn both(&self, one: &str, other: &str) -> ViewLineError {
        let wrong = |part: &Part<'_>| part.wrong(format!("both {one} and {other}"), "one of them");
        let second = self.all.iter().filter(|part| part.is(one) || part.is(other)).nth(1);
        second.map_or(ViewLineError::Missing { missing: "at", expected: "one site" }, wrong)
    }

    /// Refuses what is left.
    pub(super) fn finish(self) -> Result<(), ViewLineError> {
        let left = (0..self.all.len()).find(|number| !self.taken.contains(number));
        let expected = format!("one of {}", self.keys.join(", "));
        left.map_or(Ok(()), |number| Err(self.all[number].wrong("an unknown key".into(), &expected)))
    }

    fn find(&mut self, key: &'static str) -> Result<Option<&Part<'a>>, ViewLineError> {
        self.keys.push(key);
        let mut found = (0..self.all.len()).filter(|&number| self.all[number].is(key));
        let Some(first) = found.next() else { return Ok(None) };
        if let Some(second) = found.next() {
            return Err(self.all[second].wrong("it twice".into(), &format!("{key} once")));
        }
        self.taken.push(first);
        Ok(Some(&self.all[first]))
    }
}

impl Part<'_> {
    fn is(&self, key: &str) -> bool {
        self.text.split('=').next() == Some(key)
    }

    fn wrong(&self, found: String, expected: &str) -> ViewLineError {
        ViewLineError::Part { at: self.at, part: self.text.into(), found, expected: expected.into() }
    }
}

/// Two finite numbers with a comma between them.
pub(super) fn numbers(text: &str) -> Option<[f64; 2]> {
    let (a, b) = text.split_once(',')?;
    let numbers = [a.parse::<f64>().ok()?, b.parse::<f64>().ok()?];
    numbers.iter().all(|number| number.is_finite()).then_some(numbers)
}

/// Text of letters, digits, `-`, `_` and `.` alone; `%` and two hexadecimal digits for each byte of anything else.
pub(super) fn escape(text: &str) -> String {
    let escaped = |byte: u8| match byte {
        b'-' | b'_' | b'.' => char::from(byte).to_string(),
        _ if byte.is_ascii_alphanumeric() => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    text.bytes().map(escaped).collect()
}

/// What [`escape`] was given; `None` for what it does not give.
pub(super) fn unescape(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        let plain = byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
        bytes.push(match byte {
            b'%' => 16 * hexadecimal(rest.next()?)? + hexadecimal(rest.next()?)?,
            _ if plain => byte,
            _ => return None,
        });
    }
    String::from_utf8(bytes).ok()
}

fn hexadecimal(digit: u8) -> Option<u8> {
    char::from(digit).to_digit(16).and_then(|value| u8::try_from(value).ok())
}
