//! A list of perturbations, from text.

use std::{fmt, str::FromStr};

use mlt_core::transport::methods::metropolis::Perturbations;
use serde::{Serialize, Serializer};

/// `all`, `none`, or names with commas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerturbationList(pub Perturbations);

const NAMES: [&str; 4] = ["lens", "multi-chain", "pivot", "caustic"];

impl FromStr for PerturbationList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => Ok(Self(Perturbations::ALL)),
            "none" => Ok(Self(Perturbations::NONE)),
            _ => named(text).map(Self),
        }
    }
}

fn named(text: &str) -> Result<Perturbations, String> {
    let mut chosen = Perturbations::NONE;
    // A plus sign is for lists of methods, which commas part.
    for name in text.split([',', '+']) {
        match name {
            "lens" => chosen.lens = true,
            "multi-chain" => chosen.multi_chain = true,
            "pivot" => chosen.pivot = true,
            "caustic" => chosen.caustic = true,
            _ => return Err(format!("give 'all', 'none', or some of {}, with commas between them", NAMES.join(", "))),
        }
    }
    Ok(chosen)
}

impl fmt::Display for PerturbationList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Perturbations { lens, multi_chain, pivot, caustic } = self.0;
        let named = NAMES.into_iter().zip([lens, multi_chain, pivot, caustic]);
        let names: Vec<_> = named.filter_map(|(name, chosen)| chosen.then_some(name)).collect();
        match names.len() {
            0 => f.write_str("none"),
            4 => f.write_str("all"),
            _ => f.write_str(&names.join(",")),
        }
    }
}

impl Serialize for PerturbationList {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read_and_written() {
        for (text, written) in [
            ("all", "all"),
            ("none", "none"),
            ("caustic,lens", "lens,caustic"),
            ("multi-chain", "multi-chain"),
            ("lens+caustic+pivot+multi-chain", "all"),
        ] {
            assert_eq!(text.parse::<PerturbationList>().map(|list| list.to_string()).as_deref(), Ok(written));
        }
        for bad in ["", "lens,", "bidirectional", "lens caustic", "none,lens"] {
            assert!(
                bad.parse::<PerturbationList>().expect_err(bad).contains("lens, multi-chain, pivot, caustic"),
                "{bad}"
            );
        }
    }
}
