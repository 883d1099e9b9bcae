//! What a test does that cannot run here.

/// Prints "skipped" and why; fails where `TERRANE_REQUIRE_GPU=1`, as on CI, so that no skip passes for a success there.
pub(crate) fn skipped(reason: &dyn std::fmt::Display) {
    let required = std::env::var("TERRANE_REQUIRE_GPU").is_ok_and(|value| value == "1");
    assert!(!required, "TERRANE_REQUIRE_GPU=1, but: {reason}");
    println!("skipped: {reason}");
}
