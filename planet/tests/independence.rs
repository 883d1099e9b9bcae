//! The planet crate knows no Vulkan, no window and no GPU.

use std::process::Command;

/// Packages that a package is built with, by name.
fn dependencies(package: &str) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--edges", "normal,build", "--prefix", "none", "--format", "{p}", "-p", package])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "cargo tree: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("cargo prints UTF-8");
    text.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
}

const GRAPHICS: [&str; 6] = ["ash", "ash-window", "winit", "gpu-allocator", "glslang", "raw-window-handle"];

#[test]
fn planet_knows_no_graphics() {
    let found: Vec<String> = dependencies("terrane-planet").into_iter().filter(|d| GRAPHICS.contains(&d.as_str())).collect();
    assert_eq!(found, Vec::<String>::new());
}

#[test]
fn the_check_finds_graphics() {
    let found = dependencies("terrane");
    assert!(found.iter().any(|d| d == "ash") && found.iter().any(|d| d == "terrane-planet"), "{found:?}");
}
