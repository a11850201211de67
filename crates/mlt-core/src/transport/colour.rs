//! Linear colour.

/// Linear Rec. 709 colour: radiance in W·sr⁻¹·m⁻², or a dimensionless reflectance.
pub type Rgb = glam::Vec3;

/// Weights of the channels in luminance (ITU-R BT.709).
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Luminance of a linear Rec. 709 colour.
#[inline]
pub fn luminance(c: Rgb) -> f32 {
    const WEIGHTS: Rgb = Rgb::new(LUMINANCE[0] as f32, LUMINANCE[1] as f32, LUMINANCE[2] as f32);
    c.dot(WEIGHTS)
}
