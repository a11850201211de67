//! Metropolis where it pays, independent samples where those are better.
//!
//! Path space is cut into parts: of the lights, by length, and by what next-event estimation cannot sample. A pilot on a
//! small image measures what path tracing, bidirectional path tracing and chains leave of error in each part, and
//! what they cost; then one independent method samples the parts that it finds easy, and chains sample the rest.
//! Every part is sampled by exactly one of them, so the sum is unbiased whatever the pilot found.

mod candidates;
mod decide;
mod measure;
mod parts;

use super::adapt::weights_of_smooth;
use super::bdpt::Bidirectional;
use super::blur::blurred;
use super::kind::Kinds;
use super::light_tree::LightTree;
use super::mutate::PathMutation;
use super::next_event::NextEvent;
use super::path::{LightPath, View};
use super::pt::PathTracer;
use super::region::LightRegion;
use super::render::PilotCounts;
use super::scene::rays_traced;
use super::strata::{LightStrata, Stratification};
use super::stratum::LightStratum;
use crate::engine::{Importance, LEAST_CHAIN, Measure, Metropolis, Mixture, PILOT, Share, Tally, allocate};
use candidates::{Candidate, OF_A_LENGTH};
use decide::{Costs, Decision, decide};
use measure::Measured;
use parts::Parts;

pub use candidates::Sampler;
pub use parts::SomePaths;

/// Time of a ray of chains, with all that comes with it, over that in path tracing.
const TIME_OF_A_CHAINS_RAY: f64 = 1.2;

/// How a render is made.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The lights' parts.
    pub(super) strata: LightStrata,
    /// The independent method and its samples of each pixel in a round.
    pub(super) independent: Option<(Sampler, f64)>,
    /// The kinds of paths in each of the lights' parts that are left to chains.
    pub(super) chained: Vec<Kinds>,
    /// Chains of a round, one share for each part with any such kinds.
    pub(super) shares: Vec<Share>,
    /// What was decided, for a report.
    pub summary: Summary,
}

impl Plan {
    /// A plan of the caller's: `chained` are the kinds in each part of the lights that chains sample, with one of `shares` for
    /// each that is not empty; the independent method takes `samples` of each pixel in a round for all other paths.
    pub fn new(
        strata: LightStrata,
        (sampler, samples): (Sampler, f64),
        chained: Vec<Kinds>,
        shares: Vec<Share>,
    ) -> Self {
        let summary = Summary { sampler: Some(sampler), chain_share: f64::NAN, parts: Vec::new() };
        Self { strata, independent: Some((sampler, samples)), chained, shares, summary }
    }

    /// The kinds of paths in each of the lights' parts that are sampled independently.
    pub(super) fn sampled(&self) -> Vec<Kinds> {
        self.chained.iter().map(|kinds| kinds.others()).collect()
    }

    /// Most edges of these, if no path has more than `most`.
    pub(super) fn sampled_edges(&self, most: usize) -> usize {
        self.sampled().iter().map(|kinds| kinds.most_edges(most)).max().unwrap_or(most).max(1)
    }
}

/// What a pilot decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The independent method.
    pub sampler: Option<Sampler>,
    /// Share of the work, by rays and what comes with them, that chains get; NaN where no pilot measured it.
    pub chain_share: f64,
    /// Every part of path space.
    pub parts: Vec<PartSummary>,
}

/// What a pilot found of one part of path space.
///
/// Each noise is error × work: the part's contribution to the image's mean of Var/(L² + (L̄/10)²), times the rays that
/// were traced for it a pixel. It is infinite where a method missed what another one found.
#[derive(Clone, Debug, PartialEq)]
pub struct PartSummary {
    /// Which part of the lights.
    pub light: usize,
    /// Which paths.
    pub kinds: Kinds,
    /// Noise of path tracing.
    pub path: f64,
    /// Noise of bidirectional path tracing.
    pub bidirectional: f64,
    /// Noise of chains.
    pub chains: f64,
    /// Whether chains sample it.
    pub in_chains: bool,
}

/// Pixels of the image for each of the pilot's, but no fewer than [`USUAL_PIXELS`].
const REDUCTION: f64 = 16.0;
/// Pixels of the pilot's image, unless that takes too long.
const USUAL_PIXELS: f64 = 4096.0;
/// Fewest and most of them.
const PIXELS: [f64; 2] = [256.0, 16_384.0];
/// Time of the pilot over that of a round, at most.
const ROUNDS_OF_TIME: f64 = 1.5;
/// Time of the pilot's chains for one of its pixels, in samples of path tracing, about.
const TIME_OF_CHAINS: f64 = 30.0;
/// Samples of path tracing in the time of one of bidirectional path tracing, about.
const PATHS: f64 = 4.0;
/// Mutations a pixel and round of the pilot.
const MUTATIONS: f64 = 8.0;
/// Mutations for each independent sample of the pilot.
const MUTATIONS_A_SAMPLE: u64 = 8;
/// Rounds of the pilot's chains.
const ROUNDS: u64 = 4;
/// Most parts of the lights, unless they are asked for.
const LIGHT_PARTS: usize = 8;
/// Least share of the power of a part that is asked for: the pilot measures each of them in every pixel.
const LEAST_SHARE: f64 = 1.0 / 16.0;
/// Number of the first round of the pilot's chains.
const CHAIN_PILOT: u64 = PILOT + (1 << 40);

/// What a pilot is to find a plan for.
pub(super) struct Pilot<'a, I> {
    pub(super) view: View<'a>,
    pub(super) importance: &'a I,
    pub(super) next_event: &'a NextEvent,
    /// How the lights are cut; `None` leaves it to the pilot.
    pub(super) stratification: Stratification,
    pub(super) max_edges: usize,
    pub(super) seed: u64,
    /// Work of a round: as much as so many samples of path tracing a pixel.
    pub(super) per_pixel: f64,
}

impl<I: Importance<LightPath> + Sync> Pilot<'_, I> {
    /// Measures and decides.
    pub(super) fn run(&self) -> (Plan, PilotCounts) {
        let lights = self.view.scene.lights();
        let strata = self.cut();
        let specular = self.view.scene.materials().iter().any(|m| m.bsdf.is_delta());
        let parts = Parts::new(lights, &strata, self.max_edges, specular);
        let camera = self.view.camera.with_size(self.size());
        let view = View { camera: &camera, ..self.view };
        let measured = self.independent(view, &parts);
        let candidates = Candidate::all(view, self.next_event, self.max_edges, self.seed);
        let weights = weights(&measured, camera.size());
        let (chains, tally) = self.chains(view, &parts, &weights);
        let costs: Vec<_> =
            (0..parts.len()).map(|i| costs(i, &parts, &candidates, &measured, &chains, &weights)).collect();
        let work: Vec<_> = candidates.iter().map(|candidate| candidate.work).collect();
        let decision = decide(&work, &costs);
        let budget = self.per_pixel * measured[0].work;
        let samples = decision.independent.map_or(0.0, |m| match candidates[m].sampler {
            Sampler::Path { branches: 1 } if decision.chain_share == 0.0 => self.per_pixel,
            _ => good_number(budget, &decision, work[m]),
        });
        let rest = budget - decision.independent.map_or(0.0, |m| samples * work[m]);
        let (chained, shares) = share_out(&parts, &decision, &chains, rest * f64::from(self.view.camera.pixels()));
        let independent = decision.independent.map(|m| (candidates[m].sampler, samples));
        let sampled = f64::from(camera.pixels()) * measured.iter().map(|m| m.work * m.samples).sum::<f64>();
        let spent = PilotCounts { mutations: tally.total().steps(), rays: tally.work() + sampled as u64 };
        let summary = summary(&parts, &decision, &costs, &candidates);
        (Plan { independent, chained, shares, summary, strata }, spent)
    }

    fn cut(&self) -> LightStrata {
        let lights = self.view.scene.lights();
        if !matches!(self.stratification, Stratification::None | Stratification::Auto) {
            return LightStrata::with_least_share(lights, self.stratification, LEAST_SHARE);
        }
        // Parts of one light hardly ever differ in what samples them best.
        let tree = LightTree::new(lights);
        LightStrata::of_cut(lights, &tree, &tree.cut(LIGHT_PARTS.min(lights.lights.len()), 0.0), 0.0)
    }

    /// Size of the pilot's image.
    fn size(&self) -> [u32; 2] {
        let [w, h] = self.view.camera.size().map(f64::from);
        let time_of_a_pixel = 4.0 * self.per_pixel.max(4.0) + TIME_OF_CHAINS;
        let affordable = ROUNDS_OF_TIME * self.per_pixel * w * h / time_of_a_pixel;
        let pixels = (w * h / REDUCTION).max(USUAL_PIXELS).min(affordable).clamp(PIXELS[0], PIXELS[1]);
        let scale = (pixels / (w * h)).sqrt().min(1.0);
        [w, h].map(|n| (n * scale).round().max(1.0) as u32)
    }

    fn independent(&self, view: View, parts: &Parts) -> [Measured; 2] {
        let region = &LightRegion::whole(view.scene.lights());
        let max_edges = self.max_edges;
        let samples = |n: f64| (n.max(1.0) as u64).next_power_of_two();
        let (path, bidirectional) = (samples(self.per_pixel), samples(self.per_pixel / PATHS));
        [
            Measured::new(
                &PathTracer { view, next_event: self.next_event, max_edges, branches: 1 },
                parts,
                path,
                self.seed,
            ),
            Measured::new(&Bidirectional { view, region, max_edges }, parts, bidirectional, self.seed),
        ]
    }

    /// What chains find in each part.
    fn chains(&self, view: View, parts: &Parts, weights: &[f64]) -> (Vec<Measure>, Tally) {
        let strata: Vec<_> = (0..parts.strata.regions().len())
            .flat_map(|j| parts.groups.iter().map(move |&kinds| (j, kinds)))
            .map(|(j, kinds)| LightStratum::of_part(parts.strata, j, kinds, view, self.max_edges))
            .collect();
        let mutations = (MUTATIONS * f64::from(view.camera.pixels()) / strata.len() as f64) as u64;
        let mutations = mutations.max(LEAST_CHAIN);
        let shares = vec![Share { mutations, samples: mutations.div_ceil(MUTATIONS_A_SAMPLE) }; strata.len()];
        let mixture = Mixture::new(PathMutation::all(view));
        let (importance, seed) = (self.importance, self.seed);
        let chains =
            Metropolis { strata: &strata, shares: &shares, mixture: &mixture, importance, seed, work: rays_traced };
        chains.pilot(view.camera.pixels(), CHAIN_PILOT..CHAIN_PILOT + ROUNDS, &|_| weights.to_vec())
    }
}

/// Weights of squared errors on the pilot's image. Where a sampler met something bright, the image is taken to be so.
fn weights(measured: &[Measured; 2], size: [u32; 2]) -> Vec<f64> {
    let images = measured.each_ref().map(Measured::image);
    let smooth = images.each_ref().map(|image| blurred(image, size, 1));
    let smaller = |[a, b]: [&Vec<f64>; 2]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a.min(*b)).collect() };
    let both = smaller(images.each_ref());
    let level = |i: usize| both[i].max(0.5 * (smooth[0][i] + smooth[1][i]));
    weights_of_smooth(&(0..both.len()).map(level).collect::<Vec<_>>())
}

/// What one part costs each estimator.
fn costs(
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
        Some(error) => side(error, chains.mutation_cost) + side(chains.sample_error, chains.sample_cost),
        // Chains that found no light where samples did are no use.
        None if found.iter().any(|[energy, _]| *energy > 0.0) => f64::INFINITY,
        None => 0.0,
    };
    Costs { independent, chains: chains * chains }
}

/// The kinds of each of the lights' parts that chains sample, and their shares of a round of so much work.
fn share_out(parts: &Parts, decision: &Decision, measures: &[Measure], work: f64) -> (Vec<Kinds>, Vec<Share>) {
    let (mut chained, mut unions) = (Vec::new(), Vec::new());
    let groups = parts.groups.len();
    for (in_chains, measures) in decision.in_chains.chunks(groups).zip(measures.chunks(groups)) {
        let of = parts.groups.iter().zip(measures).zip(in_chains).filter(|(_, chained)| **chained);
        let (kinds, measures): (Vec<Kinds>, Vec<Measure>) = of.map(|((kinds, m), _)| (kinds, *m)).unzip();
        chained.push(kinds.iter().flat_map(|kinds| kinds.iter()).fold(Kinds::NONE, Kinds::with));
        if !measures.is_empty() {
            unions.push(Measure::of_union(&measures));
        }
    }
    let mut mutations = work / (2.0 * TIME_OF_A_CHAINS_RAY);
    let mut shares = Vec::new();
    for _ in 0..3 {
        let n = (mutations.max(1.0) / unions.len().max(1) as f64) as u64;
        let even = vec![Share { mutations: n.max(1), samples: (n / MUTATIONS_A_SAMPLE).max(1) }; unions.len()];
        shares = allocate(&unions, &even, mutations.max(1.0));
        let cost = |(share, m): (&Share, &Measure)| {
            share.mutations as f64 * m.mutation_cost + share.samples as f64 * m.sample_cost
        };
        let expected = TIME_OF_A_CHAINS_RAY * shares.iter().zip(&unions).map(cost).sum::<f64>();
        mutations *= if expected > 0.0 { (work / expected).clamp(0.1, 10.0) } else { 1.0 };
    }
    (chained, shares)
}

/// Samples of each pixel in a round of so much work a pixel: about the independent method's share, but the first 2^k points
/// of a sequence, which are much better spread than any other number of them.
fn good_number(budget: f64, decision: &Decision, work: f64) -> f64 {
    let ideal = (budget * (1.0 - decision.chain_share) / work).max(1.0);
    let lower = libm::exp2(libm::floor(libm::log2(ideal)));
    // Chains keep half of their share at least.
    let room = decision.chain_share == 0.0 || 2.0 * lower * work <= budget * (1.0 - 0.5 * decision.chain_share);
    if ideal > std::f64::consts::SQRT_2 * lower && room { 2.0 * lower } else { lower }
}

fn summary(parts: &Parts, decision: &Decision, costs: &[Costs], candidates: &[Candidate]) -> Summary {
    let groups = parts.groups.len();
    // Path tracing without branches and bidirectional path tracing, of paths of all lengths, are the first and the last.
    let lengths = &candidates[candidates.len() - OF_A_LENGTH..];
    let noise = |costs: &Costs, m: usize| costs.independent[candidates.len() - OF_A_LENGTH + m] * lengths[m].work;
    let part = |(i, costs): (usize, &Costs)| PartSummary {
        light: i / groups,
        kinds: parts.group(i),
        path: noise(costs, 0),
        bidirectional: noise(costs, OF_A_LENGTH - 1),
        chains: costs.chains,
        in_chains: decision.in_chains[i],
    };
    Summary {
        sampler: decision.independent.map(|m| candidates[m].sampler),
        chain_share: decision.chain_share,
        parts: costs.iter().enumerate().map(part).collect(),
    }
}
