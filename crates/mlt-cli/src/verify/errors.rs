//! How large errors are, whether error bars cover them, and how far seeds differ.

use serde::{Deserialize, Serialize};

use super::evidence::Evidence;
use crate::bench::statistics::{mean_of, median_of};

/// Added to the squared truth, in units of the mean luminance squared, where an error is divided by it.
const EPSILON: f64 = 1e-2;
/// Classes of luminance.
const DECILES: usize = 10;
/// The normal law's quantile for intervals of 95 %.
const NORMAL: f64 = 1.96;
/// Pixels darker than this share of the mean have no error bar worth the name.
const DARK: f64 = 1e-6;

/// Sizes of the errors of replicas.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Errors {
    /// relMSE of single replicas, mean (a − b)²/(a² + 10⁻² ā²), ā the image's mean luminance: its mean over replicas.
    pub rel_mse: f64,
    /// Its standard deviation over replicas.
    pub deviation: f64,
    /// Its median.
    pub median: f64,
    /// Its largest over its median.
    pub worst: f64,
    /// Share of the nominal 95 % intervals that hold the truth, over the replicas that do not doubt them; `None` where all do or report
    /// none.
    pub coverage: Option<f64>,
    /// Replicas that say themselves that their intervals cannot be trusted.
    pub doubted: usize,
    /// Root of the mean squared relative error by deciles of the truth's luminance, from dark to bright.
    pub deciles: Vec<f64>,
    /// relMSE between the first two seeds.
    pub flicker: f64,
    /// The same between two frames of one seed with the lights moved by a millionth of the scene, over `flicker`.
    pub moved: Option<f64>,
}

/// Measures the replicas.
pub fn errors(evidence: &Evidence) -> Errors {
    let truth = evidence.truth();
    let level = mean_of(truth.iter().map(|pixel| pixel.0));
    let relative = |pixels: &[f64]| rel_mse(truth.iter().map(|pixel| pixel.0), pixels, level);
    let of_replicas: Vec<f64> = evidence.images().map(relative).collect();
    let (mean, median) = (mean_of(of_replicas.iter().copied()), median_of(of_replicas.iter().copied()));
    let squares = of_replicas.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    let [first, second] = [0, 1].map(|i| &evidence.method[i].pixels);
    Errors {
        rel_mse: mean,
        deviation: (squares / (of_replicas.len() as f64 - 1.0)).sqrt(),
        median,
        worst: of_replicas.iter().copied().fold(0.0, f64::max) / median,
        coverage: coverage(evidence, &truth, level),
        doubted: evidence.method.iter().filter(|replica| replica.doubted).count(),
        deciles: deciles(evidence, &truth),
        flicker: rel_mse(first.iter().copied(), second, level),
        moved: None,
    }
}

/// mean (a − b)²/(a² + 10⁻² ā²).
pub fn rel_mse(a: impl Iterator<Item = f64>, b: &[f64], level: f64) -> f64 {
    let epsilon = EPSILON * level * level;
    mean_of(a.zip(b).map(|(a, b)| (a - b).powi(2) / (a * a + epsilon)))
}

/// Share of the intervals b ± 1.96·√(stderr² + truth's variance) that hold a.
///
/// Over the pixels that are lit, of replicas that do not doubt it. Errors are those of several pixels together, so that few
/// rounds do not make them uncertain: see [`Film::standard_errors`](mlt_core::engine::Film::standard_errors).
fn coverage(evidence: &Evidence, truth: &[(f64, f64)], level: f64) -> Option<f64> {
    let (mut held, mut all) = (0u64, 0u64);
    for replica in evidence.method.iter().filter(|replica| !replica.doubted) {
        let pixels = replica.pixels.iter().zip(&replica.stderr).zip(truth);
        for ((b, stderr), (a, variance)) in pixels.filter(|(_, truth)| truth.0 > DARK * level) {
            held += u64::from((a - b).abs() <= NORMAL * (stderr * stderr + variance).sqrt());
            all += 1;
        }
    }
    (all > 0).then(|| held as f64 / all as f64)
}

fn deciles(evidence: &Evidence, truth: &[(f64, f64)]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..truth.len()).filter(|&i| truth[i].0 > 0.0).collect();
    order.sort_by(|&i, &j| truth[i].0.total_cmp(&truth[j].0));
    let class = |k: usize| &order[order.len() * k / DECILES..order.len() * (k + 1) / DECILES];
    let error = |pixels: &[usize]| {
        let square = |i: usize| evidence.images().map(|b| (b[i] / truth[i].0 - 1.0).powi(2)).sum::<f64>();
        mean_of(pixels.iter().map(|&i| square(i) / evidence.method.len() as f64)).sqrt()
    };
    (0..DECILES).map(|k| error(class(k))).filter(|error| error.is_finite()).collect()
}
