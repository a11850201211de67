//! Material parameters brought into their ranges.

use mlt_core::transport::Rgb;

/// Moves a material's parameters into their ranges, with a warning for each that was outside.
pub(crate) struct Range<'a> {
    /// The material's name.
    pub material: &'a str,
    /// Where the warnings go.
    pub warnings: &'a mut Vec<String>,
}

impl Range<'_> {
    /// `value` in [least, most]; what is not a number becomes the least.
    pub fn number(&mut self, what: &str, value: f32, [least, most]: [f32; 2]) -> f32 {
        let taken = if value.is_nan() { least } else { value.clamp(least, most) };
        if taken != value {
            let name = self.material;
            self.warnings.push(format!("material `{name}`: {what} is {value}; {taken} is taken instead"));
        }
        taken
    }

    /// Each component in [0, most].
    pub fn colour(&mut self, what: &str, value: Rgb, most: f32) -> Rgb {
        Rgb::from_array(value.to_array().map(|c| self.number(what, c, [0.0, most])))
    }
}
