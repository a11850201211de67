//! A plan as bytes, and back without trust.

use super::candidates::Sampler;
use super::constants::BRANCHES;
use super::plan::{PartSummary, Plan, Summary};
use crate::engine::{DecodeError, Reader, put, put_list};
use crate::transport::lights::LightStrata;
use crate::transport::methods::found::{put_shares, read_shares};
use crate::transport::methods::settings::Settings;
use crate::transport::paths::Kinds;
use crate::transport::scene::View;

/// Stands for no independent method.
const NONE: u64 = u64::MAX;
/// Stands for bidirectional path tracing, among numbers of branches.
const BIDIRECTIONAL: u64 = 0;
/// Samples of each pixel in a round that are read, at most, over those that were asked for.
const MOST_SAMPLES: f64 = 256.0;

impl Plan {
    /// Appends it to bytes.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        self.strata.write(to);
        let (sampler, samples) = self.independent.map_or((NONE, 0.0), |(sampler, samples)| match sampler {
            Sampler::Path { branches } => (branches.into(), samples),
            Sampler::Bidirectional => (BIDIRECTIONAL, samples),
        });
        [sampler, samples.to_bits(), self.summary.chain_share.to_bits()].into_iter().for_each(|x| put(to, x));
        put_list(to, &self.chained, |to, kinds| kinds.write(to));
        put_shares(to, &self.shares);
        put_list(to, &self.summary.parts, |to, part| part.write(to));
    }

    /// Reads what [`write`](Self::write) has written for a view and settings.
    pub(super) fn read(view: View, settings: &Settings, from: &mut Reader) -> Result<Self, DecodeError> {
        let strata = LightStrata::read(view.scene.lights(), from)?;
        let independent = read_independent(settings, from)?;
        let chain_share = f64::from_bits(from.number()?);
        let chained = from.list(Kinds::read)?;
        let asked_for = settings.per_pixel.max(1.0) * f64::from(view.camera.pixels());
        let shares = read_shares(asked_for, from)?;
        let parts = from.list(PartSummary::read)?;
        let open = chained.iter().filter(|kinds| !kinds.is_empty()).count();
        let fits = chained.len() == strata.regions().len() && shares.len() == open;
        if !fits || (independent.is_none() && open == 0) {
            return Err(DecodeError::Damaged);
        }
        let summary = Summary { sampler: independent.map(|(sampler, _)| sampler), chain_share, parts };
        Ok(Self { strata, independent, chained, shares, summary })
    }
}

fn read_independent(settings: &Settings, from: &mut Reader) -> Result<Option<(Sampler, f64)>, DecodeError> {
    let (sampler, samples) = (from.number()?, f64::from_bits(from.number()?));
    let sampler = match sampler {
        NONE => return Ok(None),
        BIDIRECTIONAL => Some(Sampler::Bidirectional),
        _ => BRANCHES.into_iter().find(|n| u64::from(*n) == sampler).map(|branches| Sampler::Path { branches }),
    };
    let in_bounds = samples > 0.0 && samples <= MOST_SAMPLES * settings.per_pixel.max(1.0);
    sampler.filter(|_| in_bounds).map(|sampler| Some((sampler, samples))).ok_or(DecodeError::Damaged)
}

impl PartSummary {
    fn write(&self, to: &mut Vec<u8>) {
        put(to, self.light as u64);
        self.kinds.write(to);
        [self.path, self.bidirectional, self.chains].into_iter().for_each(|noise| put(to, noise.to_bits()));
        put(to, self.in_chains.into());
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let (light, kinds) = (from.number()? as usize, Kinds::read(from)?);
        let mut noise = || from.number().map(f64::from_bits);
        let (path, bidirectional, chains) = (noise()?, noise()?, noise()?);
        Ok(Self { light, kinds, path, bidirectional, chains, in_chains: from.number()? != 0 })
    }
}
