//! Material parameters brought into their ranges.

use crate::text::shown;
use mlt_core::transport::Rgb;
use std::fmt::Display;

/// Moves a material's parameters into their ranges, with a warning for each that was outside.
pub(crate) struct Range<'a> {
    /// The material's name.
    pub material: &'a str,
    /// Where the warnings go.
    pub warnings: &'a mut Vec<String>,
}

impl Range<'_> {
    /// `value` in [least, most]; what is not a number becomes the least.
    pub(crate) fn number(&mut self, what: &str, value: f32, [least, most]: [f32; 2]) -> f32 {
        let taken = limited(value, least, most);
        if taken != value {
            self.warn(what, value, taken);
        }
        taken
    }

    /// Each component in [0, most].
    pub(crate) fn colour(&mut self, what: &str, value: Rgb, most: f32) -> Rgb {
        let taken = Rgb::from_array(value.to_array().map(|c| limited(c, 0.0, most)));
        if taken != value {
            self.warn(what, value, taken);
        }
        taken
    }

    fn warn(&mut self, what: &str, value: impl Display, taken: impl Display) {
        let material = shown(self.material);
        self.warnings.push(format!("material `{material}`: {what} is {value}; {taken} is taken instead"));
    }
}

fn limited(value: f32, least: f32, most: f32) -> f32 {
    if value.is_nan() { least } else { value.clamp(least, most) }
}
