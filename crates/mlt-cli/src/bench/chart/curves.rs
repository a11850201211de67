//! Error over time, rays or mutations: both axes logarithmic, a line a method.

use std::fmt::Write;

use super::{
    class, escaped,
    scale::{LogScale, significant, tick},
};

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 58.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 44.0;
/// Width of a letter of a label, roughly.
const LETTER: f64 = 6.6;
/// Distance of labels at the ends of lines.
const LINE_HEIGHT: f64 = 15.0;

/// A method's line.
pub(crate) struct Line {
    /// Index of the method, for its colour.
    pub method: usize,
    /// Written at its end.
    pub name: String,
    /// Rising.
    pub points: Vec<Point>,
}

/// A point of a line, of one budget.
pub(crate) struct Point {
    /// Abscissa, above zero.
    pub at: f64,
    /// Smallest, median and largest ordinate over the seeds, above zero.
    pub levels: [f64; 3],
    /// Whether its budget was missed; then it is drawn hollow.
    pub missed: bool,
}

/// The chart. `floor`: a level to mark, with its name.
pub(crate) fn curves(lines: &[Line], x_name: &str, y_name: &str, floor: Option<(f64, &str)>) -> String {
    let longest = lines.iter().map(|line| line.name.chars().count()).max().unwrap_or(0) as f64;
    let right = WIDTH - (longest * LETTER + 22.0).clamp(60.0, 0.45 * WIDTH);
    let points = || lines.iter().flat_map(|line| &line.points);
    let x = LogScale::new(points().map(|point| point.at), LEFT, right);
    // A floor far below all lines would squeeze them together.
    let lowest = points().map(|point| point.levels[0]).fold(f64::INFINITY, f64::min);
    let floor = floor.filter(|(level, _)| *level > 0.2 * lowest);
    let levels = points().flat_map(|point| point.levels).chain(floor.map(|floor| floor.0));
    let y = LogScale::new(levels, HEIGHT - BOTTOM, TOP);
    let mut svg = format!(
        "<svg class=\"chart\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{} over {}\">\n",
        escaped(y_name),
        escaped(x_name)
    );
    axes(&mut svg, &x, &y, right, [x_name, y_name]);
    if let Some((level, name)) = floor {
        let at = y.at(level);
        let _ = writeln!(svg, "<line class=\"floor\" x1=\"{LEFT}\" x2=\"{right:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>");
        let _ = writeln!(
            svg,
            "<text class=\"note\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            LEFT + 5.0,
            at - 4.0,
            escaped(name)
        );
    }
    lines.iter().for_each(|line| band(&mut svg, line, &x, &y));
    lines.iter().for_each(|line| stroke(&mut svg, line, &x, &y, [x_name, y_name]));
    labels(&mut svg, lines, &x, &y, right);
    svg + "</svg>"
}

fn axes(svg: &mut String, x: &LogScale, y: &LogScale, right: f64, [x_name, y_name]: [&str; 2]) {
    let bottom = HEIGHT - BOTTOM;
    for value in y.ticks() {
        let at = y.at(value);
        let _ = writeln!(svg, "<line class=\"grid\" x1=\"{LEFT}\" x2=\"{right:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>");
        let (x, y, text) = (LEFT - 7.0, at + 4.0, tick(value));
        let _ = writeln!(svg, "<text class=\"tick\" x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{text}</text>");
    }
    for value in x.ticks() {
        let at = x.at(value);
        let _ = writeln!(svg, "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{bottom}\"/>");
        let (y, text) = (bottom + 16.0, tick(value));
        let _ = writeln!(svg, "<text class=\"tick\" x=\"{at:.1}\" y=\"{y}\" text-anchor=\"middle\">{text}</text>");
    }
    let _ = writeln!(svg, "<path class=\"axis\" d=\"M{LEFT} {TOP}V{bottom}H{right:.1}\"/>");
    let (middle, below) = (0.5 * (LEFT + right), HEIGHT - 8.0);
    let _ = writeln!(
        svg,
        "<text class=\"name\" x=\"{middle:.1}\" y=\"{below}\" text-anchor=\"middle\">{}</text>",
        escaped(x_name)
    );
    let _ = writeln!(
        svg,
        "<text class=\"name\" transform=\"translate(13 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        0.5 * (TOP + bottom),
        escaped(y_name)
    );
}

fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let words: Vec<String> = points.map(|(x, y)| format!("{x:.1} {y:.1}")).collect();
    format!("M{}", words.join("L"))
}

fn band(svg: &mut String, line: &Line, x: &LogScale, y: &LogScale) {
    if line.points.len() < 2 {
        return;
    }
    let edge = |which: usize| line.points.iter().map(move |point| (x.at(point.at), y.at(point.levels[which])));
    let outline = path(edge(0).chain(edge(2).collect::<Vec<_>>().into_iter().rev()));
    let _ = writeln!(svg, "<path class=\"band {}\" d=\"{outline}Z\"/>", class(line.method));
}

fn stroke(svg: &mut String, line: &Line, x: &LogScale, y: &LogScale, [x_name, y_name]: [&str; 2]) {
    let class = class(line.method);
    let medians = line.points.iter().map(|point| (x.at(point.at), y.at(point.levels[1])));
    if line.points.len() > 1 {
        let _ = writeln!(svg, "<path class=\"median {class}\" d=\"{}\"/>", path(medians.clone()));
    }
    for (point, (cx, cy)) in line.points.iter().zip(medians) {
        let [low, middle, high] = point.levels.map(significant);
        let (name, here) = (escaped(&line.name), significant(point.at));
        if line.points.len() == 1 {
            let (top, bottom) = (y.at(point.levels[2]), y.at(point.levels[0]));
            let _ = writeln!(svg, "<path class=\"range {class}\" d=\"M{cx:.1} {top:.1}V{bottom:.1}\"/>");
        }
        let (hollow, missed) = if point.missed { (" missed", "; budget missed") } else { ("", "") };
        let _ = writeln!(
            svg,
            "<circle class=\"point{hollow} {class}\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3\"><title>{name}: {y_name} {middle} \
             ({low} to {high}) at {here} {x_name}{missed}</title></circle>"
        );
    }
}

/// Names at the ends of the lines, moved apart where they would cover each other.
fn labels(svg: &mut String, lines: &[Line], x: &LogScale, y: &LogScale, right: f64) {
    let end = |line: &Line| line.points.last().map(|point| (x.at(point.at), y.at(point.levels[1])));
    let mut ends: Vec<_> = lines.iter().filter_map(|line| end(line).map(|(x, y)| (y, x, line))).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted: Vec<f64> = ends.iter().map(|end| end.0).collect();
    for ((y_end, x_end, line), at) in ends.iter().zip(spread(&wanted, TOP + 4.0, HEIGHT - BOTTOM)) {
        let class = class(line.method);
        let _ = writeln!(
            svg,
            "<path class=\"leader {class}\" d=\"M{:.1} {y_end:.1}L{:.1} {at:.1}H{:.1}\"/>",
            x_end + 4.0,
            right + 6.0,
            right + 11.0
        );
        let (x, y, name) = (right + 15.0, at + 4.0, escaped(&line.name));
        let _ = writeln!(svg, "<text class=\"label\" x=\"{x:.1}\" y=\"{y:.1}\">{name}</text>");
    }
}

/// Positions at least a line apart, close to the wanted ones (rising), inside of the chart if they fit.
fn spread(wanted: &[f64], top: f64, bottom: f64) -> Vec<f64> {
    let mut at: Vec<f64> = Vec::with_capacity(wanted.len());
    for &want in wanted {
        let free = at.last().map_or(top, |last| last + LINE_HEIGHT);
        at.push(want.max(free));
    }
    let mut limit = bottom;
    for position in at.iter_mut().rev() {
        *position = position.min(limit);
        limit = *position - LINE_HEIGHT;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_cover_each_other() {
        let at = spread(&[50.0, 52.0, 53.0, 200.0, 201.0], 10.0, 210.0);
        assert!(at.windows(2).all(|pair| pair[1] - pair[0] >= LINE_HEIGHT - 1e-9), "{at:?}");
        assert!(at.iter().all(|at| (10.0..=210.0).contains(at)), "{at:?}");
        assert!(spread(&[], 0.0, 1.0).is_empty());
    }

    #[test]
    fn every_line_has_a_band_a_median_and_a_label() {
        let point = |at, level: f64| Point { at, levels: [level * 0.9, level, level * 1.1], missed: at > 5.0 };
        let line = |method, level: f64| Line {
            method,
            name: format!("<{method}>"),
            points: vec![point(1.0, level), point(10.0, level * 0.1)],
        };
        let svg = curves(&[line(0, 1.0), line(1, 2.0)], "seconds", "relMSE", Some((0.05, "reference")));
        for (part, count) in [
            ("class=\"band m", 2),
            ("class=\"median m", 2),
            ("class=\"point m0", 1),
            ("class=\"point missed m0", 1),
            ("class=\"floor\"", 1),
        ] {
            assert_eq!(svg.matches(part).count(), count, "{part}");
        }
        assert!(svg.contains(">&lt;1&gt;</text>") && !svg.contains("NaN"));
        let lonely = curves(&[Line { points: vec![point(1.0, 1.0)], ..line(0, 1.0) }], "x", "y", None);
        assert!(lonely.contains("class=\"range m0\"") && !lonely.contains("NaN"));
    }
}
