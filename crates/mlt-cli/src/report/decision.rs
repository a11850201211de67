//! Decision of the method `auto`.

use std::fmt;

use mlt_core::transport::methods::auto::Summary;
use serde::Serialize;

use super::finite;

/// How the work is shared out between path tracing and chains.
#[derive(Clone, Debug, Serialize)]
pub struct Decision {
    /// Walks of each sample of path tracing that go on from the first surface.
    pub branches: u32,
    /// Whether path tracing takes lamps in view only.
    pub lamps_only: bool,
    /// Share of the work that chains get.
    pub chain_share: f64,
    /// Share of the light, lamps in view left out, that chains would take.
    pub hard_light: f64,
    /// Error × work of path tracing alone, in the unit of [`Summary`]; `None`: it cannot be told.
    pub pt: Option<f64>,
    /// Error × work of both together.
    pub mixture: Option<f64>,
}

impl From<&Summary> for Decision {
    fn from(summary: &Summary) -> Self {
        let &Summary { branches, lamps_only, chain_share, hard_light, path, mixture } = summary;
        Self { branches, lamps_only, chain_share, hard_light, pt: finite(path), mixture: finite(mixture) }
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [work, light] = [self.chain_share, self.hard_light].map(|share| 100.0 * share);
        let branches = match self.branches {
            branches @ 2.. => format!(" with {branches} branches"),
            _ => String::new(),
        };
        match (self.chain_share > 0.0, self.lamps_only) {
            (false, _) => writeln!(f, "  auto            pt{branches} alone"),
            (true, true) => writeln!(f, "  auto            mlt with {work:.0} % of the work, pt for lamps in view"),
            (true, false) => writeln!(
                f,
                "  auto            pt{branches}, and mlt with {work:.0} % of the work for {light:.2} % of the light"
            ),
        }
    }
}
