//! Decision of the method `auto`.

use std::fmt;

use mlt_core::transport::methods::auto::{PartSummary, Sampler, Summary};
use serde::Serialize;

use super::finite;

/// How path space is shared out between independent samples and chains.
#[derive(Clone, Debug, Serialize)]
pub struct Decision {
    /// `pt` or `bdpt`; `None`: chains alone.
    pub independent: Option<&'static str>,
    /// Walks of each sample that go on from the first surface.
    pub branches: Option<u32>,
    /// Share of the work that chains get.
    pub chain_share: f64,
    /// Every part of path space.
    pub parts: Vec<Part>,
}

/// A part of path space. Each noise is error × work of an estimator that does nothing else, in the unit of
/// [`PartSummary`]; `None` is infinite.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// Number of the part of the lights.
    pub light: usize,
    /// Which paths, in words.
    pub paths: String,
    /// Noise of path tracing.
    pub pt: Option<f64>,
    /// Noise of bidirectional path tracing.
    pub bdpt: Option<f64>,
    /// Noise of chains.
    pub mlt: Option<f64>,
    /// The method that samples it.
    pub method: &'static str,
}

impl From<&Summary> for Decision {
    fn from(summary: &Summary) -> Self {
        let independent = summary.sampler.map(|sampler| match sampler {
            Sampler::Path { .. } => "pt",
            Sampler::Bidirectional => "bdpt",
        });
        let branches = summary.sampler.and_then(|sampler| match sampler {
            Sampler::Path { branches } => Some(branches),
            Sampler::Bidirectional => None,
        });
        let part = |part: &PartSummary| Part {
            light: part.light,
            paths: part.kinds.to_string(),
            pt: finite(part.path),
            bdpt: finite(part.bidirectional),
            mlt: finite(part.chains),
            method: independent.filter(|_| !part.in_chains).unwrap_or("mlt"),
        };
        let parts = summary.parts.iter().map(part).collect();
        Self { independent, branches, chain_share: summary.chain_share, parts }
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let share = 100.0 * self.chain_share;
        let branches = match self.branches {
            Some(branches @ 2..) => format!(" with {branches} branches"),
            _ => String::new(),
        };
        match self.independent {
            None => writeln!(f, "  auto            mlt alone"),
            Some(method) if self.chain_share == 0.0 => writeln!(f, "  auto            {method}{branches} alone"),
            Some(method) => {
                writeln!(f, "  auto            {method}{branches}, and mlt with {share:.0} % of the work for")
            }
        }?;
        let chained = self.parts.iter().filter(|part| part.method == "mlt" && part.mlt != Some(0.0));
        for part in chained.filter(|_| self.independent.is_some()) {
            writeln!(f, "                  light part {}: {}", part.light, part.paths)?;
        }
        Ok(())
    }
}
