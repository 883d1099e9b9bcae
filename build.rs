//! Build script of the runtime: shaders are compiled here.
fn main() {}
