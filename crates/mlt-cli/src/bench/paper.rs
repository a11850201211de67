//! The table of the paper, and ours beside it.

use serde::Serialize;

use super::{
    axis::Axis,
    row::Row,
    statistics::{self, Estimate, Verdict, mean, mean_of},
};

/// Unstratified and stratified, with the paper's weights; it does not say into how many cells it cuts a light.
pub(super) const METHODS: [&str; 2] = ["mlt:none:weights=power", "mlt:4x4:weights=power"];

/// A scene of the paper's table.
pub(super) struct PaperScene {
    /// The built-in scene.
    pub name: &'static str,
    /// relativeDiff, unstratified and stratified.
    relative_diff: [f64; 2],
    /// Acceptance rate, unstratified and stratified.
    acceptance: [f64; 2],
}

/// Source: [Jankauski15], section 5.
pub(super) const SCENES: [PaperScene; 3] = [
    PaperScene { name: "ring", relative_diff: [0.013, 0.010], acceptance: [0.3440, 0.3461] },
    PaperScene { name: "cornell", relative_diff: [0.025, 0.026], acceptance: [0.4210, 0.4235] },
    PaperScene { name: "suzanne", relative_diff: [0.080, 0.070], acceptance: [0.3382, 0.3388] },
];

/// One algorithm on one scene: the means over the renders.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Cell {
    /// relativeDiff.
    pub relative_diff: f64,
    /// Its 95 % confidence interval.
    pub interval: Option<(f64, f64)>,
    /// relativeDiff in the paper.
    pub paper_relative_diff: f64,
    /// Rays per pixel, those of the independent samples included.
    pub rays: f64,
    /// Acceptance rate, a fraction.
    pub acceptance: f64,
    /// Acceptance rate in the paper.
    pub paper_acceptance: f64,
}

/// One scene.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Comparison {
    /// The scene's name.
    pub scene: &'static str,
    /// Renders of each algorithm.
    pub renders: usize,
    /// With strata.
    pub stratified: Cell,
    /// Without.
    pub unstratified: Cell,
    /// relativeDiff with strata over that without.
    pub ratio: f64,
    /// Its 95 % confidence interval.
    pub ratio_interval: Option<(f64, f64)>,
    /// The same ratio in the paper.
    pub paper_ratio: f64,
    /// Reading of the interval.
    pub verdict: &'static str,
}

/// The table, without scenes of which runs are missing.
pub(super) fn table(rows: &[Row]) -> Vec<Comparison> {
    SCENES.iter().filter_map(|scene| compare(scene, rows)).collect()
}

fn compare(scene: &PaperScene, rows: &[Row]) -> Option<Comparison> {
    let of = |method: usize| -> Vec<&Row> {
        rows.iter().filter(|row| row.key.scene == scene.name && row.key.method == METHODS[method]).collect()
    };
    let (without, with) = (of(0), of(1));
    if without.is_empty() || with.is_empty() {
        return None;
    }
    let Estimate { value: ratio, interval } = statistics::ratio(&errors(&with), &errors(&without), mean);
    Some(Comparison {
        scene: scene.name,
        renders: with.len().min(without.len()),
        stratified: cell(scene, 1, &with),
        unstratified: cell(scene, 0, &without),
        ratio,
        ratio_interval: interval,
        paper_ratio: scene.relative_diff[1] / scene.relative_diff[0],
        verdict: match (Estimate { value: ratio, interval }).verdict() {
            Verdict::Less => "stratified better, 95 %",
            Verdict::Greater => "stratified worse, 95 %",
            Verdict::Open => "no difference shown",
        },
    })
}

fn errors(rows: &[&Row]) -> Vec<f64> {
    rows.iter().map(|row| row.errors.relative_diff).collect()
}

fn cell(scene: &PaperScene, method: usize, rows: &[&Row]) -> Cell {
    let errors = errors(rows);
    let Estimate { value, interval } = statistics::estimate(&errors, mean);
    Cell {
        relative_diff: value,
        interval,
        paper_relative_diff: scene.relative_diff[method],
        rays: mean_of(rows.iter().map(|row| Axis::Rays.of(row))),
        acceptance: mean_of(rows.iter().filter_map(|row| row.acceptance)),
        paper_acceptance: scene.acceptance[method],
    }
}

/// The table for a terminal; empty without scenes.
pub(super) fn text(table: &[Comparison]) -> String {
    let mut text = String::new();
    if !table.is_empty() {
        text += "scene    algorithm     relativeDiff  paper  acceptance    paper  rays/pixel\n";
    }
    for Comparison { scene, stratified, unstratified, ratio, paper_ratio, verdict, .. } in table {
        for (name, cell) in [("stratified", stratified), ("unstratified", unstratified)] {
            let Cell { relative_diff, paper_relative_diff, rays, acceptance, paper_acceptance, .. } = cell;
            let (ours, paper) = (100.0 * acceptance, 100.0 * paper_acceptance);
            text += &format!(
                "{scene:8} {name:12}  {relative_diff:12.5}  {paper_relative_diff:.3}  {ours:8.2} %  {paper:.2} %  {rays:10.1}\n"
            );
        }
        text += &format!("{scene:8} ratio         {ratio:12.3}  {paper_ratio:.3}  {verdict}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{super::row::tests::row, *};

    fn rows(stratified: [f64; 4], unstratified: [f64; 4]) -> Vec<Row> {
        let make = |method: &'static str, errors: [f64; 4]| {
            (1..).zip(errors).map(move |(seed, error)| {
                let mut row = row(method, seed, 0.5 * error);
                row.key.scene = "ring".into();
                row
            })
        };
        make(METHODS[1], stratified).chain(make(METHODS[0], unstratified)).collect()
    }

    #[test]
    fn verdicts_follow_the_intervals() {
        let verdict = |with, without| table(&rows(with, without))[0].verdict;
        let (low, high) = ([1.0, 1.01, 1.02, 1.03], [2.0, 2.01, 2.02, 2.03]);
        assert_eq!(verdict(low, high), "stratified better, 95 %");
        assert_eq!(verdict(high, low), "stratified worse, 95 %");
        assert_eq!(verdict([0.5, 1.0, 2.0, 4.0], [1.0, 2.0, 3.0, 4.0]), "no difference shown");
    }

    #[test]
    fn the_table_has_ours_and_the_papers() {
        let table = table(&rows([1.0; 4], [2.0; 4]));
        assert_eq!((table.len(), table[0].scene, table[0].renders, table[0].ratio), (1, "ring", 4, 0.5));
        assert_eq!(table[0].stratified.interval, Some((1.0, 1.0)));
        let text = text(&table);
        assert!(text.contains("ring     stratified         1.00000  0.010     25.00 %  34.61 %       100.0"), "{text}");
        assert!(super::text(&[]).is_empty());
    }
}
