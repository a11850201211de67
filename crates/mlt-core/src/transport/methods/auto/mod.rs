//! Path tracing, and Metropolis for what is rare in it.
//!
//! Each path is worth some value to path tracing's samples. The larger that is, beside what its pixel is expected to show, the larger the share
//! of the path that chains take: samples have no value left that stands out, and chains go where such values would come from. The share is a function
//! of the path alone, so the sum is unbiased whatever a pilot found. That measures, on a small image, what samples and chains leave of
//! error in their shares, and shares the work out.

mod chains;
mod constants;
mod decide;
mod levels;
mod measure;
mod plan;
mod render;
mod split;
mod tail;
mod written;

use super::bidirectional::Bidirectional;
use super::counts::PilotCounts;
use super::metropolis::{LightStratum, PathMutation};
use super::path_tracing::PathTracer;
use super::samples::mutations_per_sample;
use crate::engine::{self, LEAST_CHAIN, Measure, Metropolis, Mixture, Share, Watch};
use crate::transport::image::PixelImportance;
use crate::transport::lights::{LightRegion, LightStrata, Stratification};
use crate::transport::scene::{View, rays_traced};
use chains::{for_more, per_pixel, product, share_out};
use constants::{
    BRANCHES, CHAIN_PILOT, GAIN, LEAST_SHARE, MUTATIONS, MUTATIONS_PER_SAMPLE, PIXELS, REDUCTION, ROUNDS,
    ROUNDS_OF_TIME, TIME_OF_CHAINS, USUAL_PIXELS,
};
use decide::{Candidate, Decision, decide};
use levels::Levels;
use measure::{Measured, work_of};
use split::{IN_VIEW, Split, Taken};
use tail::Tail;

pub use constants::TIME_OF_A_CHAINS_RAY;
pub use plan::{Plan, Summary};
pub use render::Auto;

/// Shares of the pilot's time at which its steps begin, about: levels, path tracing, tail, chains.
const STEPS: [f64; 5] = [0.0, 0.1, 0.3, 0.6, 1.0];

/// The task that a pilot finds a plan for.
struct Pilot<'a> {
    view: View<'a>,
    importance: &'a PixelImportance,
    /// All lights.
    lights: &'a LightRegion,
    /// How the lights are cut for chains.
    stratification: Stratification,
    max_edges: usize,
    seed: u64,
    /// Work of a round: as much as so many samples of path tracing a pixel.
    per_pixel: f64,
    watch: Watch<'a>,
}

/// What chains leave and find.
struct Chained {
    /// By strata, per pixel of the render.
    measures: Vec<Measure>,
    /// Mean over pixels, sum over channels.
    energy: f64,
}

/// Findings of a pilot.
struct Findings {
    measured: Measured,
    /// T.
    tail: f64,
    chained: Chained,
    /// Share of the light, lamps in view left out, that is left to chains.
    hard: f64,
}

impl Findings {
    /// Chains that take all light, lamps in view left out, as far as they are like those that were measured.
    fn of_all_light(&self) -> Vec<Measure> {
        self.chained.measures.iter().map(|&measure| for_more(measure, self.hard.recip())).collect()
    }
}

impl Pilot<'_> {
    /// Measures and decides. Nothing if it is stopped.
    fn run(&self) -> Option<(Plan, PilotCounts)> {
        let (strata, camera) = (self.cut(), self.view.camera.with_size(self.size()));
        let view = View { camera: &camera, ..self.view };
        let of_light = Bidirectional { view, region: self.lights, max_edges: self.max_edges };
        let (levels, weights) = Levels::measure(&of_light, self.seed, self.part(0))?;
        let split = Split::new(&levels, camera.size(), self.max_edges);
        let (findings, spent) = self.findings(view, &strata, &split, &weights)?;

        let [alone, mixed] = decide(&self.candidates(view, &findings), self.per_pixel);
        let chosen = if findings.hard > 0.0 && mixed.product < GAIN * alone.product { mixed } else { alone };
        let Decision { candidate: Candidate { branches, max_edges, work, .. }, samples, chain_work, .. } = chosen;
        let summary = Summary {
            branches,
            lamps_only: max_edges < self.max_edges,
            chain_share: chain_work / (chain_work + samples * work),
            hard_light: findings.hard,
            path: alone.product,
            mixture: mixed.product,
        };
        let shares = self.shares(&chosen, &findings);
        Some((Plan { strata, levels, branches, max_edges, samples, shares, summary }, spent))
    }

    /// Measures both at this split.
    fn findings(
        &self,
        view: View,
        strata: &LightStrata,
        split: &Split,
        weights: &[f64],
    ) -> Option<(Findings, PilotCounts)> {
        let samples = (self.per_pixel.max(1.0) as u64).next_power_of_two();
        let measured = Measured::new(&self.tracer(view, 1), split, samples, (weights, self.seed), self.part(1))?;
        let pixels = view.camera.pixels();
        let sampled = PilotCounts { mutations: 0, rays: (f64::from(pixels) * measured.work * measured.samples) as u64 };

        let strata = &LightStratum::of_kinds(strata, IN_VIEW.others(), view, self.max_edges);
        let mutations = ((MUTATIONS * f64::from(pixels) / strata.len().max(1) as f64) as u64).max(LEAST_CHAIN);
        let taken = Taken { importance: self.importance, view, lights: self.lights, split };
        let tail = Tail { taken, weights, seed: self.seed };
        let (tail, sought) = tail.measure(strata, ROUNDS * mutations, self.part(2))?;
        let (chained, spent) = self.chains(taken, strata, mutations, weights)?;
        let easy = measured.energies[1] + measured.energies[2];
        let hard = if chained.energy > 0.0 { chained.energy / (chained.energy + easy) } else { 0.0 };
        Some((Findings { measured, tail, chained, hard }, sampled + sought + spent))
    }

    /// For the step of this number.
    fn part(&self, step: usize) -> Watch<'_> {
        self.watch.part(STEPS[step], STEPS[step + 1])
    }

    fn tracer<'s>(&'s self, view: View<'s>, branches: u32) -> PathTracer<'s> {
        let (light_sampler, max_edges) = (self.lights.light_sampler(), self.max_edges);
        PathTracer { view, light_sampler, max_edges, max_image_edges: max_edges, branches }
    }

    /// Path tracing with each number of branches, and of lamps in view alone.
    fn candidates(&self, view: View, findings: &Findings) -> Vec<Candidate> {
        let &Findings { measured, tail, .. } = findings;
        let [in_view, direct, long] = measured.errors;
        let branch = (work_of(&self.tracer(view, 2), self.seed) - measured.work).max(0.0);
        let with = |branches: u32| Candidate {
            branches,
            max_edges: self.max_edges,
            work: measured.work + f64::from(branches - 1) * branch,
            errors: [in_view + direct, long / f64::from(branches)],
            tail: tail / f64::from(branches),
            chains: product(&findings.chained.measures),
        };
        let tracer = PathTracer { max_edges: 1, max_image_edges: 1, ..self.tracer(view, 1) };
        let lamps = || Candidate {
            branches: 1,
            max_edges: 1,
            work: work_of(&tracer, self.seed),
            errors: [in_view, 0.0],
            tail: f64::INFINITY,
            chains: product(&findings.of_all_light()),
        };
        BRANCHES.into_iter().map(with).chain((self.max_edges > 1).then(lamps)).collect()
    }

    /// Shares of chains in a round.
    fn shares(&self, decision: &Decision, findings: &Findings) -> Vec<Share> {
        if decision.chain_work == 0.0 {
            return Vec::new();
        }
        let work = decision.chain_work * f64::from(self.view.camera.pixels());
        let per_sample = mutations_per_sample(self.view, engine::MUTATIONS_PER_SAMPLE);
        match decision.candidate.max_edges < self.max_edges {
            true => share_out(&findings.of_all_light(), work, per_sample),
            false => share_out(&findings.chained.measures, work, per_sample),
        }
    }

    fn cut(&self) -> LightStrata {
        let lights = self.view.scene.lights();
        match self.stratification {
            Stratification::None | Stratification::Auto => LightStrata::new(lights, Stratification::None),
            asked_for => LightStrata::with_least_share(lights, asked_for, LEAST_SHARE),
        }
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

    /// Findings of chains in their share.
    fn chains(
        &self,
        taken: Taken,
        strata: &[LightStratum],
        mutations: u64,
        weights: &[f64],
    ) -> Option<(Chained, PilotCounts)> {
        let share = Share { mutations, samples: mutations.div_ceil(MUTATIONS_PER_SAMPLE) };
        let strata: Vec<_> = strata.iter().map(|&stratum| (stratum, share)).collect();
        let (mixture, pixels) = (Mixture::new(PathMutation::all(taken.view)), taken.view.camera.pixels());
        let Ok(chains) = Metropolis::new(&strata, &mixture, &taken, self.seed) else {
            return Some((Chained { measures: Vec::new(), energy: 0.0 }, PilotCounts::default()));
        };
        let rounds = CHAIN_PILOT..CHAIN_PILOT + ROUNDS;
        let found = chains.counting(rays_traced).partial();
        let found = found.pilot(pixels, rounds, &|_: &[f64]| weights.to_vec(), self.part(3))?;
        let energy = found.images.iter().flatten().map(|(_, value)| value).sum::<f64>() / f64::from(pixels);
        let measures = found.measures.into_iter().map(|m| per_pixel(m, pixels, self.view.camera.pixels())).collect();
        Some((Chained { measures, energy }, PilotCounts::of(&found.tally)))
    }
}
