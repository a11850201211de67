//! Primary sample space over whole bidirectional samples: all connections of two subpaths are one state.
//!
//! Source: [KelemenSzirmayKalos02], section 4.

use super::{Part, PrimaryMetropolis, STREAMS, Tracers};
use crate::engine::{Importance, Splat};
use crate::primary::{Output, Streams, Tracer};
use crate::transport::image::PixelImportance;
use crate::transport::methods::bidirectional::Bidirectional;
use crate::transport::methods::samples::Samples;
use crate::transport::paths::LightPath;

/// Probability of a large step.
const LARGE_STEPS: f64 = 0.3;

/// F(u) = Σ_{s,t} q_j w_s f / p_s over the connections of the two subpaths.
#[derive(Clone, Copy, Debug)]
pub struct AllConnections<'a, I> {
    /// Where.
    pub part: Part<'a, I>,
}

/// Deposits of all connections, those at one pixel added up.
#[derive(Clone, Debug, Default)]
pub struct Splats {
    splats: Vec<Splat<3>>,
    importance: f64,
}

impl Output for Splats {
    type Splat = Splat<3>;

    #[inline]
    fn importance(&self) -> f64 {
        self.importance
    }

    fn splats(&self) -> impl Iterator<Item = Splat<3>> {
        self.splats.iter().copied()
    }
}

impl Splats {
    fn add(&mut self, path: &LightPath, weight: f64) {
        let value = path.contribution * (f64::from(path.pixels) * weight);
        match self.splats.iter_mut().find(|splat| splat.site == path.pixel) {
            Some(splat) => splat.value.iter_mut().zip(value.to_array()).for_each(|(sum, v)| *sum += v),
            None => self.splats.push(Splat { site: path.pixel, value: value.to_array() }),
        }
    }
}

impl<I: Importance<LightPath>> Tracer<STREAMS> for AllConnections<'_, I> {
    type Output = Splats;

    fn trace(&self, [light, eye]: &mut Streams<STREAMS>, output: &mut Splats) -> bool {
        let Part { view, strata, index, max_edges, importance } = self.part;
        let sampler = Bidirectional { view, region: &strata.regions()[index as usize], max_edges };
        output.splats.clear();
        output.importance = 0.0;
        sampler.sample_apart(light, eye, &mut |path, weight| {
            let weight = weight * self.part.share(path);
            if weight > 0.0 {
                output.importance += weight * importance.eval(path);
                output.add(path, weight);
            }
        });
        output.importance > 0.0
    }
}

/// Bidirectional samples of all strata.
#[derive(Clone, Copy, Debug)]
pub(in crate::transport) struct Connecting;

impl Tracers for Connecting {
    type Output = Splats;
    type Of<'s> = AllConnections<'s, PixelImportance>;

    const SAMPLES: Samples = Samples::BIDIRECTIONAL;

    fn new(_max_edges: usize) -> Self {
        Self
    }

    fn of<'s>(&'s self, part: Part<'s, PixelImportance>) -> Self::Of<'s> {
        AllConnections { part }
    }

    fn large_steps(_pixels: u32) -> f64 {
        LARGE_STEPS
    }
}

/// Stratified Metropolis over the random numbers of bidirectional samples.
pub(in crate::transport) type Pssmlt<'a> = PrimaryMetropolis<'a, Connecting>;
