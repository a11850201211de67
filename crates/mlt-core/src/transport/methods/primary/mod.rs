//! The bidirectional path tracer in primary sample space.
//!
//! Both tracers draw x_0 on their stratum's region, so no vertex drawn on a light leaves the stratum; a path that meets a
//! light by chance (s = 0) counts only if it meets it in the stratum. Over the paths of Ω_j the MIS weights refer to the
//! region's density and sum to 1, so that ∫ F(u) du = ∫_{Ω_j} f. Paths that are met by chance and in no other way belong to all
//! strata, a share q_j = Φ_j/Φ of them to each: there is no light end to draw, so a cut would only throw meetings away.

mod chains;
mod mmlt;
mod pssmlt;

use crate::primary::PrimaryStratum;
use crate::transport::lights::{LightRegion, LightStrata};
use crate::transport::paths::LightPath;
use crate::transport::paths::mis::met_by_chance;
use crate::transport::scene::View;

pub use mmlt::{Mmlt, Multiplexed, Technique, Techniques};
pub use pssmlt::{AllConnections, Pssmlt, Splats};

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

impl<'a, I> Part<'a, I> {
    /// One tracer a stratum, in the order of the strata.
    pub fn all<T>(self, tracer: impl Fn(Self) -> T) -> Vec<PrimaryStratum<T>> {
        let of = |(index, region): (u32, &LightRegion)| PrimaryStratum {
            tracer: tracer(Self { index, ..self }),
            power: region.power(),
        };
        (0..).zip(self.strata.regions()).map(of).collect()
    }

    /// q_j: how much of a path belongs to this part.
    fn share(&self, path: &LightPath) -> f64 {
        if met_by_chance(path.vertices()) {
            return self.strata.regions()[self.index as usize].power() / self.strata.whole().power();
        }
        f64::from(u8::from(self.strata.index(path.light()) == self.index))
    }
}
