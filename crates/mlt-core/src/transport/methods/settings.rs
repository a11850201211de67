//! Settings: all that decides the bits of a render.

use super::adapt::Adaptation;
use super::metropolis::mutate::perturbations::Perturbations;
use super::metropolis::variant::Variant;
use crate::transport::image::Target;
use crate::transport::lights::Stratification;
use crate::transport::paths::Classes;
use crate::transport::scene::View;

/// Most edges of a path where no limit is asked for: roulette, which ends at least one in twenty at each step, reaches it
/// with probability below 10⁻²⁰.
pub const MOST_EDGES: usize = 1000;

/// How the image is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// Independent samples where they are better, Metropolis where it pays: see [`auto`](mod@super::auto).
    #[default]
    Auto,
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

/// Settings that decide the bits of a render, besides the scene and the camera. The default is what `mlt render` does by itself.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// How the image is estimated.
    pub method: Method,
    /// How the lights are cut, for Metropolis.
    pub stratification: Stratification,
    /// How paths are cut besides, for Metropolis.
    pub classes: Classes,
    /// How a round is shared among the strata.
    pub adaptation: Adaptation,
    /// The chains or mutations that strata restrict.
    pub variant: Variant,
    /// Perturbations beside the bidirectional mutation in [`Method::Metropolis`].
    pub perturbations: Perturbations,
    /// The importance that chains sample in proportion to.
    pub target: Target,
    /// Most edges of a path; `None`: no limit.
    pub max_edges: Option<usize>,
    /// Key of all random streams.
    pub seed: u64,
    /// Mutations (Metropolis) or samples of each pixel in a round; for independent methods on average over the rounds.
    pub per_pixel: f64,
}

impl Settings {
    /// A method with this many mutations (Metropolis) or samples of each pixel in a round: 4 to 64 in each of 16 rounds make a
    /// usual image. Everything else is as `mlt render` has it by itself.
    pub fn new(method: Method, per_pixel: f64) -> Self {
        Self {
            method,
            stratification: Stratification::default(),
            classes: Classes::default(),
            adaptation: Adaptation::default(),
            variant: Variant::default(),
            perturbations: Perturbations::default(),
            target: Target::default(),
            max_edges: None,
            seed: 0,
            per_pixel,
        }
    }

    /// The same but for a change: `settings.with(|s| s.seed = 7)`.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    /// Most edges of a path.
    pub(super) fn most_edges(&self) -> usize {
        self.max_edges.unwrap_or(MOST_EDGES).clamp(1, MOST_EDGES)
    }

    /// Mutations of a round.
    pub(super) fn mutations_per_round(&self, view: View) -> f64 {
        self.per_pixel * f64::from(view.camera.pixels())
    }
}

impl Default for Settings {
    /// A sixteenth of the 64 samples of each pixel that `mlt render` takes.
    fn default() -> Self {
        Self::new(Method::default(), 4.0)
    }
}
