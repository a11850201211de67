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
use super::metropolis::{LightStratum, PathMutation, guided};
use super::path_tracing::PathTracer;
use super::samples::mutations_per_sample;
use crate::engine::{self, LEAST_CHAIN, Measure, Metropolis, Mixture, Share, Watch};
use crate::transport::image::error_weights;
use crate::transport::lights::{LightStrata, Stratification};
use crate::transport::scene::{View, rays_traced};
use chains::{Budget, most_walks, per_pixel, product, share_out};
use constants::{
    BRANCHES, CHAIN_PILOT, LEAST_SHARE, MOSTLY_HARD, MUTATIONS, PILOT_MUTATIONS_PER_SAMPLE, PILOT_WALKS, PIXELS,
    REDUCTION, ROUNDS, ROUNDS_OF_TIME, STEPS, TIME_OF_CHAINS, USUAL_PIXELS,
};
use decide::{Candidate, Decision, better, decide};
use levels::Levels;
use measure::{CLASSES, Measured, work_of};
use split::{IN_VIEW, Split, Taken};
use tail::{Tail, Told};

pub use constants::TIME_OF_A_CHAINS_RAY;
pub use plan::{Plan, Summary};
pub use render::Auto;
use render::Common;

/// The task that a pilot finds a plan for.
struct Pilot<'a> {
    view: View<'a>,
    common: &'a Common,
    /// How the lights are cut for chains.
    stratification: Stratification,
    max_edges: usize,
    seed: u64,
    /// Work of a round: as much as so many samples of path tracing a pixel.
    per_pixel: f64,
    watch: Watch<'a>,
}

/// The errors that chains leave, and the image that they find.
#[derive(Default)]
struct Chained {
    /// By strata, per pixel of the render.
    measures: Vec<Measure>,
    /// Each pixel's value by them, summed over channels.
    image: Vec<f64>,
    spent: PilotCounts,
}

/// Findings of a pilot.
struct Findings {
    /// Errors of path tracing by classes, for one sample a pixel.
    errors: [f64; CLASSES],
    /// Work of a sample.
    work: f64,
    /// By strata, per pixel of the render.
    measures: Vec<Measure>,
    told: Told,
    /// Share of the light, lamps in view left out, that is left to chains.
    hard: f64,
}

impl Pilot<'_> {
    /// Measures and decides. Nothing if it is stopped.
    fn run(&self) -> Option<(Plan, PilotCounts)> {
        let (strata, camera) = (self.cut(), self.view.camera.with_size(self.size()));
        let view = View { camera: &camera, ..self.view };
        let of_light = Bidirectional { view, region: &self.common.lights, max_edges: self.max_edges };
        let levels = Levels::measure(&of_light, IN_VIEW.others(), self.seed, self.part(0))?;
        let split = Split::new(&levels, camera.size(), self.max_edges);
        let (findings, spent) = self.findings(view, &strata, &split)?;

        let [alone, mixed] = decide(&self.candidates(view, &findings), self.per_pixel);
        let chosen = if findings.hard > 0.0 { better([alone, mixed], self.met(&findings.told)) } else { alone };
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
    fn findings(&self, view: View, strata: &LightStrata, split: &Split) -> Option<(Findings, PilotCounts)> {
        let samples = (self.per_pixel.max(1.0) as u64).next_power_of_two();
        let measured = Measured::new(&self.tracer(view, 1), split, samples, self.seed, self.part(1))?;
        let pixels = f64::from(view.camera.pixels());
        let sampled = PilotCounts { mutations: 0, rays: (pixels * measured.work * measured.samples) as u64 };

        let strata = LightStratum::of_kinds(strata, IN_VIEW.others(), view, self.max_edges);
        let strata = &guided(strata, &self.common.guide);
        let mutations = ((MUTATIONS * pixels / strata.len().max(1) as f64) as u64).max(LEAST_CHAIN);
        let taken = Taken { importance: &self.common.importance, view, lights: &self.common.lights, split };
        let weigh = |chained: &[f64]| {
            let both: Vec<_> = measured.image.iter().zip(chained).map(|(a, b)| a + b).collect();
            error_weights(&both, view.camera.size())
        };
        let Chained { measures, image, spent } = self.chains(taken, strata, mutations, &weigh)?;
        let weights = &weigh(&image);
        let tail = Tail { taken, weights, seed: self.seed };
        let (told, sought) = tail.measure(strata, ROUNDS * mutations, self.part(3))?;
        let (hard, easy) = (image.iter().sum::<f64>() / pixels, measured.energies[1] + measured.energies[2]);
        let (errors, work) = (measured.errors(weights), measured.work);
        let hard = if hard > 0.0 { hard / (hard + easy) } else { 0.0 };
        Some((Findings { errors, work, measures, told, hard }, sampled + spent + sought))
    }

    /// How often samples of a round meet what makes most of T, N T²/Q.
    fn met(&self, told: &Told) -> f64 {
        let samples = self.per_pixel.max(1.0) * f64::from(self.view.camera.pixels());
        samples * told.tail * told.tail / told.squares.max(f64::MIN_POSITIVE)
    }

    /// For the step of this number.
    fn part(&self, step: usize) -> Watch<'_> {
        self.watch.part(STEPS[step], STEPS[step + 1])
    }

    fn tracer<'s>(&'s self, view: View<'s>, branches: u32) -> PathTracer<'s> {
        let (light_sampler, max_edges) = (self.common.lights.light_sampler(), self.max_edges);
        PathTracer { view, light_sampler, max_edges, max_image_edges: max_edges, branches }
    }

    /// Path tracing with each number of branches; and of lamps in view alone, where chains may take all else.
    fn candidates(&self, view: View, findings: &Findings) -> Vec<Candidate> {
        let &Findings { errors: [in_view, direct, long], work, ref measures, ref told, hard } = findings;
        let branch = (work_of(&self.tracer(view, 2), self.seed) - work).max(0.0);
        let of_round = 0.5 * self.per_pixel.max(1.0) * work * f64::from(self.view.camera.pixels());
        let chains = product(measures, &told.starts, self.budget(of_round));
        let with = |branches: u32| Candidate {
            branches,
            max_edges: self.max_edges,
            work: work + f64::from(branches - 1) * branch,
            errors: [in_view + direct, long / f64::from(branches)],
            tail: told.tail,
            chains,
        };
        let tracer = PathTracer { max_edges: 1, max_image_edges: 1, ..self.tracer(view, 1) };
        let lamps = || Candidate {
            branches: 1,
            max_edges: 1,
            work: work_of(&tracer, self.seed),
            errors: [in_view, 0.0],
            tail: f64::INFINITY,
            chains,
        };
        let lamps_pay = self.max_edges > 1 && hard > MOSTLY_HARD;
        BRANCHES.into_iter().map(with).chain(lamps_pay.then(lamps)).collect()
    }

    /// Shares of chains in a round.
    fn shares(&self, decision: &Decision, findings: &Findings) -> Vec<Share> {
        if decision.chain_work == 0.0 {
            return Vec::new();
        }
        let work = decision.chain_work * f64::from(self.view.camera.pixels());
        share_out(&findings.measures, self.budget(work))
    }

    fn budget(&self, work: f64) -> Budget {
        let mutations_per_sample = mutations_per_sample(self.view, engine::MUTATIONS_PER_SAMPLE);
        Budget { work, mutations_per_sample, most_walks: most_walks(&self.view) }
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

    /// Chains in their share, with errors weighed by the image that they find.
    fn chains(
        &self,
        taken: Taken,
        strata: &[LightStratum],
        mutations: u64,
        weigh: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> Option<Chained> {
        let share = Share { mutations, samples: mutations.div_ceil(PILOT_MUTATIONS_PER_SAMPLE) };
        let walks = share.samples.max(PILOT_WALKS * u64::from(taken.view.camera.pixels()));
        let share_of =
            |stratum: &LightStratum| if stratum.is_met() { Share { samples: walks, ..share } } else { share };
        let strata: Vec<_> = strata.iter().map(|stratum| (*stratum, share_of(stratum))).collect();
        let (mixture, pixels) = (Mixture::new(PathMutation::all(taken.view)), taken.view.camera.pixels());
        let mut image = vec![0.0; pixels as usize];
        let Ok(chains) = Metropolis::new(&strata, &mixture, &taken, self.seed) else {
            return Some(Chained { image, ..Chained::default() });
        };
        let rounds = CHAIN_PILOT..CHAIN_PILOT + ROUNDS;
        let found = chains.counting(rays_traced).partial().pilot(pixels, rounds, weigh, self.part(2))?;
        found.images.iter().flatten().for_each(|&(site, value)| image[site as usize] += value);
        let measures = found.measures.into_iter().map(|m| per_pixel(m, pixels, self.view.camera.pixels())).collect();
        Some(Chained { measures, image, spent: PilotCounts::of(&found.tally) })
    }
}
