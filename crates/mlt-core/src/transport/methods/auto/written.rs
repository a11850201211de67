//! A plan as bytes, and back without trust.

use super::chains::most_walks;
use super::constants::{BRANCHES, MOST_SAMPLES};
use super::levels::Levels;
use super::plan::{Plan, Summary};
use crate::engine::{DecodeError, Reader, put};
use crate::transport::lights::LightStrata;
use crate::transport::methods::found::{put_shares, read_shares};
use crate::transport::methods::settings::Settings;
use crate::transport::scene::View;

impl Plan {
    /// Appends it to bytes.
    pub(super) fn write(&self, to: &mut Vec<u8>) {
        self.strata.write(to);
        self.levels.write(to);
        [self.branches.into(), self.max_edges as u64, self.samples.to_bits()].into_iter().for_each(|x| put(to, x));
        put_shares(to, &self.shares);
        self.summary.write(to);
    }

    /// Reads what [`write`](Self::write) has written for a view and settings.
    pub(super) fn read(view: View, settings: &Settings, from: &mut Reader) -> Result<Self, DecodeError> {
        let (strata, levels) = (LightStrata::read(view.scene.lights(), from)?, Levels::read(from)?);
        let (branches, max_edges) = (from.number()?, from.number()? as usize);
        let samples = f64::from_bits(from.number()?);
        let asked_for = settings.per_pixel.max(1.0) * f64::from(view.camera.pixels());
        let shares = read_shares([asked_for, most_walks(&view) as f64], from)?;
        let branches = BRANCHES.into_iter().find(|&n| u64::from(n) == branches).ok_or(DecodeError::Damaged)?;
        let in_bounds = (1..=settings.most_edges()).contains(&max_edges)
            && samples > 0.0
            && samples <= MOST_SAMPLES * settings.per_pixel.max(1.0);
        let fits =
            shares.is_empty() || shares.len() == strata.regions().len() + usize::from(view.scene.needs().met_by_chance);
        match in_bounds && fits && (shares.is_empty() || !levels.is_dark()) {
            true => Ok(Self { strata, levels, branches, max_edges, samples, shares, summary: Summary::read(from)? }),
            false => Err(DecodeError::Damaged),
        }
    }
}

impl Summary {
    fn write(&self, to: &mut Vec<u8>) {
        [u64::from(self.branches), self.lamps_only.into()].into_iter().for_each(|x| put(to, x));
        let shares = [self.chain_share, self.hard_light, self.path, self.mixture];
        shares.into_iter().for_each(|x| put(to, x.to_bits()));
    }

    fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let (branches, lamps_only) = (from.number()? as u32, from.number()? != 0);
        let mut number = || from.number().map(f64::from_bits);
        let (chain_share, hard_light, path, mixture) = (number()?, number()?, number()?, number()?);
        Ok(Self { branches, lamps_only, chain_share, hard_light, path, mixture })
    }
}
