//! What can be wrong with a recipe: every message names the file, the line, the key path, what was found there and what
//! was expected.

/// Why a recipe was refused. Boxed text keeps the error small beside the values it stands in for.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// The recipe file itself could not be read.
    #[error("{file}: cannot read the recipe: {source}")]
    Read {
        /// The recipe's path.
        file: Box<str>,
        /// What the system said.
        source: std::io::Error,
    },
    /// A name that no shipped recipe has.
    #[error("no recipe called {name} is shipped, expected one of: {names}")]
    NotShipped {
        /// The name asked for.
        name: Box<str>,
        /// Those there are, comma separated.
        names: Box<str>,
    },
    /// The text is not TOML.
    #[error("{file}:{line}: not valid TOML: {message}")]
    Syntax {
        /// The recipe's name.
        file: Box<str>,
        /// Line of the fault, from 1.
        line: usize,
        /// What the TOML parser said.
        message: Box<str>,
    },
    /// A key is missing, has the wrong type or is out of range.
    #[error("{file}:{line}: `{path}`: found {found}, expected {expected}")]
    Value {
        /// The recipe's name.
        file: Box<str>,
        /// Line of the value (of the table, for a missing key), from 1.
        line: usize,
        /// Dotted key path, such as `layer[2].amplitude_m`.
        path: Box<str>,
        /// What the file says.
        found: Box<str>,
        /// What it may say.
        expected: Box<str>,
    },
    /// A key that no reader asked for.
    #[error("{file}:{line}: `{path}`: found an unknown key, expected one of: {expected}")]
    UnknownKey {
        /// The recipe's name.
        file: Box<str>,
        /// Line of the key, from 1.
        line: usize,
        /// Dotted key path.
        path: Box<str>,
        /// The keys known there, comma separated.
        expected: Box<str>,
    },
    /// A heightmap is missing, damaged or of the wrong kind.
    #[error("{file}:{line}: `{path}`: heightmap {image}: found {found}, expected {expected}")]
    Heightmap {
        /// The recipe's name.
        file: Box<str>,
        /// Line of the key that names the image, from 1.
        line: usize,
        /// Dotted key path.
        path: Box<str>,
        /// The image's name, relative to the recipe.
        image: Box<str>,
        /// What the image is.
        found: Box<str>,
        /// What it should be.
        expected: Box<str>,
    },
    /// A picture is missing, damaged or of the wrong kind.
    #[error("{file}:{line}: `{path}`: picture {image}: found {found}, expected {expected}")]
    Picture {
        /// The recipe's name.
        file: Box<str>,
        /// Line of the key that names the picture, from 1.
        line: usize,
        /// Dotted key path.
        path: Box<str>,
        /// The picture's name, relative to the recipe.
        image: Box<str>,
        /// What the picture is.
        found: Box<str>,
        /// What it should be.
        expected: Box<str>,
    },
}
