//! Metropolis where it pays, independent samples where those are better.
//!
//! Path space is cut into parts: of the lights, by length, by what next-event estimation cannot sample, and images of
//! lights, which camera rays find. A pilot on a small image measures what path tracing, bidirectional path tracing and
//! chains leave of error in each part, and what they cost; then one independent method samples the parts that it finds
//! easy, and chains sample the rest.
//! Every part is sampled by exactly one of them, so the sum is unbiased whatever the pilot found.

mod candidates;
mod constants;
mod costs;
mod decide;
mod doubt;
mod measure;
mod parts;
mod per_method;
mod plan;
mod render;
mod share;
mod tails;
mod written;

use super::bidirectional::Bidirectional;
use super::counts::PilotCounts;
use super::metropolis::{LightStratum, PathMutation};
use super::path_tracing::PathTracer;
use super::samples::mutations_per_sample;
use crate::engine::{self, LEAST_CHAIN, Measure, Metropolis, Mixture, Piloted, Share, Tally, Watch};
use crate::transport::image::PixelImportance;
use crate::transport::lights::{LightRegion, LightStrata, LightTree, Stratification};
use crate::transport::scene::{View, rays_traced};
use candidates::Candidate;
use constants::{
    CHAIN_PILOT, CHAIN_ROUNDS_OF_TIME, LEAST_OF_A_PROMISE, LEAST_SHARE, LIGHT_PARTS, MOST_ROUNDS, MUTATIONS,
    MUTATIONS_PER_SAMPLE, PATHS, PIXELS, REDUCTION, ROUNDS, ROUNDS_OF_TIME, TIME_OF_CHAINS, USUAL_PIXELS,
};
use costs::{Chained, Findings, per_pixel, weights};
use decide::{Choice, Costs, Decision, decide};
use measure::Measured;
use parts::Parts;
use per_method::PerMethod;
use plan::summary;
use share::{Chains, share_out};
use tails::{Tail, Tails};

pub use candidates::Sampler;
pub use constants::{TIME_OF_A_BIDIRECTIONAL_RAY, TIME_OF_A_CHAINS_RAY};
pub use parts::SomePaths;
pub use plan::{PartSummary, Plan, Summary};
pub use render::Auto;

/// Shares of the pilot's time at which its steps begin, about: path tracing, bidirectional path tracing, tails, chains, and more of them.
const STEPS: [f64; 6] = [0.0, 0.1, 0.25, 0.5, 0.7, 1.0];

/// The task that a pilot finds a plan for.
struct Pilot<'a> {
    view: View<'a>,
    importance: &'a PixelImportance,
    /// All lights.
    lights: &'a LightRegion,
    /// How the lights are cut; `None` leaves it to the pilot.
    stratification: Stratification,
    max_edges: usize,
    seed: u64,
    /// Work of a round: as much as so many samples of path tracing a pixel.
    per_pixel: f64,
    watch: Watch<'a>,
}

impl Pilot<'_> {
    /// Measures and decides. Nothing if it is stopped.
    fn run(&self) -> Option<(Plan, PilotCounts)> {
        let (strata, camera) = (self.cut(), self.view.camera.with_size(self.size()));
        let (lights, view) = (self.view.scene.lights(), View { camera: &camera, ..self.view });
        let mut parts = Parts::new(lights, &strata, self.max_edges, view.scene.needs().specular);
        parts.asked_for = self.cut_is_asked_for();
        let parts = &parts;
        let path_space = self.open_to_chains(view, parts);

        let measured = &self.independent(view, parts)?;
        let candidates = &Candidate::all(view, self.lights, self.max_edges, self.seed);
        let weights = &weights(measured, camera.size());
        let (tails, sought) = self.tails(view, parts, &path_space, measured, weights)?;
        let findings = Findings { parts, candidates, measured, weights, tails };
        let (costs, measures, chained) = self.costs(view, &path_space, &findings)?;

        let (decision, chains) = self.hand_out(parts, self.choose(&findings, &costs), &measures);
        let (independent, summary) =
            (self.samples(candidates, &decision), summary(parts, &decision, &costs, candidates));
        let sampled = f64::from(camera.pixels()) * measured.iter().map(|m| m.work * m.samples).sum::<f64>();
        let sampled = PilotCounts { mutations: 0, rays: sampled as u64 };
        let strata = match chains.kinds.len() {
            1 => LightStrata::new(lights, Stratification::None),
            _ => strata,
        };
        let plan = Plan { independent, chained: chains.kinds, shares: chains.shares, summary, strata };
        Some((plan, sampled + sought + chained))
    }

    /// For the step of this number.
    fn part(&self, step: usize) -> Watch<'_> {
        self.watch.part(STEPS[step], STEPS[step + 1])
    }

    /// The strata of the parts that may be left to chains.
    fn open_to_chains<'s>(&self, view: View<'s>, parts: &Parts<'s>) -> Vec<LightStratum<'s>> {
        let part =
            |i: usize| LightStratum::of_part(parts.strata, parts.at(i).light, parts.group(i), view, self.max_edges);
        parts.open_to_chains().into_iter().map(part).collect()
    }

    /// The best plan by what is known.
    fn choose(&self, findings: &Findings, costs: &[Costs]) -> Choice {
        // A round has one sample at least.
        let budget = self.per_pixel.max(1.0) * findings.measured.path.work;
        let work: Vec<_> = findings.candidates.iter().map(|candidate| candidate.work).collect();
        decide(budget, &work, costs)
    }

    /// The independent method of a decision, and its samples of each pixel.
    fn samples(&self, candidates: &[Candidate], decision: &Decision) -> Option<(Sampler, f64)> {
        decision.independent.map(|(m, samples)| match candidates[m].sampler {
            // As many as were asked for.
            sampler @ Sampler::Path { branches: 1 } if decision.chain_work == 0.0 => (sampler, self.per_pixel),
            sampler => (sampler, samples),
        })
    }

    /// Gives chains their shares: of the mixture, if that is still better than the best method alone with the numbers that
    /// they get in fact.
    fn hand_out(&self, parts: &Parts, choice: Choice, measures: &[Measure]) -> (Decision, Chains) {
        let pixels = f64::from(self.view.camera.pixels());
        let usual = mutations_per_sample(self.view, engine::MUTATIONS_PER_SAMPLE);
        let with_shares = |decision: Decision| {
            let chains = share_out(parts, &decision, measures, decision.chain_work * pixels, usual);
            debug_assert!(chains.work > LEAST_OF_A_PROMISE, "chains were promised {decision:?}");
            (decision.with(&chains), chains)
        };
        let single = choice.single.product();
        let mixture = choice.mixture.map(with_shares).filter(|(mixture, _)| mixture.product() <= single);
        mixture.unwrap_or_else(|| with_shares(choice.single))
    }

    /// Cost of each part by each estimator, and what chains find there, from more rounds if chains are to do anything; and
    /// what the rounds took.
    fn costs(
        &self,
        view: View,
        path_space: &[LightStratum],
        findings: &Findings,
    ) -> Option<(Vec<Costs>, Vec<Measure>, PilotCounts)> {
        let measure = |rounds, part| {
            let (chains, tally) = self.chains(view, path_space, findings, (rounds, self.part(part)))?;
            let measures = chains.iter().map(|c| c.measure).collect();
            Some((findings.costs(&chains), measures, PilotCounts::of(&tally)))
        };
        let (costs, chains, first) = measure(ROUNDS, 3)?;
        let more = self.more_rounds(view.camera.pixels());
        if more <= ROUNDS || self.choose(findings, &costs).best().chain_work == 0.0 {
            return Some((costs, chains, first));
        }
        let (costs, chains, second) = measure(more, 4)?;
        Some((costs, chains, first + second))
    }

    fn cut_is_asked_for(&self) -> bool {
        !matches!(self.stratification, Stratification::None | Stratification::Auto)
    }

    fn cut(&self) -> LightStrata {
        let lights = self.view.scene.lights();
        if self.cut_is_asked_for() {
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

    fn independent(&self, view: View, parts: &Parts) -> Option<PerMethod<Measured>> {
        let (region, light_sampler, max_edges) = (self.lights, self.lights.light_sampler(), self.max_edges);
        let samples = |n: f64| (n.max(1.0) as u64).next_power_of_two();
        let (path, bidirectional) = (samples(self.per_pixel), samples(self.per_pixel / PATHS));
        let tracer = PathTracer { view, light_sampler, max_edges, max_image_edges: max_edges, branches: 1 };
        let connected = Bidirectional { view, region, max_edges };
        Some(PerMethod {
            path: Measured::new(&tracer, parts, path, self.seed, self.part(0))?,
            bidirectional: Measured::new(&connected, parts, bidirectional, self.seed, self.part(1))?,
        })
    }

    /// Rounds of chains, where it depends on them what is decided.
    fn more_rounds(&self, pixels: u32) -> u64 {
        let time_of_a_round = TIME_OF_CHAINS / ROUNDS as f64 * f64::from(pixels);
        let affordable = CHAIN_ROUNDS_OF_TIME * self.per_pixel * f64::from(self.view.camera.pixels()) / time_of_a_round;
        (affordable as u64).min(MOST_ROUNDS)
    }

    /// Mutations of each part's chains in a round of the pilot.
    fn mutations(&self, pixels: u32, parts: usize) -> u64 {
        ((MUTATIONS * f64::from(pixels) / parts.max(1) as f64) as u64).max(LEAST_CHAIN)
    }

    /// Light that independent samples have missed, in each part.
    fn tails(
        &self,
        view: View,
        parts: &Parts,
        strata: &[LightStratum],
        measured: &PerMethod<Measured>,
        weights: &[f64],
    ) -> Option<(Vec<PerMethod<Tail>>, PilotCounts)> {
        let largest = |part: usize| measured.as_ref().map(|m| m.largest[part]);
        let largest: Vec<_> = parts.open_to_chains().into_iter().map(largest).collect();
        let (importance, lights, seed, watch) = (self.importance, self.lights, self.seed, self.part(2));
        let mutations = ROUNDS * self.mutations(view.camera.pixels(), strata.len());
        let tails = Tails { view, importance, lights, seed, weights, watch };
        let (found, spent) = tails.measure(strata, &largest, mutations)?;
        Some((parts.of_all(found), spent))
    }

    /// Findings of chains in each part.
    fn chains(
        &self,
        view: View,
        strata: &[LightStratum],
        findings: &Findings,
        (rounds, watch): (u64, Watch),
    ) -> Option<(Vec<Chained>, Tally)> {
        let mutations = self.mutations(view.camera.pixels(), strata.len());
        let share = Share { mutations, samples: mutations.div_ceil(MUTATIONS_PER_SAMPLE) };
        let strata: Vec<_> = strata.iter().map(|&stratum| (stratum, share)).collect();
        let mixture = Mixture::new(PathMutation::all(view));
        let (importance, seed) = (self.importance, self.seed);
        let pixels = view.camera.pixels();
        let (rounds_of_pilot, weigh) = (CHAIN_PILOT..CHAIN_PILOT + rounds, |_: &[f64]| findings.weights.to_vec());
        let pilot = |chains: Metropolis<_, _, _, _>| {
            chains.counting(rays_traced).partial().pilot(pixels, rounds_of_pilot, &weigh, watch)
        };
        // Where paths may have one edge only, no part is open to chains.
        let Piloted { measures, images, tally } =
            Metropolis::new(&strata, &mixture, importance, seed).map_or_else(|_| Some(Piloted::default()), pilot)?;
        let of_image = |(part, (measure, image)): (usize, (Measure, Vec<_>))| {
            let energy = image.iter().map(|(_, value)| value).sum::<f64>() / f64::from(pixels);
            let relative = if measure.b > 0.0 { measure.b_stderr / measure.b } else { 0.0 };
            let missed = findings.missed_by_chains(part, &image) * (rounds * mutations) as f64;
            let measure = match measure.chain_error {
                Some(error) if error < missed => {
                    Measure { chain_error: Some(missed), chain_events: f64::INFINITY, ..measure }
                }
                _ => measure,
            };
            let measure = per_pixel(measure, pixels, self.view.camera.pixels());
            Chained { measure, energy: [energy, relative * energy] }
        };
        let open = findings.parts.open_to_chains();
        let found = open.into_iter().zip(measures.into_iter().zip(images)).map(of_image).collect();
        let mut found = findings.parts.of_all(found);
        findings.fill_in(&mut found);
        Some((found, tally))
    }
}
