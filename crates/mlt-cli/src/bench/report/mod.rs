//! The report: one page that holds everything it shows.

mod facts;
mod leads;
mod tables;

use anyhow::Context;
use askama::Template;

use super::{
    axis::Axis,
    chart::{self, significant},
    paint,
    paper::{Cell as PaperCell, Comparison},
    row::Row,
    runs::Ready,
    statistics::{self, Estimate, median},
    subject::{Reference, Subject},
    summary::{Curve, Point, curves, usual_target},
};
use crate::args::bench::BenchOptions;
use leads::Lead;
use tables::{Line, RatioLine, acceptance, class, error_cells, interval, line, mutations, ratio_line, reach};

#[derive(Template)]
#[template(path = "report.html")]
struct Page {
    version: &'static str,
    facts: Vec<(&'static str, String)>,
    leads: Vec<Lead>,
    paper: Vec<PaperRow>,
    scenes: Vec<Scene>,
    map: String,
    largest_error: String,
}

/// Two lines of the paper's table.
struct PaperRow {
    scene: &'static str,
    lines: [PaperLine; 2],
    ratio: String,
    interval: String,
    paper_ratio: String,
    verdict: &'static str,
    class: &'static str,
}

struct PaperLine {
    algorithm: &'static str,
    /// relativeDiff, its interval, the paper's, acceptance, the paper's, rays.
    cells: [String; 6],
}

struct Scene {
    name: String,
    reference: String,
    budget: String,
    charts: Vec<String>,
    missed: Vec<String>,
    errors: Vec<Line>,
    target: String,
    reach_columns: Vec<String>,
    reach: Vec<Line>,
    ratios: Vec<RatioLine>,
    mutations: Vec<String>,
    acceptance: Vec<Line>,
    strata: Vec<Strata>,
    reference_image: String,
    pictures: Vec<Picture>,
}

struct Strata {
    name: String,
    count: usize,
    chart: String,
}

struct Picture {
    name: String,
    error: String,
    image: String,
    map: String,
}

/// The page's text.
pub(super) fn html(
    ready: &Ready,
    rows: &[Row],
    paper: &[Comparison],
    options: &BenchOptions,
) -> anyhow::Result<String> {
    let known = ready.subjects.iter().enumerate().map(|(index, subject)| {
        let curves = curves(ready.study, rows, &subject.0.name);
        (index, subject, curves)
    });
    let known: Vec<_> = known.filter(|(.., curves)| !curves.is_empty()).collect();
    let scenes = known.iter().map(|(index, subject, curves)| scene(ready, *index, subject, curves, options));
    let page = Page {
        version: env!("CARGO_PKG_VERSION"),
        facts: facts::facts(ready.study, options),
        leads: known.iter().map(|(_, (subject, _), curves)| leads::lead(&subject.name, curves)).collect(),
        paper: paper.iter().map(paper_row).collect(),
        scenes: scenes.collect::<anyhow::Result<_>>()?,
        map: paint::map_css(),
        largest_error: significant(paint::LARGEST),
    };
    page.render().context("cannot make the report")
}

/// The charts of error of all scenes: the scene and the axis of each, and the chart.
pub(super) fn charts(ready: &Ready, rows: &[Row]) -> Vec<(String, String)> {
    let of_scene = |(subject, reference): &(Subject, Reference)| {
        let curves = curves(ready.study, rows, &subject.name);
        let drawn = |axis: &Axis| {
            (format!("{}.{}", subject.name, axis.word()), chart::file(&error_chart(&curves, *axis, reference)))
        };
        if curves.is_empty() { Vec::new() } else { axes(ready).iter().map(drawn).collect() }
    };
    ready.subjects.iter().flat_map(of_scene).collect()
}

/// Axes of the charts: of budgets that make the same report again, none that depends on the machine.
fn axes(ready: &Ready) -> Vec<Axis> {
    if ready.study.repeats() { vec![Axis::Rays, Axis::Work] } else { vec![Axis::Seconds, Axis::Rays, Axis::Work] }
}

fn scene(
    ready: &Ready,
    index: usize,
    (subject, reference): &(Subject, Reference),
    curves: &[Curve],
    options: &BenchOptions,
) -> anyhow::Result<Scene> {
    let axes = axes(ready);
    let target = options.target.or_else(|| usual_target(curves));
    let compared = &axes[..axes.len() - 1];
    let mutations = mutations(curves);
    Ok(Scene {
        name: subject.name.clone(),
        reference: describe(reference),
        budget: curves[0].last().rows[0].key.budget.clone(),
        charts: axes.iter().map(|axis| error_chart(curves, *axis, reference)).collect(),
        missed: missed(curves),
        errors: curves.iter().map(|curve| line(curve, error_cells(curve, axes[0]))).collect(),
        target: target.map_or_else(String::new, significant),
        reach_columns: compared.iter().map(|axis| axis.name().to_owned()).collect(),
        reach: target.map_or_else(Vec::new, |target| reach(curves, compared, target)),
        ratios: curves.iter().map(|curve| ratio_line(curve, curves)).collect(),
        acceptance: acceptance(curves, &mutations),
        mutations,
        strata: curves.iter().filter_map(strata).collect(),
        reference_image: paint::data_uri(&reference.image, options.exposure)?,
        pictures: pictures(ready, index, reference, curves, options.exposure)?,
    })
}

fn describe(reference: &Reference) -> String {
    let own = reference.own_error.map(|own| format!("; its own noise adds about {} to every relMSE", significant(own)));
    let Reference { image, origin, .. } = reference;
    format!("{}×{} pixels; reference: {origin}{}", image.width, image.height, own.unwrap_or_default())
}

fn error_chart(curves: &[Curve], axis: Axis, reference: &Reference) -> String {
    let drawn = |point: &Point| {
        let errors = point.errors();
        let low = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let high = errors.iter().copied().fold(0.0, f64::max);
        chart::Point {
            at: point.median(|row| axis.of(row)),
            levels: [low, median(&mut errors.clone()), high],
            missed: point.missed(),
        }
    };
    let line = |curve: &Curve| {
        let slope = curve.slope(axis).map(|slope| format!("  {slope:.2}").replace('-', "−"));
        chart::Line {
            method: curve.method,
            name: curve.name.to_owned() + &slope.unwrap_or_default(),
            points: curve.points.iter().map(drawn).filter(|point| point.at > 0.0 && point.levels[0] > 0.0).collect(),
        }
    };
    let lines: Vec<_> = curves.iter().map(line).collect();
    chart::curves(&lines, axis.name(), "relMSE", reference.own_error.map(|own| (own, "noise of the reference")))
}

/// Runs that did not end at their budget, in words: how far beyond it they went, by method and budget.
fn missed(curves: &[Curve]) -> Vec<String> {
    let told = |(curve, point): (&Curve, &Point)| {
        let beyond: Vec<_> = point.rows.iter().filter_map(|row| row.missed(&point.budget)).collect();
        let low = beyond.iter().copied().reduce(f64::min)?;
        let high = beyond.iter().copied().reduce(f64::max)?;
        let [low, high] = [low, high].map(|share| format!("{:+.0}", 100.0 * share));
        let range = if low == high { low } else { format!("{low} to {high}") };
        Some(format!("{}, {}: {range} % in {} of {}", curve.name, point.budget, beyond.len(), point.rows.len()))
    };
    curves.iter().flat_map(|curve| curve.points.iter().map(move |point| (curve, point))).filter_map(told).collect()
}

/// b_j, its standard error in one run and n_j, means over the seeds; `None` for methods with a single stratum or none.
fn strata(curve: &Curve) -> Option<Strata> {
    let rows = &curve.last().rows;
    let count = rows.iter().map(|row| row.strata_list.len()).min().filter(|count| *count > 1)?;
    let stratum = |j: usize| {
        let mean = |f: &dyn Fn(&super::row::Stratum) -> f64| {
            statistics::mean_of(rows.iter().map(|row| f(&row.strata_list[j])))
        };
        (mean(&|s| s.b), mean(&|s| s.b_stderr.unwrap_or(0.0)), mean(&|s| s.mutations as f64))
    };
    let chart = chart::strata(&(0..count).map(stratum).collect::<Vec<_>>(), curve.method)?;
    Some(Strata { name: curve.name.to_owned(), count, chart })
}

fn pictures(
    ready: &Ready,
    scene: usize,
    reference: &Reference,
    curves: &[Curve],
    exposure: f64,
) -> anyhow::Result<Vec<Picture>> {
    let images = curves.iter().filter_map(|curve| Some((curve, ready.image(scene, curve.method)?)));
    let picture = |(curve, image): (&Curve, crate::image::Image)| {
        Ok(Picture {
            name: curve.name.to_owned(),
            error: significant(reference.errors(&image)?.rel_mse),
            image: paint::data_uri(&image, exposure)?,
            map: paint::data_uri(&paint::error_map(reference, &image)?, 0.0)?,
        })
    };
    images.map(picture).collect()
}

fn paper_row(comparison: &Comparison) -> PaperRow {
    let Comparison { stratified, unstratified, ratio, ratio_interval, paper_ratio, .. } = comparison;
    PaperRow {
        scene: comparison.scene,
        lines: [paper_line("stratified", stratified), paper_line("unstratified", unstratified)],
        ratio: significant(*ratio),
        interval: interval(*ratio_interval),
        paper_ratio: significant(*paper_ratio),
        verdict: comparison.verdict,
        class: class(&Estimate { value: *ratio, interval: *ratio_interval }),
    }
}

fn paper_line(algorithm: &'static str, cell: &PaperCell) -> PaperLine {
    let percent = |rate: f64| format!("{:.2} %", 100.0 * rate);
    PaperLine {
        algorithm,
        cells: [
            significant(cell.relative_diff),
            interval(cell.interval),
            format!("{:.3}", cell.paper_relative_diff),
            percent(cell.acceptance),
            percent(cell.paper_acceptance),
            significant(cell.rays),
        ],
    }
}
