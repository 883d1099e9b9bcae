//! `planet.json`: what a published planet is, and where its faces begin.

use super::name::ObjectName;
use crate::globe::lattice::Lattice;
use crate::globe::patch::{MAX_CELLS, MIN_CELLS};
use crate::mesh::certificate::{DEVIATION_SHARE, KAPPA};
use crate::store::record::RECORD_VERSION;
use crate::store::FORMAT_VERSION;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Name of the file.
pub const MANIFEST: &str = "planet.json";

/// Version of this layout.
pub const LAYOUT_VERSION: u32 = 1;

/// Most bytes of a `planet.json` that is read.
pub const MOST_MANIFEST_BYTES: u64 = 1 << 20;

/// What `planet.json` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the layout.
    pub terrane_layout: u32,
    /// Version of planet files whose patches these are.
    pub format: u32,
    /// Version of their records.
    pub record: u16,
    /// Name of the planet.
    pub name: String,
    /// Grid cells along a patch side.
    pub cells: u32,
    /// Metres of a lattice unit.
    pub lattice_unit_m: f64,
    /// Radius of the planet in lattice units.
    pub lattice_radius: f64,
    /// Heights in metres that no point of the ground lies below or above.
    pub height_range_m: [f64; 2],
    /// What the builder takes as given: the coarsest tolerance, and the deviation's share of it.
    pub builder: [f64; 2],
    /// The text of its recipe.
    pub recipe: Reference,
    /// Files that the recipe names.
    pub assets: Vec<NamedReference>,
    /// The map of its clouds, as its record.
    pub clouds: Option<Reference>,
    /// The directories of the six faces, in the order of their numbers.
    pub faces: [Reference; 6],
    /// Patches whose mesh is there.
    pub patches: u64,
    /// Bytes of all objects.
    pub bytes: u64,
    /// The finest level of a patch that is there.
    pub finest_level: u8,
}

/// An object and its length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reference {
    /// Its name.
    pub object: ObjectName,
    /// Its length.
    pub bytes: u32,
}

impl Reference {
    /// Of an object that holds these bytes.
    pub(super) fn to(bytes: &[u8]) -> Reference {
        Reference { object: ObjectName::of(bytes), bytes: bytes.len() as u32 }
    }
}

/// A file that the recipe names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedReference {
    /// Its name in the recipe.
    pub name: String,
    /// Where its bytes are.
    #[serde(flatten)]
    pub reference: Reference,
}

/// Why a `planet.json` cannot be used.
#[derive(Debug, Error)]
pub enum ManifestError {
    /// Not one at all.
    #[error("not a {MANIFEST} of a published planet: {0}; `terrane publish` writes one")]
    Foreign(#[source] serde_json::Error),
    /// Of another version.
    #[error("published with {what} {found}, expected {expected}; {advice}")]
    Version {
        /// Of what.
        what: &'static str,
        /// Its version.
        found: u32,
        /// The version that this program reads.
        expected: u32,
        /// What to do next.
        advice: &'static str,
    },
    /// Of a grid that no patch has.
    #[error("{0} cells along a patch side, expected a power of two from {MIN_CELLS} to {MAX_CELLS}; publish it again")]
    Cells(u32),
    /// Of a builder with other rules.
    #[error("its patches were built for {found:?}, expected {expected:?}: publish it again with this Terrane")]
    Builder {
        /// What the builder took as given.
        found: [f64; 2],
        /// What this program's takes.
        expected: [f64; 2],
    },
}

impl Manifest {
    /// Reads one, and refuses those of other versions.
    ///
    /// # Errors
    /// For bytes that are none, and for another version.
    pub fn parse(bytes: &[u8]) -> Result<Manifest, ManifestError> {
        #[derive(Deserialize)]
        struct Stamp {
            terrane_layout: u32,
        }
        // The version first: of another one nothing else need be as expected.
        let stamp: Stamp = serde_json::from_slice(bytes).map_err(ManifestError::Foreign)?;
        let check = |what, found: u32, expected: u32| {
            let newer = "it was published by a newer Terrane: use that one";
            let older = "it was published by an older Terrane: publish it again";
            let advice = if found > expected { newer } else { older };
            if found == expected {
                Ok(())
            } else {
                Err(ManifestError::Version { what, found, expected, advice })
            }
        };
        check("layout", stamp.terrane_layout, LAYOUT_VERSION)?;
        let manifest: Manifest = serde_json::from_slice(bytes).map_err(ManifestError::Foreign)?;
        check("format", manifest.format, FORMAT_VERSION)?;
        check("records of version", manifest.record.into(), RECORD_VERSION.into())?;
        if !manifest.cells.is_power_of_two() || !(MIN_CELLS..=MAX_CELLS).contains(&manifest.cells) {
            return Err(ManifestError::Cells(manifest.cells));
        }
        let expected = [KAPPA, DEVIATION_SHARE];
        if manifest.builder != expected {
            return Err(ManifestError::Builder { found: manifest.builder, expected });
        }
        Ok(manifest)
    }

    /// The planet's lattice.
    pub fn lattice(&self) -> Lattice {
        Lattice { unit: self.lattice_unit_m, radius: self.lattice_radius }
    }

    /// The bytes of the file.
    pub fn text(&self) -> String {
        // Numbers, texts and lists of them: there is nothing in it that JSON cannot say.
        let mut text = serde_json::to_string_pretty(self).expect("a manifest is plain data");
        text.push('\n');
        text
    }
}
