//! From what a pilot measured to errors and costs of each part.

use super::TIME_OF_A_CHAINS_RAY;
use super::candidates::Candidate;
use super::decide::Costs;
use super::measure::Measured;
use super::parts::Parts;
use crate::engine::Measure;
use crate::transport::adapt::weights_of_smooth;
use crate::transport::blur::blurred;

/// Weights of squared errors on the pilot's image. Where a sampler met something bright, the image is taken to be so.
pub(super) fn weights(measured: &[Measured; 2], size: [u32; 2]) -> Vec<f64> {
    let images = measured.each_ref().map(Measured::image);
    let smooth = images.each_ref().map(|image| blurred(image, size, 1));
    let smaller = |[a, b]: [&Vec<f64>; 2]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a.min(*b)).collect() };
    let both = smaller(images.each_ref());
    let level = |i: usize| both[i].max(0.5 * (smooth[0][i] + smooth[1][i]));
    weights_of_smooth(&(0..both.len()).map(level).collect::<Vec<_>>())
}

/// What one part costs each estimator.
pub(super) fn costs(
    part: usize,
    parts: &Parts,
    candidates: &[Candidate],
    measured: &[Measured; 2],
    chains: &[Measure],
    weights: &[f64],
) -> Costs {
    let (pixels, weight) = (weights.len() as f64, weights.iter().sum::<f64>() / weights.len() as f64);
    let found = measured.each_ref().map(|m| m.energy(part));
    let certain = found.iter().map(|[energy, error]| energy - 2.0 * error).fold(0.0, f64::max);
    let error = |method: usize| {
        let (m, [energy, _]) = (&measured[method], found[method]);
        // What N samples missed is carried by events rarer than 3/N, whose second moment is at least so large.
        let missed = weight * (0.5 * certain - energy).max(0.0).powi(2) * m.samples * pixels / 3.0;
        m.error(part, weights).max(missed)
    };
    let most = candidates.iter().map(|c| c.max_edges).max().unwrap_or(0);
    let longest = parts.group(part).most_edges(most);
    let errors = [0, 1].map(error);
    let of = |c: &Candidate| match c.scale(longest) {
        scale if scale.is_finite() => scale * errors[usize::from(!c.is_path())],
        scale => scale,
    };
    let independent = candidates.iter().map(of).collect();
    let chains = &chains[part];
    // Σ over pixels with a total of n mutations → mean over pixels with n mutations a pixel.
    let scale = pixels.powi(-2) * TIME_OF_A_CHAINS_RAY;
    let side = |error: f64, work: f64| (error * work * scale).sqrt();
    let chains = match chains.chain_error {
        // A few rounds do not tell which of the lamps in view chains have not found, and a camera ray finds them all.
        _ if longest == 1 => f64::INFINITY,
        Some(error) => side(error, chains.mutation_cost) + side(chains.sample_error, chains.sample_cost),
        // Chains that found no light where samples did are no use.
        None if found.iter().any(|[energy, _]| *energy > 0.0) => f64::INFINITY,
        None => 0.0,
    };
    Costs { independent, chains: chains * chains }
}
