//! The views of the gallery, as `tools/gallery.toml` lists them.

use serde::Deserialize;

#[derive(Deserialize)]
struct List {
    picture: Vec<Entry>,
}

/// A view.
#[derive(Deserialize)]
pub(crate) struct Entry {
    /// Name of the picture.
    pub(crate) name: String,
    /// A recipe that comes with the command.
    pub(crate) recipe: String,
    /// Those of `terrane shot`.
    pub(crate) options: String,
}

/// All views, in order.
pub(crate) fn views() -> anyhow::Result<Vec<Entry>> {
    let list: List = toml::from_str(include_str!("../../gallery.toml"))?;
    Ok(list.picture)
}
