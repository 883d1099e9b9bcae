//! What the certificate is about: the tolerances that wakes are built for (docs/design.md, "Wake distance").

/// Coarsest tolerance, in radians of screen error, at which the certificate holds (κ₀).
pub const KAPPA: f64 = 0.003;

/// Share of [`KAPPA`] kept for the deviation of a patch's own grid from the finer levels that replace it.
pub const DEVIATION_SHARE: f64 = 0.4;

/// How far all finer levels together may lie off a patch's grid, over how far the next one alone does, for bounds. (Measured over
/// the shipped recipes: 1.0 to 1.6 on average, at most 2.7 below level 1.) A constant, so that what is known of a patch does not depend
/// on what happens to be known below it.
pub const DEVIATION_BELOW: f64 = 3.0;

/// Radians of error per unit distance that wakes are built for: the rest of [`KAPPA`].
pub const KAPPA_BUILD: f64 = (1.0 - DEVIATION_SHARE) * KAPPA;
