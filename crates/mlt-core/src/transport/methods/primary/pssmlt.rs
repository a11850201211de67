//! Primary sample space over whole bidirectional samples: all connections of two subpaths are one state.
//!
//! Source: [KelemenSzirmayKalos02], section 4.

use super::Part;
use super::chains::PrimaryChains;
use crate::engine::{DecodeError, Importance, Outcome, Reader, Share, Splat, Watch};
use crate::primary::{Output, PrimaryStratum, Streams, Tracer};
use crate::transport::image::PixelImportance;
use crate::transport::methods::bidirectional::Bidirectional;
use crate::transport::methods::counts::PilotCounts;
use crate::transport::methods::run::Run;
use crate::transport::methods::samples::{Samples, paired};
use crate::transport::methods::settings::Settings;
use crate::transport::paths::LightPath;
use crate::transport::scene::View;

/// Probability of a large step.
const LARGE_STEPS: f64 = 0.3;

/// Numbers of the light's subpath, numbers of the camera's.
const STREAMS: usize = 2;

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

/// Stratified Metropolis over the random numbers of bidirectional samples.
#[derive(Debug)]
pub struct Pssmlt<'a> {
    chains: PrimaryChains<'a>,
    shares: Vec<Share>,
    pilot: PilotCounts,
}

impl<'a> Pssmlt<'a> {
    /// Cuts the lights and measures how many samples a round needs; nothing if that is stopped.
    pub fn new(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let chains = PrimaryChains::new(view, settings, watch)?;
        let (shares, pilot) = chains.shares(strata(&chains), Samples::BIDIRECTIONAL, watch)?;
        Some(Self { chains, shares, pilot })
    }

    /// The same with what [`pilot`](Self::pilot) gives.
    pub(in crate::transport) fn following(
        view: View<'a>,
        settings: Settings,
        from: &mut Reader,
    ) -> Result<Self, DecodeError> {
        let (chains, shares, pilot) = PrimaryChains::following(view, settings, from)?;
        Ok(Self { chains, shares, pilot })
    }

    /// Measurements before the first round, as bytes.
    pub(in crate::transport) fn pilot(&self) -> Vec<u8> {
        self.chains.found(&self.shares, self.pilot)
    }

    /// Adds rounds.
    pub fn render(&self, run: Run) -> Outcome {
        self.chains.render(&paired(strata(&self.chains), &self.shares), LARGE_STEPS, self.pilot, run)
    }
}

fn strata<'s>(chains: &'s PrimaryChains) -> Vec<PrimaryStratum<AllConnections<'s, PixelImportance>>> {
    chains.part().all(|part| AllConnections { part })
}
