//! The tables of a scene.

use std::collections::BTreeSet;

use super::super::{
    axis::Axis,
    chart::{self, significant},
    row::Row,
    statistics::{self, Crossing, Estimate, Verdict, median},
    summary::{Curve, Point},
};

/// A method and its figures.
pub(super) struct Line {
    /// The method.
    pub name: String,
    /// The class that colours it.
    pub method: &'static str,
    /// From left to right.
    pub cells: Vec<String>,
}

/// A method against each other.
pub(super) struct RatioLine {
    /// The method.
    pub name: String,
    /// The class that colours it.
    pub method: &'static str,
    /// From left to right.
    pub cells: Vec<RatioCell>,
}

/// One ratio.
pub(super) struct RatioCell {
    /// The ratio.
    pub value: String,
    /// Its 95 % confidence interval; empty if unknown.
    pub interval: String,
    /// The verdict, as a class of the style sheet.
    pub class: &'static str,
}

/// A line of a table.
pub(super) fn line(curve: &Curve, cells: Vec<String>) -> Line {
    Line { name: curve.name.to_owned(), method: chart::class(curve.method), cells }
}

/// A median over the seeds, with a mark where the budget was missed.
pub(super) fn figure(point: &Point, figure: impl Fn(&Row) -> f64) -> String {
    significant(point.median(figure)) + if point.missed() { " *" } else { "" }
}

/// Medians at the largest budget.
pub(super) fn error_cells(curve: &Curve, axis: Axis) -> Vec<String> {
    let last = curve.last();
    let optional = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), significant);
    vec![
        figure(last, |row| axis.of(row)),
        significant(last.median(|row| row.errors.rel_mse)),
        optional(last.worst_over_median()),
        curve.slope(axis).map_or_else(|| "–".into(), |slope| format!("{slope:.2}").replace('-', "−")),
        significant(last.median(|row| row.errors.relative_diff)),
        significant(last.median(|row| row.errors.mape)),
        optional(last.mean(|row| row.errors.flip.map(f64::from))),
        format!("{:.4}", last.median(|row| row.errors.mean_ratio)),
        last.rows.len().to_string(),
    ]
}

/// Where each method reaches the target, and that over the best other method's.
pub(super) fn reach(curves: &[Curve], axes: &[Axis], target: f64) -> Vec<Line> {
    let cells = |curve: &Curve, axis: Axis| {
        let others = curves.iter().filter(|other| other.method != curve.method);
        let best = others.filter_map(|other| other.reaches(axis, target)).min_by(|a, b| a.x.total_cmp(&b.x));
        let own = curve.reaches(axis, target);
        let ratio = own
            .zip(best)
            .map(|(own, best)| Crossing { x: own.x / best.x, extrapolated: own.extrapolated || best.extrapolated });
        [own, ratio].map(|found| found.map_or_else(|| "–".to_owned(), crossing))
    };
    curves.iter().map(|curve| line(curve, axes.iter().flat_map(|axis| cells(curve, *axis)).collect())).collect()
}

fn crossing(Crossing { x, extrapolated }: Crossing) -> String {
    let mark = if extrapolated { "≈ " } else { "" };
    mark.to_owned() + &significant(x)
}

/// A line of the table of ratios.
pub(super) fn ratio_line(curve: &Curve, curves: &[Curve]) -> RatioLine {
    let cell = |other: &Curve| {
        if other.method == curve.method {
            return RatioCell { value: String::new(), interval: String::new(), class: "self" };
        }
        let estimate = statistics::ratio(&curve.last().errors(), &other.last().errors(), median);
        RatioCell { value: significant(estimate.value), interval: interval(estimate.interval), class: class(&estimate) }
    };
    RatioLine {
        name: curve.name.to_owned(),
        method: chart::class(curve.method),
        cells: curves.iter().map(cell).collect(),
    }
}

/// An interval in words; empty if unknown.
pub(super) fn interval(interval: Option<(f64, f64)>) -> String {
    interval.map_or_else(String::new, |(low, high)| format!("{} – {}", significant(low), significant(high)))
}

/// The style of a ratio.
pub(super) fn class(ratio: &Estimate) -> &'static str {
    match ratio.verdict() {
        Verdict::Less => "less",
        Verdict::Greater => "greater",
        Verdict::Open => "open",
    }
}

/// Names of the mutations that any method has.
pub(super) fn mutations(curves: &[Curve]) -> Vec<String> {
    let names = curves.iter().flat_map(|curve| &curve.last().rows).flat_map(|row| row.mutation_acceptance.keys());
    names.cloned().collect::<BTreeSet<_>>().into_iter().collect()
}

/// Share accepted of all proposals and of each mutation's, of methods that have any.
pub(super) fn acceptance(curves: &[Curve], mutations: &[String]) -> Vec<Line> {
    let percent = |rate: Option<f64>| rate.map_or_else(|| "–".to_owned(), |rate| format!("{:.1} %", 100.0 * rate));
    let of = |curve: &Curve| {
        let last = curve.last();
        let all = last.mean(|row| row.acceptance)?;
        let each = mutations.iter().map(|name| last.mean(|row| row.mutation_acceptance.get(name).copied().flatten()));
        Some(line(curve, std::iter::once(Some(all)).chain(each).map(percent).collect()))
    };
    curves.iter().filter_map(of).collect()
}
