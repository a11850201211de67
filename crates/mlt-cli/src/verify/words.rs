//! A verdict's figures, for reading.

use super::{
    bias::Bias,
    chains::Chains,
    errors::Errors,
    verdict::{Verdict, percent},
};
use crate::progress::short;

impl Verdict {
    /// All figures, for reading.
    pub fn text(&self) -> String {
        let mut lines = vec![self.sentence()];
        if let Some(bias) = &self.bias {
            lines.extend(bias_lines(bias, &self.reference, self.replicas));
        }
        if let Some(chains) = &self.chains {
            lines.extend(chain_lines(chains));
        }
        if let Some(errors) = &self.errors {
            lines.extend(error_lines(errors));
        }
        let warned = |(warning, count): (&String, &usize)| format!("  warned {count} times   {warning}");
        lines.extend(self.warnings.iter().map(warned));
        lines.push(format!("  so do this        {}", self.advice()));
        lines.join("\n") + "\n"
    }
}

fn bias_lines(bias: &Bias, reference: &str, replicas: usize) -> Vec<String> {
    let mut lines = vec![
        format!(
            "  against {reference:<9} p = {:.2e} of {replicas} replicas each, by bootstrap {:.3}; image {:+.3} ± {:.3} %",
            bias.p,
            bias.p_bootstrap,
            percent(bias.image_difference),
            percent(bias.image_stderr)
        ),
        format!("  p-values          {:?}, uniform with p = {:.3}", bias.histogram, bias.p_uniform),
        format!(
            "  power             errors are seen in 4 of 5 studies from {:.2} % of the image, {:.1} % of a region",
            percent(bias.visible),
            percent(bias.visible_in_regions)
        ),
    ];
    if let Some(injected) = &bias.injected {
        let outcome = if injected.caught { "seen" } else { "not seen" };
        lines.push(format!(
            "  injected          1 % of \"{}\", {:.0} % of the light: {outcome} (p = {:.0e})",
            injected.lights,
            percent(injected.share),
            injected.p
        ));
    }
    lines
}

fn chain_lines(chains: &Chains) -> Vec<String> {
    let mut lines = Vec::new();
    if let (Some(r_hat), Some(p), Some(effective)) = (chains.r_hat, chains.p_r_hat, chains.effective_rounds) {
        lines.push(format!(
            "  rounds            split R-hat {r_hat:.3} (p = {p:.2e}), worth {:.0} % of independent ones, in the worst block",
            percent(effective)
        ));
    }
    if let (Some(r_hat), Some(states)) = (chains.r_hat_of_strata, chains.effective_states) {
        let states = short(states);
        lines.push(format!(
            "  chains            split R-hat {r_hat:.3}, worth {states} independent states in all, in the worst stratum"
        ));
    }
    if let (Some(ratio), Some(p)) = (chains.b_spread, chains.p_b_spread) {
        lines.push(format!("  b of strata       scatter {ratio:.2} times as far as reported, at worst (p = {p:.2e})"));
        lines
            .push(format!("  stuck             at most {} proposals in a row were rejected", chains.longest_rejection));
    }
    lines
}

fn error_lines(errors: &Errors) -> Vec<String> {
    let Errors { rel_mse, deviation, median, worst, flicker, .. } = errors;
    let mut lines = vec![format!(
        "  relMSE            {rel_mse:.2e} ± {deviation:.1e} over seeds, median {median:.2e}, worst {worst:.2} × that"
    )];
    if let Some(coverage) = errors.coverage {
        lines.push(format!("  95 % error bars   hold the truth in {:.1} % of pixels", percent(coverage)));
    }
    if errors.doubted > 0 {
        lines.push(format!(
            "  doubted           by {} renders, which say themselves that their error bars cannot be trusted",
            errors.doubted
        ));
    }
    let deciles: Vec<String> = errors.deciles.iter().map(|error| format!("{:.1}", percent(*error))).collect();
    lines.push(format!("  error by decile   {} %, from dark to bright", deciles.join(", ")));
    let moved =
        errors.moved.map_or_else(String::new, |ratio| format!("; lights moved by a millionth: {ratio:.2e} of that"));
    lines.push(format!("  flicker           relMSE {flicker:.2e} between two seeds{moved}"));
    lines
}
