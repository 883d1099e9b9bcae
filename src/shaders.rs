//! The compiled shaders, one constant per file of `shaders/`, named like `SELECT_COMP` for `select.comp`.
//!
//! The build script generates the constants, so a shader that is missing is a compile error, never a run-time one.

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
