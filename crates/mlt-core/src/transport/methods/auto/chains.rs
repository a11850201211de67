//! The error that chains leave in their share of the image, and their shares of a round.

use super::constants::{MOST_WALKS, PILOT_MUTATIONS_PER_SAMPLE, TIME_OF_A_CHAINS_RAY, WALKS};
use crate::engine::{Measure, Share, allocate};
use crate::transport::scene::View;

/// Error that chains leave in an image of `to` pixels, as a mean over pixels and for each mutation and sample a pixel, from the
/// sum over a pilot's image of `from` pixels and for each mutation and sample.
///
/// A pixel of the larger image gets fewer visits, but an error of b_j is the same in all of them.
pub(super) fn per_pixel(measure: Measure, from: u32, to: u32) -> Measure {
    let [from, to] = [from, to].map(f64::from);
    Measure {
        chain_error: measure.chain_error.map(|error| error / (from * from)),
        sample_error: measure.sample_error / (from * to),
        ..measure
    }
}

/// Chains' work in a round, that of all pixels, and how they spend it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    pub(super) work: f64,
    /// Mutations for each independent sample, if their noise does not ask for more samples.
    pub(super) mutations_per_sample: u64,
    /// Most samples of the last stratum, if that holds what only chance meets; else 0.
    pub(super) most_walks: u64,
}

/// [`Budget::most_walks`]: a sample takes 16 bytes while a round is prepared.
pub(super) fn most_walks(view: &View) -> u64 {
    let most = u64::from(view.camera.pixels()).max(MOST_WALKS);
    if view.scene.needs().met_by_chance { most } else { 0 }
}

/// Error × work of chains in these strata with what they are handed out of a budget. `starts`: what their starts leave by strata, as chains
/// tell it, which may be more than samples do.
pub(super) fn product(measures: &[Measure], starts: &[f64], budget: Budget) -> f64 {
    let shares = share_out(measures, budget);
    let with =
        |(&measure, &starts): (&Measure, &f64)| Measure { sample_error: measure.sample_error.max(starts), ..measure };
    let noisy = measures.iter().zip(starts).map(with);
    let error: f64 = noisy.zip(&shares).map(|(measure, share)| measure.error(share)).sum();
    let spent: f64 = measures.iter().zip(&shares).map(|(measure, share)| work_of(measure, share)).sum();
    // For each of P pixels, errors are P times as large and the work is a Pth.
    error * spent
}

/// Shares of a round.
pub(super) fn share_out(measures: &[Measure], budget: Budget) -> Vec<Share> {
    let Budget { work, mutations_per_sample, most_walks } = budget;
    let mut mutations = work / (2.0 * TIME_OF_A_CHAINS_RAY);
    let mut shares = Vec::new();
    for _ in 0..3 {
        let n = (mutations.max(1.0) / measures.len() as f64) as u64;
        let even =
            vec![Share { mutations: n.max(1), samples: (n / PILOT_MUTATIONS_PER_SAMPLE).max(1) }; measures.len()];
        shares = allocate(measures, &even, mutations.max(1.0), mutations_per_sample);
        if let (Some(share), Some(measure)) = (shares.last_mut(), measures.last()) {
            let rays = WALKS * work / TIME_OF_A_CHAINS_RAY;
            let walks = (rays / measure.sample_cost.max(1.0)) as u64;
            share.samples = share.samples.max(walks.min(most_walks));
        }
        let expected = measures.iter().zip(&shares).map(|(m, share)| work_of(m, share)).sum::<f64>() / work;
        mutations *= if expected > 0.0 { expected.recip().clamp(0.1, 10.0) } else { 1.0 };
    }
    shares
}

fn work_of(measure: &Measure, share: &Share) -> f64 {
    let rays = share.mutations as f64 * measure.mutation_cost + share.samples as f64 * measure.sample_cost;
    TIME_OF_A_CHAINS_RAY * rays
}
