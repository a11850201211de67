//! A whole render: a method, its settings, and what it counted.

mod film_unit;
mod planned;

use crate::engine::{
    self, Estimator, Film, Importance, MUTATIONS_A_SAMPLE, Metropolis, Mixture, Mutation, Outcome, Path, Progress,
    Share, Splat, Stratum, Tally, shares_by_power,
};
use crate::primary::{PrimaryImportance, PrimaryMutation, PrimaryStratum};
use crate::transport::image::{PixelImportance, Target, error_weights, luminance_and_error};
use crate::transport::lights::{LightRegion, LightStrata, Stratification};
use crate::transport::methods::auto::{Plan, Summary};
use crate::transport::methods::counts::PilotCounts;
use crate::transport::methods::metropolis::adapt::{Adapted, Pilot};
use crate::transport::methods::metropolis::{Adaptation, LightStratum, PathMutation, Variant, Weights};
use crate::transport::methods::primary::{AllConnections, Multiplexed, Part, Techniques};
use crate::transport::methods::samples::{Samples, fitted_shares, mutations_a_sample, with_met};
use crate::transport::methods::{
    AllPaths, Bidirectional, ImageSampler, Independent, MOST_EDGES, PathTracer, SampleTally, auto,
};
use crate::transport::paths::LightPath;
use crate::transport::scene::{View, rays_traced};
use std::ops::{ControlFlow, Range};

pub use crate::transport::methods::{Counts, Method, Settings};
pub use film_unit::film_unit;

/// Called with the state of a render; it breaks to stop it.
pub type Observer<'a> = dyn FnMut(Progress, &Film<3>) -> ControlFlow<()> + 'a;

/// Everything a render needs, set up once.
pub struct Renderer<'a, I = PixelImportance> {
    view: View<'a>,
    settings: Settings,
    importance: I,
    strata: LightStrata,
    shares: Vec<Share>,
    whole: LightRegion,
    pilot: PilotCounts,
    plan: Option<Plan>,
}

/// Probability of a large step over the numbers of bidirectional samples.
const BIDIRECTIONAL_LARGE_STEPS: f64 = 0.3;
/// Samples a pixel of the image that a relative importance is made from.
const SAMPLES_OF_LEVEL: f64 = 4.0;

impl<'a> Renderer<'a> {
    /// A render with an importance that its settings choose. The pilot, if they ask for one, runs here.
    pub fn new(view: View<'a>, settings: Settings) -> Self {
        let importance = match settings.target {
            Target::Luminance => PixelImportance::default(),
            Target::Relative => {
                let method = Method::Bidirectional;
                let max_edges = settings.max_edges;
                let quick = Settings {
                    method,
                    max_edges,
                    seed: settings.seed,
                    per_pixel: SAMPLES_OF_LEVEL,
                    ..Settings::default()
                };
                let renderer = Self::new(view, quick);
                let (mut film, first) = (renderer.film(), engine::PILOT);
                renderer
                    .render(first..first + 1, &mut film, &mut Counts::default(), &mut |_, _| ControlFlow::Continue(()));
                let image: Vec<_> = (0..film.sites() as usize).map(|i| luminance_and_error(&film, i).0).collect();
                PixelImportance::relative(&image, view.camera.size())
            }
        };
        Self::with_importance(view, settings, importance)
    }
}

impl<'a, I: Importance<LightPath> + Sync> Renderer<'a, I> {
    /// A render with an importance of the caller's.
    pub fn with_importance(view: View<'a>, settings: Settings, importance: I) -> Self {
        let lights = view.scene.lights();
        let strata = LightStrata::new(lights, Stratification::None);
        let whole = strata.regions()[0].clone();
        let (shares, pilot) = (Vec::new(), PilotCounts::default());
        let mut renderer = Self { view, settings, importance, strata, shares, whole, pilot, plan: None };
        match renderer.settings.method {
            Method::Auto => renderer.plan(),
            Method::Metropolis => renderer.adapt(),
            Method::PrimaryBidirectional | Method::Multiplexed => {
                renderer.strata = LightStrata::new(lights, renderer.settings.stratification);
                (renderer.shares, renderer.pilot.rays) = renderer.primary_shares();
            }
            Method::Bidirectional | Method::Path => {}
        }
        renderer
    }

    /// A render with [`Method::Auto`] that follows a plan of the caller's.
    pub fn with_plan(view: View<'a>, settings: Settings, importance: I, plan: Plan) -> Self {
        let alone = Settings { method: Method::Path, ..settings.clone() };
        Self {
            settings: Settings { method: Method::Auto, ..settings },
            plan: Some(plan),
            ..Self::with_importance(view, alone, importance)
        }
    }

    /// Finds out which part of path space is sampled how.
    fn plan(&mut self) {
        let Settings { stratification, seed, per_pixel, .. } = self.settings;
        let (view, max_edges, importance) = (self.view, self.max_edges(), &self.importance);
        let (plan, pilot) =
            auto::Pilot { view, importance, lights: &self.whole, stratification, max_edges, seed, per_pixel }.run();
        (self.plan, self.pilot) = (Some(plan), pilot);
    }

    /// What [`Method::Auto`] decided.
    pub fn decision(&self) -> Option<&Summary> {
        self.plan.as_ref().map(|plan| &plan.summary)
    }

    /// Chooses the strata and their shares.
    fn adapt(&mut self) {
        let mutations = self.mutations_a_round();
        let (view, max_edges) = (self.view, self.max_edges());
        let Settings { classes, stratification, .. } = self.settings;
        let weights = match self.settings.variant {
            Variant::Stratified => self.settings.adaptation.weights,
            // All paths are one stratum.
            Variant::MutationOnly => Weights::Power,
        };
        let pilot = Pilot {
            lights: self.view.scene.lights(),
            adaptation: Adaptation { weights, ..self.settings.adaptation },
            mutations,
            classes: classes.count(max_edges, view.scene.has_specular() && stratification == Stratification::None),
            mutations_a_sample: mutations_a_sample(view, MUTATIONS_A_SAMPLE),
            by_power: &|strata, mutations| {
                let strata = LightStratum::product(strata, view, max_edges, classes);
                shares_by_power(&strata, mutations, mutations_a_sample(view, MUTATIONS_A_SAMPLE))
            },
            measure: &|strata, shares, rounds| {
                let strata = LightStratum::product(strata, view, max_edges, classes);
                let shares = with_met(&strata, shares.to_vec());
                let size = self.view.camera.size();
                let mixture = self.mutations();
                let estimator = self.estimator(&strata, &shares, &mixture);
                let found = estimator.pilot(self.view.camera.pixels(), rounds, &|image| error_weights(image, size));
                (found.measures, found.tally)
            },
        };
        let Adapted { strata, shares, tally } = pilot.run(stratification);
        (self.strata, self.pilot) = (strata, PilotCounts::of(&tally));
        let strata = self.path_strata(&self.strata);
        let (shares, rays) = shares.map(|shares| (shares, 0)).unwrap_or_else(|| {
            let spread = |shares: &[Share]| self.estimator(&strata, shares, &self.mutations()).spread();
            fitted_shares(view, Samples::OF_PATHS, &strata, mutations, spread)
        });
        self.shares = with_met(&strata, shares);
        self.pilot.rays += rays;
    }

    /// The strata of paths over parts of the lights.
    fn path_strata<'s>(&'s self, strata: &'s LightStrata) -> Vec<LightStratum<'s>> {
        let (view, max_edges) = (self.view, self.max_edges());
        match self.settings.variant {
            Variant::Stratified => LightStratum::product(strata, view, max_edges, self.settings.classes),
            Variant::MutationOnly => vec![LightStratum::mutation_only(strata, &self.whole, view, max_edges)],
        }
    }

    fn mutations<'s>(&self) -> Mixture<LightPath, LightStratum<'s>, PathMutation<'a>> {
        Mixture::new(PathMutation::with(self.settings.perturbations, self.view))
    }

    fn estimator<'s>(
        &'s self,
        strata: &'s [LightStratum<'s>],
        shares: &'s [Share],
        mixture: &'s Mixture<LightPath, LightStratum<'s>, PathMutation<'s>>,
    ) -> Metropolis<'s, LightPath, LightStratum<'s>, PathMutation<'s>, I> {
        let (seed, importance) = (self.settings.seed, &self.importance);
        Metropolis { strata, shares, mixture, importance, seed, work: rays_traced }
    }

    /// A black film for this image.
    pub fn film(&self) -> Film<3> {
        Film::new(self.view.camera.pixels(), film_unit(self.view))
    }

    /// Adds rounds to `film` and to `counts`, on the current rayon pool.
    pub fn render(
        &self,
        rounds: Range<u64>,
        film: &mut Film<3>,
        counts: &mut Counts,
        observe: &mut Observer,
    ) -> Outcome {
        let (view, max_edges) = (self.view, self.max_edges());
        (counts.pilot_mutations, counts.pilot_rays) = (self.pilot.mutations, self.pilot.rays);
        let run = Run { rounds, film, counts, observe };
        match self.settings.method {
            Method::Auto => self.plan.as_ref().map_or(Outcome::Complete, |plan| self.follow(plan, run)),
            Method::Metropolis => {
                let strata = self.path_strata(&self.strata);
                let mixture = self.mutations();
                self.metropolis(&self.estimator(&strata, &self.shares, &mixture), run)
            }
            Method::PrimaryBidirectional => self.primary(&self.all_connections(), BIDIRECTIONAL_LARGE_STEPS, run),
            Method::Multiplexed => {
                let large_steps = multiplexed_large_steps(view.camera.pixels());
                self.primary(&self.multiplexed(&Techniques::new(max_edges)), large_steps, run)
            }
            Method::Bidirectional => self.evenly(&Bidirectional { view, region: &self.whole, max_edges }, run),
            Method::Path => {
                let (next_event, max_image_edges) = (self.whole.next_event(), max_edges);
                self.evenly(&PathTracer { view, next_event, max_edges, max_image_edges, branches: 1 }, run)
            }
        }
    }

    fn mutations_a_round(&self) -> f64 {
        self.settings.per_pixel * f64::from(self.view.camera.pixels())
    }

    fn max_edges(&self) -> usize {
        self.settings.max_edges.unwrap_or(MOST_EDGES).clamp(1, MOST_EDGES)
    }

    /// What tracers in primary sample space share.
    fn part(&self) -> Part<'_, I> {
        Part {
            view: self.view,
            strata: &self.strata,
            index: 0,
            max_edges: self.max_edges(),
            importance: &self.importance,
        }
    }

    fn multiplexed<'s>(&'s self, techniques: &'s Techniques) -> Vec<PrimaryStratum<Multiplexed<'s, I>>> {
        self.part().all(|part| Multiplexed { part, techniques })
    }

    fn all_connections(&self) -> Vec<PrimaryStratum<AllConnections<'_, I>>> {
        self.part().all(|part| AllConnections { part })
    }

    /// Shares of a method in primary sample space, and the rays that finding them took.
    fn primary_shares(&self) -> (Vec<Share>, u64) {
        match self.settings.method {
            Method::Multiplexed => {
                let techniques = Techniques::new(self.max_edges());
                self.primary_shares_of(&self.multiplexed(&techniques), Samples::MULTIPLEXED)
            }
            _ => self.primary_shares_of(&self.all_connections(), Samples::BIDIRECTIONAL),
        }
    }

    fn primary_shares_of<P, S>(&self, strata: &[S], samples: Samples) -> (Vec<Share>, u64)
    where
        P: Path,
        S: Stratum<P> + Sync,
        PrimaryMutation: Mutation<P, S> + Sync,
        PrimaryImportance: Importance<P>,
    {
        let mixture = Mixture::new(Vec::new());
        let spread = |shares: &[Share]| self.primary_estimator(strata, shares, &mixture).spread();
        fitted_shares(self.view, samples, strata, self.mutations_a_round(), spread)
    }

    fn primary_estimator<'s, P, S>(
        &self,
        strata: &'s [S],
        shares: &'s [Share],
        mixture: &'s Mixture<P, S, PrimaryMutation>,
    ) -> Metropolis<'s, P, S, PrimaryMutation, PrimaryImportance> {
        Metropolis {
            strata,
            shares,
            mixture,
            importance: &PrimaryImportance,
            seed: self.settings.seed,
            work: rays_traced,
        }
    }

    /// Metropolis in primary sample space.
    fn primary<P, S>(&self, strata: &[S], large_steps: f64, run: Run) -> Outcome
    where
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        PrimaryMutation: Mutation<P, S> + Sync,
        PrimaryImportance: Importance<P>,
    {
        let mixture = Mixture::new(PrimaryMutation::both(large_steps));
        self.metropolis(&self.primary_estimator(strata, &self.shares, &mixture), run)
    }

    fn metropolis<P, S, M, J>(&self, estimator: &Metropolis<P, S, M, J>, run: Run) -> Outcome
    where
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        J: Importance<P> + Sync,
    {
        let counts = run.counts;
        let mut tally = Tally { strata: std::mem::take(&mut counts.strata) };
        let outcome = repeat(estimator, run.rounds, run.film, &mut tally, run.observe);
        counts.mutations = estimator.mixture.mutations().iter().map(Mutation::<P, S>::name).collect();
        counts.rays = tally.work();
        counts.strata = tally.strata;
        outcome
    }

    fn evenly<T: ImageSampler>(&self, sampler: &T, run: Run) -> Outcome {
        let Settings { per_pixel, seed, .. } = self.settings;
        independent(&Independent { sampler, selection: AllPaths, samples_per_pixel: per_pixel, seed }, run)
    }
}

/// Probability of a large step over the numbers of single paths, on an image of so many pixels: a fresh path is seldom worth
/// as much as a sample of all techniques, but small steps are up to a 64th of the image, which on a small one is within the
/// pixel.
fn multiplexed_large_steps(pixels: u32) -> f64 {
    (25.0 / f64::from(pixels).sqrt()).clamp(0.1, 0.3)
}

fn independent<T: ImageSampler>(estimator: &Independent<T>, run: Run) -> Outcome {
    let counts = run.counts;
    let mut tally = SampleTally { samples: counts.samples, rays: counts.rays };
    let outcome = repeat(estimator, run.rounds, run.film, &mut tally, run.observe);
    (counts.samples, counts.rays) = (tally.samples, tally.rays);
    outcome
}

/// What one call adds, and where to.
struct Run<'r, 'o> {
    rounds: Range<u64>,
    film: &'r mut Film<3>,
    counts: &'r mut Counts,
    observe: &'r mut Observer<'o>,
}

fn repeat<E: Estimator<3>>(
    estimator: &E,
    rounds: Range<u64>,
    film: &mut Film<3>,
    tally: &mut E::Tally,
    observe: &mut Observer,
) -> Outcome {
    engine::render(estimator, rounds, film, tally, &mut |progress, film, _| observe(progress, film))
}
