//! Film and counts in the report of a render.

use std::collections::BTreeMap;

use mlt_core::engine::{Film, MutationStats, Pixel, StratumStats, TRUSTED_ROUNDS, Tally, total_count};
use mlt_core::transport::image::{mean_luminance, relative_error};
use mlt_core::transport::render::{Counts, Sums};
use mlt_core::transport::scene::Needs;

use super::{Setup, blocks::Blocks, losses::losses, trust::trust};
use crate::{
    args::{render::RenderOptions, transport::Method},
    provenance::Provenance,
    report::{Acceptance, Agreement, Report, StratumReport},
};

/// The report, but for times, files and what only the session knows.
pub(crate) fn report(options: &RenderOptions, provenance: &Provenance, sums: &Sums) -> anyhow::Result<Report> {
    let (film, counts, blocks) = (sums.film(), sums.tally(), &Blocks::from(sums.film().blocks()));
    let [width, height] = film.size().map(|n| n as usize);
    let Pixel { mean: b, stderr: b_stderr } = mean_luminance(film);
    let mutations = by_mutation(counts);
    let mut report = Report {
        version: env!("CARGO_PKG_VERSION").into(),
        scene: provenance.scene.clone(),
        method: options.method(),
        transport: options.transport.clone(),
        camera: provenance.camera.clone(),
        width,
        height,
        crop: options.view.frame()?,
        threads: rayon::current_num_threads(),
        first_round: film.rounds_held().ranges().first().map_or(0, |rounds| rounds.start),
        rounds: film.rounds(),
        interrupted: false,
        seconds: 0.0,
        cpu_seconds: None,
        mutations: counts.steps(),
        samples: total_count(counts.chains().strata.iter().map(|s| s.samples).chain([counts.samples()])),
        rays: counts.rays(),
        chain_rays: counts.chains().work(),
        pilot_mutations: counts.pilot.mutations,
        pilot_rays: counts.pilot.rays,
        acceptance: acceptance(&mutations),
        longest_rejection: mutations.iter().map(|(name, stats)| (name.clone(), stats.longest_rejection)).collect(),
        b,
        b_stderr,
        strata: counts.chains().strata.iter().map(stratum).collect(),
        relative_error: Some(relative_error(film)).filter(|error| error.is_finite()),
        agreement: blocks.agreement().filter(|_| counts.steps() > 0),
        trust: trust(film, counts, blocks, film.size()),
        decision: None,
        warnings: provenance.warnings.clone(),
        outputs: Vec::new(),
    };
    report.warnings.extend(doubts(options, sums, &report));
    Ok(report)
}

/// Reasons not to trust the image, or not to have asked for it in this way.
fn doubts(options: &RenderOptions, sums: &Sums, report: &Report) -> Vec<String> {
    let film = sums.film();
    let mut doubts: Vec<_> = without_effect(options).into_iter().collect();
    doubts.extend(warnings(film));
    doubts.extend(losses(film, sums.tally(), report.width));
    doubts.extend(report.agreement.as_ref().and_then(Agreement::warning));
    doubts.extend(report.trust.doubts());
    doubts
}

/// Counts of each mutation over all strata.
fn by_mutation(counts: &Counts) -> BTreeMap<String, MutationStats> {
    let Tally { strata, mutations: names } = counts.chains();
    let mut mutations: BTreeMap<_, _> = names.iter().map(|name| (name.to_string(), MutationStats::default())).collect();
    for (name, stats) in strata.iter().flat_map(|s| names.iter().zip(&s.mutations)) {
        mutations.entry(name.to_string()).or_default().merge(stats);
    }
    mutations
}

fn acceptance(mutations: &BTreeMap<String, MutationStats>) -> Acceptance {
    let rate = |stats: &MutationStats| (stats.total() > 0).then(|| stats.acceptance());
    let mut all = MutationStats::default();
    mutations.values().for_each(|stats| all.merge(stats));
    let mutations = mutations.iter().map(|(name, stats)| (name.clone(), rate(stats)));
    Acceptance { mutations: mutations.collect(), total: rate(&all) }
}

fn stratum(stats: &StratumStats) -> StratumReport {
    let (b, b_stderr, longest_rejection) = (stats.b(), stats.b_stderr(), stats.longest_rejection);
    let (r_hat, effective_states) = (stats.halves.r_hat(), stats.halves.effective_states());
    let (mutations, halves) = (stats.steps(), stats.halves.clone());
    StratumReport { b, b_stderr, met_by_chance: false, mutations, longest_rejection, r_hat, effective_states, halves }
}

/// Options of chains for a method that has none.
fn without_effect(options: &RenderOptions) -> Option<String> {
    let method = options.method();
    let ignored = matches!(method, Method::Pt | Method::Bdpt) && options.transport.change_chains();
    ignored.then(|| {
        format!(
            "{method} has no chains: --strata, --weights, --variant, --perturbations and --importance have no effect; \
             --method mlt takes them"
        )
    })
}

/// Where the image of these options comes from.
pub(super) fn provenance(options: &RenderOptions, setup: &Setup) -> Provenance {
    let mut provenance = setup.provenance.clone();
    provenance.warnings.extend(out_of_reach(options, setup));
    provenance
}

/// Light that path tracing has no way to find: no ray meets a light without extent, and none is connected through glass.
fn out_of_reach(options: &RenderOptions, setup: &Setup) -> Option<String> {
    let Needs { punctual, specular, .. } = setup.scene.needs();
    let missed = options.method() == Method::Pt && punctual && specular;
    missed.then(|| {
        "pt finds nothing of what glass and mirrors make of point, spot and directional lights; auto, bdpt and mlt do".to_owned()
    })
}

fn warnings(film: &Film<3>) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut warn = |condition: bool, text: String| {
        if condition {
            warnings.push(text);
        }
    };
    let dark = (0..film.sites() as usize).all(|i| film.pixel(i).iter().all(|channel| channel.mean == 0.0));
    let rounds = film.rounds();
    warn(
        rounds == 1,
        format!(
            "one round says nothing of its error; take {TRUSTED_ROUNDS} or more to know it, as by --rounds {TRUSTED_ROUNDS}"
        ),
    );
    warn(
        (2..TRUSTED_ROUNDS).contains(&rounds),
        format!("the error is estimated from {rounds} rounds only; take {TRUSTED_ROUNDS} or more to trust it"),
    );
    warn(dark, "the image is black: no path from a light to the camera was found; see what the camera looks at and which lights \
         count by 'mlt inspect', or add --environment sky".into());
    warnings
}
