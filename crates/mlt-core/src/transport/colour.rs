//! Linear colour.

/// Linear Rec. 709 colour: radiance in W·sr⁻¹·m⁻², or a dimensionless reflectance.
pub type Rgb = glam::Vec3;

/// Luminance of a linear Rec. 709 colour (ITU-R BT.709).
#[inline]
pub fn luminance(c: Rgb) -> f32 {
    c.dot(Rgb::new(0.2126, 0.7152, 0.0722))
}
