//! A whole render: a method, its settings, and what it counted.

use super::bdpt::{Bidirectional, MOST_EDGES};
use super::independent::{ImageSampler, Independent, SampleTally};
use super::mutate::PathMutation;
use super::path::{LightPath, Luminance, View};
use super::primary::{AllConnections, Multiplexed, Part, Techniques};
use super::pt::PathTracer;
use super::region::LightRegion;
use super::scene::rays_traced;
use super::strata::{LightStrata, Stratification};
use super::stratum::LightStratum;
use crate::engine::{
    self, Estimator, Film, Importance, Metropolis, Mixture, Mutation, Outcome, Path, Progress, Share, Splat, Stratum,
    StratumStats, Tally,
};
use crate::primary::{PrimaryImportance, PrimaryMutation};
use std::ops::{ControlFlow, Range};

/// How the image is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Stratified Metropolis light transport in path space.
    Metropolis,
    /// Bidirectional path tracing.
    Bidirectional,
    /// Path tracing with next-event estimation.
    Path,
    /// Stratified Metropolis over the random numbers of bidirectional samples.
    PrimaryBidirectional,
    /// Stratified Metropolis over the random numbers of single paths, with their length and technique.
    Multiplexed,
}

/// What decides the bits of a render, besides the scene and the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How the image is estimated.
    pub method: Method,
    /// How the lights are cut, for Metropolis.
    pub stratification: Stratification,
    /// Most edges of a path; `None`: no limit.
    pub max_edges: Option<usize>,
    /// Key of all random streams.
    pub seed: u64,
    /// Mutations (Metropolis) or samples of each pixel in a round; for independent methods on average over the rounds.
    pub per_pixel: f64,
}

/// What a render counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Independent samples of the image.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
    /// Metropolis: one entry a stratum.
    pub strata: Vec<StratumStats>,
    /// Names of the mutations, in the order of every stratum's list.
    pub mutations: Vec<&'static str>,
}

impl Counts {
    /// Steps of all chains.
    pub fn steps(&self) -> u64 {
        self.strata.iter().map(StratumStats::steps).sum()
    }
}

/// Called with the state of a render; it breaks to stop it.
pub type Observer<'a> = dyn FnMut(Progress, &Film<3>) -> ControlFlow<()> + 'a;

/// Everything a render needs, set up once.
pub struct Renderer<'a, I = Luminance> {
    view: View<'a>,
    settings: Settings,
    importance: I,
    strata: LightStrata,
    whole: LightRegion,
}

/// Mutations for one independent sample, of those for b̂_j and the chains' starts: where such a sample is a whole
/// bidirectional one and a mutation is a path.
const PATH_MUTATIONS_A_SAMPLE: u64 = 32;
/// The same where both are a bidirectional sample.
const BIDIRECTIONAL_MUTATIONS_A_SAMPLE: u64 = 8;
/// The same where both are a path. Most random paths are dark, so b̂_j takes many.
const MULTIPLEXED_MUTATIONS_A_SAMPLE: u64 = 4;
/// Probability of a large step in primary sample space.
const LARGE_STEPS: f64 = 0.3;
/// Fewest of them in a stratum and round.
const LEAST_SAMPLES: u64 = 64;

impl<'a> Renderer<'a> {
    /// A render with luminance as importance.
    pub fn new(view: View<'a>, settings: Settings) -> Self {
        Self::with_importance(view, settings, Luminance)
    }
}

impl<'a, I: Importance<LightPath> + Sync> Renderer<'a, I> {
    /// A render with an importance of the caller's.
    pub fn with_importance(view: View<'a>, settings: Settings, importance: I) -> Self {
        let strata = LightStrata::new(view.scene.lights(), settings.stratification);
        let whole = LightRegion::whole(view.scene.lights());
        Self { view, settings, importance, strata, whole }
    }

    /// A black film for this image.
    pub fn film(&self) -> Film<3> {
        Film::new(self.view.camera.pixels(), self.view.scene.typical_radiance())
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
        let run = Run { rounds, film, counts, observe };
        match self.settings.method {
            Method::Metropolis => {
                let strata = LightStratum::all(&self.strata, view, max_edges);
                self.metropolis(&strata, PathMutation::all(view), &self.importance, PATH_MUTATIONS_A_SAMPLE, run)
            }
            Method::PrimaryBidirectional => {
                let strata = self.part().all(|part| AllConnections { part });
                let mutations = PrimaryMutation::both(LARGE_STEPS);
                self.metropolis(&strata, mutations, &PrimaryImportance, BIDIRECTIONAL_MUTATIONS_A_SAMPLE, run)
            }
            Method::Multiplexed => {
                let techniques = Techniques::new(max_edges);
                let strata = self.part().all(|part| Multiplexed { part, techniques: &techniques });
                let mutations = PrimaryMutation::both(LARGE_STEPS);
                self.metropolis(&strata, mutations, &PrimaryImportance, MULTIPLEXED_MUTATIONS_A_SAMPLE, run)
            }
            Method::Bidirectional => self.independent(&Bidirectional { view, region: &self.whole, max_edges }, run),
            Method::Path => self.independent(&PathTracer { view, region: &self.whole, max_edges }, run),
        }
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

    fn metropolis<P, S, M, J>(
        &self,
        strata: &[S],
        mutations: Vec<M>,
        importance: &J,
        mutations_a_sample: u64,
        run: Run,
    ) -> Outcome
    where
        P: Path<Splat = Splat<3>> + Send,
        S: Stratum<P> + Sync,
        M: Mutation<P, S> + Sync,
        J: Importance<P> + Sync,
    {
        let shares = self.shares(strata.iter().map(Stratum::power).collect(), mutations_a_sample);
        let mixture = Mixture::new(mutations);
        let (seed, work) = (self.settings.seed, rays_traced);
        let estimator = Metropolis { strata, shares: &shares, mixture: &mixture, importance, seed, work };
        let counts = run.counts;
        let mut tally = Tally { strata: std::mem::take(&mut counts.strata), work: counts.rays };
        let outcome = repeat(&estimator, run.rounds, run.film, &mut tally, run.observe);
        counts.mutations = mixture.mutations().iter().map(Mutation::<P, S>::name).collect();
        (counts.strata, counts.rays) = (tally.strata, tally.work);
        outcome
    }

    /// n_j in proportion to power.
    fn shares(&self, powers: Vec<f64>, mutations_a_sample: u64) -> Vec<Share> {
        let round = self.settings.per_pixel * f64::from(self.view.camera.pixels());
        let total: f64 = powers.iter().sum();
        let share = |power: f64| {
            let mutations = ((round * power / total).round() as u64).max(1);
            Share { mutations, samples: (mutations / mutations_a_sample).max(LEAST_SAMPLES) }
        };
        powers.into_iter().map(share).collect()
    }

    fn independent<T: ImageSampler>(&self, sampler: &T, run: Run) -> Outcome {
        let Settings { per_pixel: samples_per_pixel, seed, .. } = self.settings;
        let estimator = Independent { sampler, samples_per_pixel, seed };
        let counts = run.counts;
        let mut tally = SampleTally { samples: counts.samples, rays: counts.rays };
        let outcome = repeat(&estimator, run.rounds, run.film, &mut tally, run.observe);
        (counts.samples, counts.rays) = (tally.samples, tally.rays);
        outcome
    }
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

/// Luminance of a pixel's mean, and a bound on its standard error: Σ weight × error of the channels, which is exact where
/// their errors are fully correlated.
pub fn luminance_and_error(film: &Film<3>, pixel: usize) -> (f64, f64) {
    let weights = [0.2126, 0.7152, 0.0722];
    let channels = film.pixel(pixel);
    let sum = |f: fn(&engine::Pixel) -> f64| channels.iter().zip(weights).map(|(c, w)| w * f(c)).sum();
    (sum(|c| c.mean), sum(|c| c.stderr))
}

/// Estimated relative error of the image, √(Σ stderr² / Σ luminance²) over pixels; infinite before the second round and
/// for a black image.
pub fn relative_error(film: &Film<3>) -> f64 {
    let (mut errors, mut squares) = (0.0, 0.0);
    for (luminance, error) in (0..film.sites() as usize).map(|i| luminance_and_error(film, i)) {
        errors += error * error;
        squares += luminance * luminance;
    }
    if squares > 0.0 { (errors / squares).sqrt() } else { f64::INFINITY }
}
