//! Renders as a plan of [`auto`](mod@crate::transport::methods::auto) says.

use super::{Renderer, Run, independent, repeat};
use crate::engine::{Importance, Mixture, Mutation, Outcome, Sum, SumTally, Tally};
use crate::transport::methods::auto::{Plan, Sampler, SomePaths};
use crate::transport::methods::metropolis::{LightStratum, PathMutation};
use crate::transport::methods::{AllPaths, Bidirectional, ImageSampler, Independent, PathTracer, SampleTally};
use crate::transport::paths::LightPath;

impl<I: Importance<LightPath> + Sync> Renderer<'_, I> {
    /// Renders as a plan says.
    pub(super) fn follow(&self, plan: &Plan, run: Run) -> Outcome {
        let (view, region) = (self.view, &self.whole);
        let edges = |images| plan.sampled_edges(images, self.max_edges());
        let (max_edges, max_image_edges) = (edges(false), edges(view.scene.has_specular()));
        match &plan.independent {
            None => self.chains(plan, run),
            &Some((Sampler::Path { branches }, samples)) => self.mixture(
                plan,
                &PathTracer { view, next_event: self.whole.next_event(), max_edges, max_image_edges, branches },
                samples,
                run,
            ),
            &Some((Sampler::Bidirectional, samples)) => {
                self.mixture(plan, &Bidirectional { view, region, max_edges: max_image_edges }, samples, run)
            }
        }
    }

    /// Chains alone.
    fn chains(&self, plan: &Plan, run: Run) -> Outcome {
        let strata = LightStratum::of_kinds(&plan.strata, &plan.chained, self.view, self.max_edges());
        let mixture = Mixture::new(PathMutation::all(self.view));
        self.metropolis(&self.estimator(&strata, &plan.shares, &mixture), run)
    }

    /// Independent samples of what is not left to chains, and chains for the rest.
    fn mixture<T: ImageSampler>(&self, plan: &Plan, sampler: &T, samples_per_pixel: f64, run: Run) -> Outcome {
        let seed = self.settings.seed;
        if plan.shares.is_empty() {
            return independent(&Independent { sampler, selection: AllPaths, samples_per_pixel, seed }, run);
        }
        let strata = LightStratum::of_kinds(&plan.strata, &plan.chained, self.view, self.max_edges());
        let mixture = Mixture::new(PathMutation::all(self.view));
        let kinds = plan.sampled();
        let selection = SomePaths { lights: self.view.scene.lights(), strata: &plan.strata, kinds: &kinds };
        let samples = Independent { sampler, selection, samples_per_pixel, seed };
        let estimator = Sum(samples, self.estimator(&strata, &plan.shares, &mixture));
        let counts = run.counts;
        let tally = Tally { strata: std::mem::take(&mut counts.strata) };
        let chain_rays = tally.work();
        let mut tally = SumTally(SampleTally { samples: counts.samples, rays: counts.rays - chain_rays }, tally);
        let outcome = repeat(&estimator, run.rounds, run.film, &mut tally, run.observe);
        let SumTally(samples, tally) = tally;
        counts.mutations = mixture.mutations().iter().map(Mutation::<LightPath, LightStratum>::name).collect();
        (counts.samples, counts.rays) = (samples.samples, samples.rays + tally.work());
        counts.strata = tally.strata;
        outcome
    }
}
