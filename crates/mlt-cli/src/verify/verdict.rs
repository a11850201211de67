//! From evidence to words.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{
    bias::{Bias, SIGNIFICANCE, bias},
    chains::{Chains, chains},
    errors::{Errors, errors},
    evidence::Evidence,
    fault::Fault,
    warnings,
};

/// Least share of 95 % intervals that has to hold the truth.
const LEAST_COVERAGE: f64 = 0.90;
/// Worst error over median error that is steady.
const STEADY: f64 = 3.0;
/// Errors of a single region may be this many times those of the image before they have to be visible.
const REGIONAL: f64 = 10.0;
/// Probability in the bootstrap below which a difference is not put down to skewed replicas.
const BOOTSTRAP_SIGNIFICANCE: f64 = 5e-3;

/// Whether images of a method can be trusted.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// No fault was found, and one would have been.
    Passes,
    /// No fault was found, but small ones would not have been.
    Inconclusive,
    /// There is a fault.
    Fails,
}

impl Status {
    /// As in the table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Passes => "passes",
            Self::Inconclusive => "inconclusive",
            Self::Fails => "fails",
        }
    }
}

/// Verdict on one method and one scene.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Verdict {
    /// The scene as named on the command line.
    pub scene: String,
    /// The method as named on the command line.
    pub method: String,
    /// The method that it was compared with.
    pub reference: String,
    /// Number of renders of each.
    pub replicas: usize,
    /// In one word.
    pub status: Status,
    /// The faults.
    pub faults: Vec<Fault>,
    /// Further remarks, in sentences without a full stop.
    pub remarks: Vec<String>,
    /// Comparison with the reference; `None` for a black image.
    pub bias: Option<Bias>,
    /// Agreement of chains and rounds.
    pub chains: Option<Chains>,
    /// Sizes of errors.
    pub errors: Option<Errors>,
    /// Warnings of renders, and how many renders gave each; a figure that differs between them is a range.
    pub warnings: BTreeMap<String, usize>,
}

/// Names of what is judged.
#[derive(Clone, Debug)]
pub struct Names {
    /// The scene.
    pub scene: String,
    /// The method.
    pub method: String,
    /// The method that it is compared with.
    pub reference: String,
}

/// Judges a method. `detect`: relative error of the image that has to be visible; `moved`: relMSE between two frames
/// with the lights moved by a millionth, if they were rendered.
pub fn judge(names: Names, evidence: &Evidence, detect: f64, moved: Option<f64>) -> Verdict {
    let Names { scene, method, reference } = names;
    let mut verdict = Verdict {
        scene,
        method,
        reference,
        replicas: evidence.method.len(),
        status: Status::Passes,
        faults: Vec::new(),
        remarks: Vec::new(),
        bias: None,
        chains: None,
        errors: None,
        warnings: warnings::counted(evidence.method.iter().flat_map(|replica| &replica.warnings)),
    };
    if evidence.is_black() {
        verdict.status = Status::Inconclusive;
        verdict.remarks.push("the image is black in every replica of both methods".into());
        return verdict;
    }
    let (bias, chains, mut errors) = (bias(evidence), chains(&evidence.method), errors(evidence));
    errors.moved = moved.map(|moved| moved / errors.flicker).filter(|ratio| ratio.is_finite());
    verdict.faults = [differs(&bias), chains.faults(), unsteady(&errors), overconfident(&errors)].concat();
    verdict.remarks.extend(unseen(&bias, detect));
    verdict.status = match (verdict.faults.is_empty(), verdict.remarks.is_empty()) {
        (false, _) => Status::Fails,
        (true, false) => Status::Inconclusive,
        (true, true) => Status::Passes,
    };
    (verdict.bias, verdict.chains, verdict.errors) = (Some(bias), Some(chains), Some(errors));
    verdict
}

fn differs(bias: &Bias) -> Vec<Fault> {
    if !is_wrong(bias) {
        return Vec::new();
    }
    let place = match bias.region {
        Some([x, y]) => {
            format!("by {:+.1} % in column {}, row {} of the regions", percent(bias.difference), x + 1, y + 1)
        }
        None => "in the image's mean".into(),
    };
    let (image, stderr) = (percent(bias.image_difference), percent(bias.image_stderr));
    let sentence = format!(
        "differs from the reference {place} (p = {:.0e}); the whole image by {image:+.2} ± {stderr:.2} %",
        bias.p
    );
    vec![Fault::new("wrong", sentence)]
}

fn is_wrong(bias: &Bias) -> bool {
    bias.p < SIGNIFICANCE && bias.p_bootstrap <= BOOTSTRAP_SIGNIFICANCE
}

fn unseen(bias: &Bias, detect: f64) -> Option<String> {
    let culprit = if bias.reference_share > 0.5 { "the reference is" } else { "its replicas are" };
    if is_wrong(bias) {
        return None;
    }
    if bias.p < SIGNIFICANCE {
        return Some(format!(
            "a difference of {:+.1} % may be chance, since replicas are uneven (p = {:.0e}, by bootstrap {:.3})",
            percent(bias.difference),
            bias.p,
            bias.p_bootstrap
        ));
    }
    if bias.visible > detect {
        let visible = percent(bias.visible);
        return Some(format!("errors of the image below {visible:.1} % would not be seen: {culprit} too noisy"));
    }
    if bias.visible_in_regions > REGIONAL * detect {
        let visible = percent(bias.visible_in_regions);
        return Some(format!("errors of a region below {visible:.0} % would not be seen: {culprit} too noisy"));
    }
    (bias.p_uniform < BOOTSTRAP_SIGNIFICANCE).then(|| {
        format!("the regions' differences from the reference are not those of chance (p = {:.3})", bias.p_uniform)
    })
}

fn unsteady(errors: &Errors) -> Vec<Fault> {
    if errors.worst <= STEADY {
        return Vec::new();
    }
    vec![Fault::new("unsteady", format!("the worst seed's error is {:.1} times the median's", errors.worst))]
}

fn overconfident(errors: &Errors) -> Vec<Fault> {
    match errors.coverage {
        Some(coverage) if coverage < LEAST_COVERAGE => {
            vec![Fault::new("bars", format!("95 % error bars hold the truth in {:.0} % of pixels", percent(coverage)))]
        }
        _ => Vec::new(),
    }
}

pub(super) fn percent(share: f64) -> f64 {
    100.0 * share
}

impl Verdict {
    /// One sentence.
    pub fn sentence(&self) -> String {
        let Self { scene, method, .. } = self;
        let reasons = self.reasons();
        match self.status {
            Status::Passes => format!("{scene}: {method} can be trusted"),
            Status::Inconclusive => format!("{scene}: the verdict on {method} is inconclusive: {}", reasons),
            Status::Fails => format!("{scene}: {method} cannot be trusted: {}", reasons),
        }
    }

    /// Why, in sentences without a full stop.
    pub fn reasons(&self) -> String {
        let faults = self.faults.iter().map(|fault| fault.sentence.as_str());
        faults.chain(self.remarks.iter().map(String::as_str)).collect::<Vec<_>>().join("; ")
    }
}
