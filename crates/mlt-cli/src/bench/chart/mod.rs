//! Charts as SVG, to stand in a page.

mod curves;
mod scale;
mod strata;

pub(super) use curves::{Line, Point, curves};
pub(super) use scale::significant;
pub(super) use strata::strata;

/// Classes of the style sheet that colour what belongs to a method; then again.
const CLASSES: [&str; 7] = ["m0", "m1", "m2", "m3", "m4", "m5", "m6"];

/// The class of a method.
pub(super) fn class(method: usize) -> &'static str {
    CLASSES[method % CLASSES.len()]
}

/// Text that can stand in SVG and HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
