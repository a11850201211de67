//! Charts as SVG, to stand in a page.

mod curves;
mod scale;
mod strata;

pub(super) use curves::{Line, curves};
pub(super) use scale::significant;
pub(super) use strata::strata;

/// Colours that people with any colour vision can tell apart, each dark enough for a thin line on white; then again.
///
/// Source: [OkabeIto08], the two light ones darkened.
pub(super) const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#b5538f", "#b87f00", "#3a93c7", "#333333"];

/// The colour of a method.
pub(super) fn colour(method: usize) -> &'static str {
    COLOURS[method % COLOURS.len()]
}

/// Text that can stand in SVG and HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
