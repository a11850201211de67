//! The bidirectional path tracer in primary sample space.
//!
//! Both tracers draw x_0 on their stratum's region, so no vertex drawn on a light leaves the stratum; a path that meets a
//! light by chance (s = 0) counts only if it meets it in the stratum. Over the paths of Ω_j the MIS weights refer to the
//! region's density and sum to 1, so that ∫ F(u) du = ∫_{Ω_j} f. Paths that are met by chance and in no other way belong to all
//! strata, a share q_j = Φ_j/Φ of them to each: there is no light end to draw, so a cut would only throw meetings away.

mod method;
mod mmlt;
mod pssmlt;

use super::samples::Samples;
use crate::engine::Splat;
use crate::primary::{Output, Tracer};
use crate::transport::image::PixelImportance;
use crate::transport::lights::LightStrata;
use crate::transport::paths::LightPath;
use crate::transport::paths::mis::met_by_chance;
use crate::transport::scene::View;
use std::fmt;

pub(in crate::transport) use method::PrimaryMetropolis;
pub(in crate::transport) use mmlt::Mmlt;
pub use mmlt::{Multiplexed, Technique, Techniques};
pub(in crate::transport) use pssmlt::Pssmlt;
pub use pssmlt::{AllConnections, Splats};

/// Numbers of the light's subpath, numbers of the camera's.
const STREAMS: usize = 2;

/// Tracers of all strata.
pub(in crate::transport) trait Tracers: fmt::Debug + Sync {
    /// The result of their numbers.
    type Output: Output<Splat = Splat<3>> + Send;
    /// The tracer of one stratum.
    type Of<'s>: Tracer<STREAMS, Output = Self::Output> + Sync
    where
        Self: 's;

    /// Independent samples for b̂_j and starts.
    const SAMPLES: Samples;

    /// Tracers of paths of so many edges at most.
    fn new(max_edges: usize) -> Self;

    /// The tracer of a stratum.
    fn of<'s>(&'s self, part: Part<'s, PixelImportance>) -> Self::Of<'s>;

    /// Probability of a large step on an image of so many pixels.
    fn large_steps(pixels: u32) -> f64;
}

/// State that the two tracers share: a part of path space, and the scalar that its chains sample.
#[derive(Debug)]
pub struct Part<'a, I> {
    /// Scene and camera.
    pub view: View<'a>,
    /// All strata.
    pub strata: &'a LightStrata,
    /// Which of them.
    pub index: u32,
    /// Most edges of a path.
    pub max_edges: usize,
    /// I of a path; a state's importance is the sum over its paths, each times w_s/p_s.
    pub importance: &'a I,
}

impl<I> Clone for Part<'_, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<I> Copy for Part<'_, I> {}

impl<I> Part<'_, I> {
    /// q_j: how much of a path belongs to this part.
    fn share(&self, path: &LightPath) -> f64 {
        if met_by_chance(path.vertices()) {
            return self.strata.regions()[self.index as usize].power() / self.strata.whole().power();
        }
        f64::from(u8::from(self.strata.index(path.light()) == self.index))
    }
}
