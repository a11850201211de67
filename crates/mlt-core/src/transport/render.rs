//! A whole render: a method, its settings, and what it counted.

use super::bdpt::{Bidirectional, MOST_EDGES};
use super::independent::{ImageSampler, Independent, SampleTally};
use super::mutate::PathMutation;
use super::path::{LightPath, Luminance, View};
use super::pt::PathTracer;
use super::region::LightRegion;
use super::scene::rays_traced;
use super::strata::{LightStrata, Stratification};
use super::stratum::LightStratum;
use crate::engine::{
    self, Estimator, Film, Importance, Metropolis, Mixture, Mutation, Outcome, Progress, Share, Stratum, StratumStats,
    Tally,
};
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

/// Independent samples for b̂_j and the chains' starts: one for so many mutations.
const MUTATIONS_A_SAMPLE: u64 = 32;
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
        match self.settings.method {
            Method::Metropolis => self.metropolis(rounds, film, counts, observe),
            Method::Bidirectional => {
                self.independent(&Bidirectional { view, region: &self.whole, max_edges }, rounds, film, counts, observe)
            }
            Method::Path => {
                self.independent(&PathTracer { view, region: &self.whole, max_edges }, rounds, film, counts, observe)
            }
        }
    }

    fn max_edges(&self) -> usize {
        self.settings.max_edges.unwrap_or(MOST_EDGES).clamp(1, MOST_EDGES)
    }

    fn metropolis(
        &self,
        rounds: Range<u64>,
        film: &mut Film<3>,
        counts: &mut Counts,
        observe: &mut Observer,
    ) -> Outcome {
        let strata = LightStratum::all(&self.strata, self.view, self.max_edges());
        let shares = self.shares(&strata);
        let mixture = Mixture::new(PathMutation::all(self.view));
        let estimator = Metropolis {
            strata: &strata,
            shares: &shares,
            mixture: &mixture,
            importance: &self.importance,
            seed: self.settings.seed,
            work: rays_traced,
        };
        let mut tally = Tally { strata: std::mem::take(&mut counts.strata), work: counts.rays };
        let outcome = run(&estimator, rounds, film, &mut tally, observe);
        counts.mutations = mixture.mutations().iter().map(Mutation::<LightPath, LightStratum>::name).collect();
        (counts.strata, counts.rays) = (tally.strata, tally.work);
        outcome
    }

    /// n_j in proportion to power.
    fn shares(&self, strata: &[LightStratum]) -> Vec<Share> {
        let round = self.settings.per_pixel * f64::from(self.view.camera.pixels());
        let power: f64 = strata.iter().map(Stratum::power).sum();
        let share = |stratum: &LightStratum| {
            let mutations = ((round * stratum.power() / power).round() as u64).max(1);
            Share { mutations, samples: (mutations / MUTATIONS_A_SAMPLE).max(LEAST_SAMPLES) }
        };
        strata.iter().map(share).collect()
    }

    fn independent<T: ImageSampler>(
        &self,
        sampler: &T,
        rounds: Range<u64>,
        film: &mut Film<3>,
        counts: &mut Counts,
        observe: &mut Observer,
    ) -> Outcome {
        let Settings { per_pixel: samples_per_pixel, seed, .. } = self.settings;
        let estimator = Independent { sampler, samples_per_pixel, seed };
        let mut tally = SampleTally { samples: counts.samples, rays: counts.rays };
        let outcome = run(&estimator, rounds, film, &mut tally, observe);
        (counts.samples, counts.rays) = (tally.samples, tally.rays);
        outcome
    }
}

fn run<E: Estimator<3>>(
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
