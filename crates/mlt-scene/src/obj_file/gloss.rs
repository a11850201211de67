//! Gloss as MTL tells it.

/// Roughness of a lobe with Blinn's exponent.
///
/// α = √(2 / (n + 2)) gives a microfacet distribution the width of Blinn's lobe with exponent n; roughness = √α.
/// Source: [Walter07].
pub(super) fn roughness(exponent: f32) -> f32 {
    (2.0 / (exponent + 2.0)).sqrt().sqrt()
}
