//! Charts as SVG, to stand in a page or in a file of their own.

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

/// The colours and lines of charts, light and dark.
const STYLE: &str = include_str!("../../../templates/chart.css");

/// A chart as a file, with its style, and the namespace that a page needs not be told.
pub(super) fn file(chart: &str) -> String {
    let (head, content) = chart.split_once('\n').unwrap_or((chart, ""));
    let head = head.replacen("<svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"", 1);
    format!("{head}\n<style>\n{STYLE}svg {{ background: var(--page); }}\n</style>\n{content}\n")
}

/// Text that can stand in SVG and HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
