//! A strict reader of TOML tables: takes spanned values out of a parsed document by key, checks type and range, and
//! refuses what nobody asked for. In: recipe text. Out: checked values, or an error with line and key path.
//!
//! Deserialising through serde would lose the line numbers inside tagged tables, so the parsed tree is read directly.

use super::error::RecipeError;
use std::cell::RefCell;
use std::ops::{Range, RangeInclusive};
use toml::de::{DeTable, DeValue};
use toml::Spanned;

/// The text being read, for messages.
pub(crate) struct Source<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// Line (from 1) of a byte offset.
    pub(crate) fn line(&self, offset: usize) -> usize {
        let end = offset.min(self.text.len());
        1 + self.text.as_bytes()[..end].iter().filter(|&&b| b == b'\n').count()
    }
}

/// One TOML table and the keys asked of it so far.
pub(crate) struct Reader<'a> {
    source: &'a Source<'a>,
    path: String,
    /// Byte offset of the table. Its line is counted only for messages: a recipe may have thousands of edits.
    start: usize,
    table: &'a DeTable<'a>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Reader<'a> {
    /// Reads the document's top-level table.
    pub(crate) fn new(source: &'a Source<'a>, table: &'a DeTable<'a>) -> Self {
        Self::nested(source, String::new(), 0, table)
    }

    fn nested(source: &'a Source<'a>, path: String, start: usize, table: &'a DeTable<'a>) -> Self {
        Self { source, path, start, table, asked: RefCell::default() }
    }

    /// Dotted path of a key of this table.
    pub(crate) fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        }
    }

    /// Line of a key's value, or of the table where the key is missing.
    pub(crate) fn line_of(&self, key: &'static str) -> usize {
        self.source.line(self.find(key).map_or(self.start, |v| v.span().start))
    }

    fn find(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&key) {
            asked.push(key);
        }
        self.table.iter().find(|(k, _)| k.get_ref().as_ref() == key).map(|(_, v)| v)
    }

    /// Whether the key is present.
    pub(crate) fn has(&self, key: &'static str) -> bool {
        self.find(key).is_some()
    }

    fn require(&self, key: &'static str, expected: &str) -> Result<&'a Spanned<DeValue<'a>>, RecipeError> {
        self.find(key).ok_or_else(|| self.wrong(key, self.source.line(self.start), "nothing", expected))
    }

    /// An error about a key of this table.
    pub(crate) fn wrong(&self, key: &str, line: usize, found: impl Into<String>, expected: &str) -> RecipeError {
        RecipeError::Value {
            file: self.source.file.into(),
            line,
            path: self.path_of(key).into(),
            found: found.into().into(),
            expected: expected.into(),
        }
    }

    /// An error about the string of a key, which is none of those expected.
    pub(crate) fn wrong_name(&self, key: &'static str, found: &str, expected: &str) -> RecipeError {
        self.wrong(key, self.line_of(key), format!("string \"{found}\""), expected)
    }

    fn wrong_value(&self, key: &str, value: &Spanned<DeValue<'_>>, expected: &str) -> RecipeError {
        self.wrong(key, self.source.line(value.span().start), describe(self.source.text, value), expected)
    }

    /// A number within `range`.
    pub(crate) fn number(&self, key: &'static str, range: RangeInclusive<f64>) -> Result<f64, RecipeError> {
        let expected = number_in(&range);
        let value = self.require(key, &expected)?;
        within(value, &range).ok_or_else(|| self.wrong_value(key, value, &expected))
    }

    /// A number within `range`, or `default` where the key is missing.
    pub(crate) fn number_or(&self, key: &'static str, range: RangeInclusive<f64>, default: f64) -> Result<f64, RecipeError> {
        if self.has(key) {
            self.number(key, range)
        } else {
            Ok(default)
        }
    }

    /// true or false; false where the key is missing.
    pub(crate) fn flag(&self, key: &'static str) -> Result<bool, RecipeError> {
        let Some(value) = self.find(key) else { return Ok(false) };
        value.get_ref().as_bool().ok_or_else(|| self.wrong_value(key, value, "true or false"))
    }

    /// A whole number from 0 to 2^63 - 1.
    pub(crate) fn whole(&self, key: &'static str) -> Result<u64, RecipeError> {
        let expected = "a whole number from 0 to 2^63 - 1";
        let value = self.require(key, expected)?;
        let whole = value.get_ref().as_integer().and_then(|i| i64::from_str_radix(i.as_str(), i.radix()).ok());
        whole.and_then(|i| u64::try_from(i).ok()).ok_or_else(|| self.wrong_value(key, value, expected))
    }

    /// A non-empty string.
    pub(crate) fn string(&self, key: &'static str, expected: &str) -> Result<String, RecipeError> {
        let value = self.require(key, expected)?;
        match value.get_ref().as_str() {
            Some(text) if !text.is_empty() => Ok(text.to_owned()),
            _ => Err(self.wrong_value(key, value, expected)),
        }
    }

    /// A non-empty string, or an array of one or more of them.
    pub(crate) fn strings(&self, key: &'static str, expected: &str) -> Result<Vec<String>, RecipeError> {
        let value = self.require(key, expected)?;
        let text = |value: &Spanned<DeValue<'_>>| value.get_ref().as_str().filter(|text| !text.is_empty()).map(str::to_owned);
        let all = match value.get_ref().as_array() {
            Some(array) => array.iter().map(text).collect(),
            None => text(value).map(|text| vec![text]),
        };
        all.filter(|all| !all.is_empty()).ok_or_else(|| self.wrong_value(key, value, expected))
    }

    /// An array of exactly `N` numbers, each within `range`.
    pub(crate) fn numbers<const N: usize>(&self, key: &'static str, range: RangeInclusive<f64>) -> Result<[f64; N], RecipeError> {
        let expected = format!("{N} values, each {}", number_in(&range));
        let value = self.require(key, &expected)?;
        fixed(value, &range).ok_or_else(|| self.wrong_value(key, value, &expected))
    }

    /// One number within `range` for red, green and blue alike, or three.
    pub(crate) fn number_or_numbers(&self, key: &'static str, range: RangeInclusive<f64>) -> Result<[f64; 3], RecipeError> {
        let expected = format!("{}, or three of them", number_in(&range));
        let value = self.require(key, &expected)?;
        let one = within(value, &range).map(|number| [number; 3]);
        one.or_else(|| fixed(value, &range)).ok_or_else(|| self.wrong_value(key, value, &expected))
    }

    /// Two numbers within `range`, the first below the second.
    pub(crate) fn span(&self, key: &'static str, range: RangeInclusive<f64>) -> Result<[f64; 2], RecipeError> {
        let pair: [f64; 2] = self.numbers(key, range)?;
        if pair[0] < pair[1] {
            return Ok(pair);
        }
        let value = self.require(key, "")?;
        Err(self.wrong_value(key, value, "two values, the first below the second"))
    }

    /// `[x, y]` pairs, at least two, x and y both rising (y may stay level).
    pub(crate) fn rising_pairs(&self, key: &'static str) -> Result<Vec<[f64; 2]>, RecipeError> {
        let expected = "an array of at least two [position, metres] pairs, positions in -2 to 2 rising, metres in \
                        -100000 to 100000 never falling";
        let value = self.require(key, expected)?;
        let fault = || self.wrong_value(key, value, expected);
        let array = value.get_ref().as_array().ok_or_else(fault)?;
        let pairs: Option<Vec<[f64; 2]>> = array.iter().map(|v| fixed(v, &(-1e5..=1e5))).collect();
        let pairs = pairs.ok_or_else(fault)?;
        let rising = pairs.windows(2).all(|w| w[0][0] < w[1][0] && w[0][1] <= w[1][1]);
        let bounded = pairs.iter().all(|p| p[0].abs() <= 2.0);
        if pairs.len() >= 2 && rising && bounded {
            Ok(pairs)
        } else {
            Err(fault())
        }
    }

    /// A nested table, if present.
    pub(crate) fn table(&self, key: &'static str) -> Result<Option<Reader<'a>>, RecipeError> {
        let Some(value) = self.find(key) else { return Ok(None) };
        let table = value.get_ref().as_table().ok_or_else(|| self.wrong_value(key, value, "a table"))?;
        Ok(Some(Self::nested(self.source, self.path_of(key), value.span().start, table)))
    }

    /// An array of tables; empty where the key is missing.
    pub(crate) fn tables(&self, key: &'static str) -> Result<Vec<Reader<'a>>, RecipeError> {
        let Some(value) = self.find(key) else {
            return Ok(Vec::new());
        };
        let expected = "an array of tables";
        let array = value.get_ref().as_array().ok_or_else(|| self.wrong_value(key, value, expected))?;
        let read = |(index, item): (usize, &'a Spanned<DeValue<'a>>)| {
            let table = item.get_ref().as_table().ok_or_else(|| self.wrong_value(key, item, expected))?;
            let path = format!("{}[{index}]", self.path_of(key));
            Ok(Self::nested(self.source, path, item.span().start, table))
        };
        array.iter().enumerate().map(read).collect()
    }

    /// Refuses keys that were never asked for. Call last.
    pub(crate) fn finish(&self) -> Result<(), RecipeError> {
        let asked = self.asked.borrow();
        match self.table.keys().find(|k| !asked.contains(&k.get_ref().as_ref())) {
            None => Ok(()),
            Some(key) => Err(RecipeError::UnknownKey {
                file: self.source.file.into(),
                line: self.source.line(key.span().start),
                path: self.path_of(key.get_ref()).into(),
                expected: asked.join(", ").into(),
            }),
        }
    }
}

fn number_in(range: &RangeInclusive<f64>) -> String {
    format!("a number from {} to {}", range.start(), range.end())
}

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    let text = match value {
        DeValue::Integer(i) if i.radix() == 10 => i.as_str(),
        DeValue::Float(f) => f.as_str(),
        _ => return None,
    };
    text.parse().ok()
}

// A NaN is in no range.
fn within(value: &Spanned<DeValue<'_>>, range: &RangeInclusive<f64>) -> Option<f64> {
    as_number(value.get_ref()).filter(|n| range.contains(n))
}

fn fixed<const N: usize>(value: &Spanned<DeValue<'_>>, range: &RangeInclusive<f64>) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = value.get_ref().as_array()?.iter().map(|v| within(v, range)).collect();
    numbers?.try_into().ok()
}

/// Type and text of a value, shortened, for messages.
fn describe(text: &str, value: &Spanned<DeValue<'_>>) -> String {
    let Range { start, end } = value.span();
    let shown: String = text.get(start..end).unwrap_or_default().chars().take(60).collect();
    let kind = value.get_ref().type_str();
    format!("{kind} {}", shown.lines().next().unwrap_or_default())
}
