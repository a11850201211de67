//! A run's results: a row of the tables.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    args::bench::Budget,
    report::{StratumReport, finite},
};

/// Key of a run; two runs with the same key need not both be made.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct Key {
    /// The scene as named on the command line.
    pub scene: String,
    /// The method as named on the command line.
    pub method: String,
    /// The budget in words.
    pub budget: String,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Longest path in edges; `None`: no limit.
    pub max_length: Option<u32>,
    /// Threads of a run whose budget is in time; `None` where the image does not depend on them.
    pub threads: Option<usize>,
    /// Fingerprint of the reference's pixels.
    pub reference: String,
}

/// Errors against the reference.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct Errors {
    /// mean (a − b)² / max(a, 10⁻³).
    pub relative_diff: f64,
    /// mean (a − b)² / (a² + 10⁻²).
    pub rel_mse: f64,
    /// mean |a − b| / max(a, 10⁻³), a fraction.
    pub mape: f64,
    /// mean b / mean a.
    pub mean_ratio: f64,
    /// Mean HDR-FLIP, 0…1; `None` where it is not defined.
    pub flip: Option<f32>,
}

/// One run.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct Row {
    /// The run's key.
    #[serde(flatten)]
    pub key: Key,
    /// How the lights were cut.
    pub strata: String,
    /// Time on the clock, s.
    pub seconds: f64,
    /// Processor time of all threads, s; `None` where the system does not say.
    pub cpu_seconds: Option<f64>,
    /// Rounds in the image.
    pub rounds: u64,
    /// Rays traced.
    pub rays: u64,
    /// Metropolis–Hastings steps.
    pub mutations: u64,
    /// Independent samples.
    pub samples: u64,
    /// Share of proposals accepted; `None` without proposals.
    pub acceptance: Option<f64>,
    /// How far the image is from the reference.
    #[serde(flatten)]
    pub errors: Errors,
    /// Mean importance of the image.
    pub b: f64,
    /// Standard error of `b`; `None` where it is unknown.
    pub b_stderr: Option<f64>,
    /// Share of proposals accepted, by mutation.
    pub mutation_acceptance: BTreeMap<String, Option<f64>>,
    /// Each stratum; empty when the method has none.
    pub strata_list: Vec<Stratum>,
}

/// One stratum of a run.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct Stratum {
    /// b_j = ∫_{Ω_j} I.
    pub b: f64,
    /// Standard error of `b`; `None` where it is unknown.
    pub b_stderr: Option<f64>,
    /// n_j, Metropolis–Hastings steps.
    pub mutations: u64,
}

impl From<StratumReport> for Stratum {
    fn from(report: StratumReport) -> Self {
        let StratumReport { b, b_stderr, mutations, .. } = report;
        Self { b, b_stderr: finite(b_stderr), mutations }
    }
}

impl Row {
    /// Mutations per pixel, for an independent method samples per pixel.
    pub(super) fn per_pixel(&self) -> f64 {
        let work = if self.mutations > 0 { self.mutations } else { self.samples };
        work as f64 / (self.key.width * self.key.height) as f64
    }

    /// Rays per pixel.
    pub(super) fn rays_per_pixel(&self) -> f64 {
        self.rays as f64 / (self.key.width * self.key.height) as f64
    }

    /// How much more than its budget it spent, as a share, if that is not near it.
    pub(super) fn missed(&self, budget: &Budget) -> Option<f64> {
        budget.missed_by(self.seconds, self.rays_per_pixel())
    }
}

/// The columns of the CSV file.
const COLUMNS: &str = "scene,method,strata,seed,budget,width,height,max_length,threads,reference,seconds,cpu_seconds,rounds,\
rays,mutations,samples,acceptance,relative_diff,rel_mse,mape,mean_ratio,flip,b,b_stderr,strata_count\n";

/// All rows as CSV (RFC 4180), with a line of names; unknown values are empty.
pub(super) fn csv<'a>(rows: impl IntoIterator<Item = &'a Row>) -> String {
    let mut text = COLUMNS.to_owned();
    for row in rows {
        text += &(cells(row).map(|cell| quoted(&cell)).join(",") + "\n");
    }
    text
}

fn cells(row: &Row) -> [String; 25] {
    fn optional(value: Option<impl ToString>) -> String {
        value.map_or_else(String::new, |value| value.to_string())
    }
    let (key, errors) = (&row.key, &row.errors);
    [
        key.scene.clone(),
        key.method.clone(),
        row.strata.clone(),
        key.seed.to_string(),
        key.budget.clone(),
        key.width.to_string(),
        key.height.to_string(),
        optional(key.max_length),
        optional(key.threads),
        key.reference.clone(),
        row.seconds.to_string(),
        optional(row.cpu_seconds),
        row.rounds.to_string(),
        row.rays.to_string(),
        row.mutations.to_string(),
        row.samples.to_string(),
        optional(row.acceptance),
        errors.relative_diff.to_string(),
        errors.rel_mse.to_string(),
        errors.mape.to_string(),
        errors.mean_ratio.to_string(),
        optional(errors.flip),
        row.b.to_string(),
        optional(row.b_stderr),
        row.strata_list.len().to_string(),
    ]
}

fn quoted(cell: &str) -> String {
    match cell.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.to_owned(),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A row with a given error.
    pub(crate) fn row(method: &str, seed: u64, rel_mse: f64) -> Row {
        Row {
            key: Key {
                scene: "a, \"b\"".into(),
                method: method.into(),
                budget: "8 per pixel".into(),
                seed,
                width: 4,
                height: 2,
                max_length: None,
                threads: None,
                reference: "0".into(),
            },
            strata: "none".into(),
            seconds: 0.1,
            cpu_seconds: Some(0.2),
            rounds: 16,
            rays: 800,
            mutations: 64,
            samples: 10,
            acceptance: Some(0.25),
            errors: Errors { relative_diff: 2.0 * rel_mse, rel_mse, mape: 0.1, mean_ratio: 1.0, flip: None },
            b: 0.5,
            b_stderr: None,
            mutation_acceptance: [("lens".into(), Some(0.5)), ("other".into(), None)].into(),
            strata_list: vec![Stratum { b: 0.5, b_stderr: Some(0.1), mutations: 64 }],
        }
    }

    #[test]
    fn a_row_is_read_back_as_it_was_written() {
        let row = row("mlt", 3, 0.1 + 0.2);
        let text = serde_json::to_string(&row).expect("serialised");
        assert_eq!(serde_json::from_str::<Row>(&text).expect("parsed"), row);
    }

    #[test]
    fn csv_has_a_cell_a_column() {
        let text = csv(&[row("mlt", 3, 0.5)]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(
            lines[1].starts_with("\"a, \"\"b\"\"\",mlt,none,3,8 per pixel,4,2,,,0,0.1,0.2,16,800,64,10,0.25,1,0.5,")
        );
        let cells = lines[1].matches(',').count() - 1;
        assert_eq!(cells, lines[0].matches(',').count());
    }

    #[test]
    fn work_is_counted_in_mutations_or_else_samples() {
        let mut row = row("mlt", 0, 1.0);
        assert_eq!(row.per_pixel(), 8.0);
        (row.mutations, row.samples) = (0, 16);
        assert_eq!(row.per_pixel(), 2.0);
    }
}
