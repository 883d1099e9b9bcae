//! Names of objects: the first bytes of the SHA-256 of what they hold.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use sha2::{Digest, Sha256};
use std::fmt;

/// Bytes of a name.
const BYTES: usize = 16;

/// The name of an object, which says what it holds.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ObjectName([u8; BYTES]);

impl ObjectName {
    /// The name of what holds these bytes.
    pub fn of(bytes: &[u8]) -> ObjectName {
        let digest: [u8; 32] = Sha256::digest(bytes).into();
        let mut name = [0; BYTES];
        name.copy_from_slice(&digest[..BYTES]);
        ObjectName(name)
    }

    /// As it stands in a directory.
    pub(super) fn bytes(&self) -> [u8; BYTES] {
        self.0
    }

    /// The name that [`ObjectName::bytes`] gave.
    pub(super) fn from_bytes(bytes: [u8; BYTES]) -> ObjectName {
        ObjectName(bytes)
    }

    /// The name of 32 hexadecimal digits in lower case; `None` for anything else.
    pub fn parse(text: &str) -> Option<ObjectName> {
        let digit = |d: &u8| matches!(d, b'0'..=b'9' | b'a'..=b'f');
        if text.len() != 2 * BYTES || !text.bytes().all(|d| digit(&d)) {
            return None;
        }
        let mut name = [0; BYTES];
        for (k, byte) in name.iter_mut().enumerate() {
            *byte = u8::from_str_radix(&text[2 * k..2 * k + 2], 16).ok()?;
        }
        Some(ObjectName(name))
    }

    /// Where it lies, from the folder of `planet.json`: spread over 256 folders.
    pub fn path(&self) -> String {
        format!("objects/{:02x}/{self}", self.0[0])
    }
}

impl fmt::Display for ObjectName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for ObjectName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Serialize for ObjectName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ObjectName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        ObjectName::parse(&text).ok_or_else(|| {
            serde::de::Error::custom(format!("'{text}' is no name of an object: expected 32 digits, 0 to 9 and a to f"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_other_programs() {
        // The first 32 digits of sha256sum.
        let name = ObjectName::of(b"abc");
        assert_eq!(name.to_string(), "ba7816bf8f01cfea414140de5dae2223");
        assert_eq!(name.path(), "objects/ba/ba7816bf8f01cfea414140de5dae2223");
        assert_eq!(ObjectName::parse(&name.to_string()), Some(name));
        for wrong in [
            "",
            "ba7816bf",
            "BA7816BF8F01CFEA414140DE5DAE2223",
            "../16bf8f01cfea414140de5dae2223xx",
            "ß7816bf8f01cfea414140de5dae222",
        ] {
            assert_eq!(ObjectName::parse(wrong), None, "{wrong}");
        }
    }
}
