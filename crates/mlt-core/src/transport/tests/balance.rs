//! Detailed balance of one mutation, seen from outside.
//!
//! A state drawn from a batch of independent samples in proportion to its importance, with the batch's mean weight b̂,
//! has E[b̂ g(x)] = ∫ I g. After one proposal y with acceptance a, detailed balance says that as much flows from any set
//! of states A to any other B as from B to A: E[b̂ a (1_A(x) 1_B(y) − 1_B(x) 1_A(y))] = 0.

use super::worlds::World;
use crate::engine::{Generator, Importance, Purpose, Stratum, generator, uniform};
use crate::transport::lights::{LightRegion, LightStrata, Stratification};
use crate::transport::methods::metropolis::LightStratum;
use crate::transport::paths::{Classes, LightPath, Luminance};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::HashMap;

/// Independent samples of a batch.
const SAMPLES: usize = 4;
/// Proposals from one state.
const PROPOSALS: usize = 8;
/// Fewest batches in which something flows between two sets, for a test of the two.
const LEAST_FLOWS: u64 = 200;
/// Chance that a right mutation fails, over all pairs of sets.
const SIGNIFICANCE: f64 = 1e-4;

/// Writes a proposal and returns T(y→x)/T(x→y).
pub(crate) trait Proposer:
    Fn(&LightPath, &mut LightPath, &LightStratum, &mut Generator) -> Option<f64> + Sync
{
}
impl<F: Fn(&LightPath, &mut LightPath, &LightStratum, &mut Generator) -> Option<f64> + Sync> Proposer for F {}

/// A pair of sets: the partition they belong to, and their numbers in it, the smaller first.
type Pair = (usize, u32, u32);

/// Flow between the two sets of a pair.
#[derive(Clone, Copy, Default)]
struct Flow {
    sum: f64,
    squares: f64,
    batches: u64,
}

/// The largest deviation from balance.
pub(crate) struct Imbalance {
    /// Largest |z|.
    pub z: f64,
    /// |z| that a right mutation stays below.
    pub limit: f64,
    /// Where.
    pub pair: Pair,
    /// Pairs of sets tested.
    pub tests: usize,
}

impl Imbalance {
    pub(crate) fn assert_balanced(&self, name: &str) {
        let Self { z, limit, pair, tests } = self;
        assert!(*tests > 10 && z < limit, "{name}: z = {z:.2}, limit {limit:.2}, at {pair:?} of {tests}");
    }

    pub(crate) fn assert_detected(&self, name: &str) {
        assert!(self.z > self.limit, "{name}, an error that has to be seen: z = {}, limit {}", self.z, self.limit);
    }
}

/// Partitions of path space: lengths, kinds of vertices, parts of the lights, parts of the image, angles at which the
/// camera sees the first surface.
fn labels(path: &LightPath) -> [u32; 5] {
    let vertices = path.vertices();
    let kinds = vertices.iter().take(5).fold(1, |kinds, v| 2 * kinds + u32::from(v.vertex.delta));
    let cell = |x: f64, n: f64| (x * n).clamp(0.0, n - 1.0) as u32;
    let light = path.light();
    let place = 16 * light.light + 4 * cell(light.u, 4.0) + cell(light.v, 4.0);
    let image = 4 * cell(f64::from(path.film.x), 4.0) + cell(f64::from(path.film.y), 4.0);
    let first = &vertices[vertices.len() - 2];
    let angle = cell(f64::from(first.vertex.shading_normal.dot(first.to_eye).abs()), 8.0);
    [(vertices.len() as u32).min(8), kinds, place, image, angle]
}

/// The imbalance of `propose` over `batches` batches in each part of the lights.
pub(crate) fn imbalance(world: &World, cut: Stratification, batches: u64, propose: impl Proposer) -> Imbalance {
    let strata = LightStrata::new(world.scene.lights(), cut);
    imbalance_within(&LightStratum::all(&strata, world.view(), 12), batches, propose)
}

/// The imbalance of `propose` over `batches` batches in each tile of the image, two by two.
pub(crate) fn imbalance_in_tiles(world: &World, batches: u64, propose: impl Proposer) -> Imbalance {
    let strata = LightStrata::new(world.scene.lights(), Stratification::None);
    let tiles = Classes { lengths: false, tiles: [2, 2] };
    imbalance_within(&LightStratum::product(&strata, world.view(), 12, tiles), batches, propose)
}

/// The imbalance of `propose` over `batches` batches of all paths, the light end being drawn again within parts of the lights.
pub(crate) fn imbalance_of_mutation_only(
    world: &World,
    cut: Stratification,
    batches: u64,
    propose: impl Proposer,
) -> Imbalance {
    let (lights, view) = (world.scene.lights(), world.view());
    let (strata, whole) = (LightStrata::new(lights, cut), LightRegion::whole(lights));
    imbalance_within(&[LightStratum::mutation_only(&strata, &whole, view, 12)], batches, propose)
}

fn imbalance_within(strata: &[LightStratum], batches: u64, propose: impl Proposer) -> Imbalance {
    let blocks: Vec<_> = (0..batches).step_by(256).collect();
    let run = |&first: &u64| {
        let mut flows = HashMap::<Pair, Flow>::new();
        for batch in first..batches.min(first + 256) {
            for (j, stratum) in (0..).zip(strata) {
                let streams = [Purpose::Sample, Purpose::Start].map(|purpose| generator(11, purpose, batch, j, 0));
                for (pair, sum) in flow(stratum, &propose, streams) {
                    let flow = flows.entry(pair).or_default();
                    *flow = Flow { sum: flow.sum + sum, squares: flow.squares + sum * sum, batches: flow.batches + 1 };
                }
            }
        }
        flows
    };
    let mut total = HashMap::<Pair, Flow>::new();
    for (pair, flow) in blocks.par_iter().map(run).collect::<Vec<_>>().into_iter().flatten() {
        let sum = total.entry(pair).or_default();
        sum.sum += flow.sum;
        sum.squares += flow.squares;
        sum.batches += flow.batches;
    }
    total.retain(|_, flow| flow.batches >= LEAST_FLOWS);
    let z = |flow: &Flow| flow.sum.abs() / flow.squares.sqrt();
    let limit = Normal::standard().inverse_cdf(1.0 - 0.5 * SIGNIFICANCE / total.len().max(1) as f64);
    let none = ((0, 0, 0), 0.0);
    let (pair, z) =
        total.iter().map(|(pair, flow)| (*pair, z(flow))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(none);
    Imbalance { z, limit, pair, tests: total.len() }
}

/// Flows of one batch.
fn flow(stratum: &LightStratum, propose: &impl Proposer, [mut rng, mut choice]: [Generator; 2]) -> HashMap<Pair, f64> {
    let mut flows = HashMap::new();
    let (mut total, mut state) = (0.0, None::<LightPath>);
    for _ in 0..SAMPLES {
        stratum.sample(&mut rng, &mut |path, weight| {
            let weight = weight * Luminance.eval(path);
            total += weight;
            if uniform(&mut choice) * total < weight {
                state = Some(path.clone());
            }
        });
    }
    let Some(x) = state else { return flows };
    let mut y = LightPath::default();
    for _ in 0..PROPOSALS {
        let Some(ratio) = propose(&x, &mut y, stratum, &mut rng) else { continue };
        if !stratum.contains(&y) {
            continue;
        }
        let acceptance = (ratio * Luminance.eval(&y) / Luminance.eval(&x)).min(1.0);
        assert!(acceptance >= 0.0, "ratio {ratio}");
        for (partition, (from, to)) in labels(&x).into_iter().zip(labels(&y)).enumerate() {
            if from != to && acceptance > 0.0 {
                let sign = if from < to { 1.0 } else { -1.0 };
                *flows.entry((partition, from.min(to), from.max(to))).or_default() += sign * total * acceptance;
            }
        }
    }
    flows
}
