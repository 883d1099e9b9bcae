//! The JSON of tilesets: a subtree of a few levels each, which names the tiles' files and the tilesets below it.

use super::bounds::TileBox;
use super::certify::Promise;
use crate::globe::patch::PatchId;
use serde_json::{json, Value};
use std::collections::HashMap;

/// Levels of one JSON.
pub(super) const LEVELS_A_FILE: u8 = 3;

/// Pixels of screen-space error at which clients refine unless told otherwise: errors are stated so many times larger than they are, so
/// that a client draws them within one pixel.
pub const MOST_PIXELS: f64 = 16.0;

/// A tile as tilesets see it.
pub(super) struct Entry {
    /// Name of its file.
    pub(super) name: String,
    /// Box around it and all below it.
    pub(super) bounds: TileBox,
    pub(super) promise: Promise,
}

/// All tiles of a set, and what its planet is.
pub(super) struct Set<'a> {
    pub(super) entries: &'a HashMap<PatchId, Entry>,
    /// Radius in metres, and name.
    pub(super) radius: f64,
    pub(super) planet: &'a str,
}

impl Set<'_> {
    /// Whether a patch begins a JSON of its own.
    pub(super) fn begins_file(&self, id: PatchId) -> bool {
        id.level > 0 && id.level.is_multiple_of(LEVELS_A_FILE) && self.children(id).is_some()
    }

    fn children(&self, id: PatchId) -> Option<[PatchId; 4]> {
        id.children().filter(|children| self.entries.contains_key(&children[0]))
    }

    /// The JSON that begins at a patch; `inner` are the names of those below it, and `up` leads to the folder that names start from.
    pub(super) fn nested(&self, id: PatchId, inner: &HashMap<PatchId, String>, up: &str) -> Value {
        let mut tile = self.tile(id, inner, up, true);
        tile["refine"] = "REPLACE".into();
        let error = tile["geometricError"].clone();
        json!({ "asset": self.asset(), "geometricError": error, "root": tile })
    }

    /// The first JSON, with the six faces below a root without content.
    pub(super) fn root(&self, inner: &HashMap<PatchId, String>) -> Value {
        let mut bounds = TileBox::of_planet();
        for id in PatchId::roots() {
            self.entries[&id].bounds.corners().into_iter().for_each(|corner| bounds.include(corner));
        }
        let faces: Vec<Value> = PatchId::roots().map(|id| self.tile(id, inner, "", false)).collect();
        // Without it there is nothing: a planet that is a pixel wide is drawn.
        let worst = PatchId::roots().map(|id| self.entries[&id].promise.error).fold(2.0 * self.radius, f64::max);
        let (error, radii) = (MOST_PIXELS * worst, [self.radius; 3]);
        json!({
            "asset": self.asset(),
            "extensionsUsed": ["3DTILES_ellipsoid"],
            "extensions": { "3DTILES_ellipsoid": { "body": self.planet, "radii": radii } },
            "geometricError": error,
            "root": { "boundingVolume": bounds.json(), "geometricError": error, "refine": "REPLACE", "children": faces },
        })
    }

    fn asset(&self) -> Value {
        json!({
            "version": "1.1", "generator": concat!("Terrane ", env!("CARGO_PKG_VERSION")),
            "extras": { "geometric_error": "metres times 16", "up": "+Z north, +X longitude 0" },
        })
    }

    fn tile(&self, id: PatchId, inner: &HashMap<PatchId, String>, up: &str, is_first: bool) -> Value {
        let entry = &self.entries[&id];
        let mut tile = json!({
            "boundingVolume": entry.bounds.json(), "geometricError": MOST_PIXELS * entry.promise.error,
            "extras": { "patch": id.to_string(), "error_m": entry.promise.error },
        });
        let content = |name: &str| json!({ "uri": format!("{up}{name}") });
        if let Some(file) = inner.get(&id).filter(|_| !is_first) {
            tile["content"] = content(file);
            return tile;
        }
        tile["content"] = content(&entry.name);
        if let Some(children) = self.children(id) {
            let children: Vec<Value> = children.into_iter().map(|child| self.tile(child, inner, up, false)).collect();
            tile["children"] = children.into();
        }
        tile
    }
}
