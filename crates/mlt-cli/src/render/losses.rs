//! What a render left out, with figures and places.

use mlt_core::engine::{Film, StratumStats};
use mlt_core::transport::render::Counts;

/// Places that a warning names.
const NAMED: usize = 4;

/// One warning for each kind of loss. `width`: pixels in a row.
pub fn losses(film: &Film<3>, counts: &Counts, width: usize) -> Vec<String> {
    let mut warnings = Vec::new();
    let dropped = |s: &StratumStats| s.non_finite_samples + s.mutations.iter().map(|m| m.non_finite).sum::<u64>();
    let paths: u64 = counts.strata.iter().map(dropped).sum();
    if paths > 0 {
        let makers = makers(counts).join(", ");
        let strata = (0..counts.strata.len()).filter(|&j| dropped(&counts.strata[j]) > 0);
        let strata = named(strata.map(|j| j.to_string()));
        warnings.push(format!(
            "{paths} paths had an importance that is not finite; they are left out (made by {makers}; strata {strata})"
        ));
    }
    let refused: u64 = counts.strata.iter().map(|s| s.refused_starts).sum();
    if refused > 0 {
        let strata = (0..counts.strata.len()).filter(|&j| counts.strata[j].refused_starts > 0);
        let strata = named(strata.map(|j| j.to_string()));
        warnings
            .push(format!("{refused} chains could not start; what they would have added is missing (strata {strata})"));
    }
    let pixels_of = |sites: &[usize]| named(sites.iter().map(|site| format!("({}, {})", site % width, site / width)));
    let lost = film.lost();
    if lost.count > 0 {
        let sites: Vec<_> = lost.sites.iter().map(|&site| site as usize).collect();
        let pixels = pixels_of(&sites);
        warnings.push(format!("{} contributions were not finite; they are left out (in {pixels})", lost.count));
    }
    let clipped = clipped(film);
    if !clipped.is_empty() {
        let pixels = pixels_of(&clipped);
        warnings.push(format!(
            "{} pixels are brighter than the film can hold: their values or errors are clipped ({pixels})",
            clipped.len()
        ));
    }
    warnings
}

/// What made paths that are not finite.
fn makers(counts: &Counts) -> Vec<&'static str> {
    let made = |k: usize| counts.strata.iter().any(|s| s.mutations.get(k).is_some_and(|m| m.non_finite > 0));
    let mutations = counts.mutations.iter().enumerate().filter(|(k, _)| made(*k)).map(|(_, name)| *name);
    let samples = counts.strata.iter().any(|s| s.non_finite_samples > 0).then_some("independent samples");
    mutations.chain(samples).collect()
}

/// Pixels whose sums of squares left the film's range; with one round nothing is known.
fn clipped(film: &Film<3>) -> Vec<usize> {
    if film.rounds() < 2 {
        return Vec::new();
    }
    (0..film.sites() as usize).filter(|&i| film.pixel(i).iter().any(|c| c.stderr == f64::INFINITY)).collect()
}

/// The first few, and how many more there are.
fn named(mut places: impl Iterator<Item = String>) -> String {
    let first: Vec<String> = places.by_ref().take(NAMED).collect();
    match places.count() {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use mlt_core::engine::{MutationStats, Sink, Splat};

    use super::*;

    #[test]
    fn places_are_named() {
        let lens = |non_finite| MutationStats { non_finite, ..MutationStats::default() };
        let stratum = |n| StratumStats { mutations: vec![lens(0), lens(n)], ..StratumStats::default() };
        let refused = StratumStats { refused_starts: 2, ..stratum(1) };
        let strata = [0, 3, 1, 1, 1, 1].map(stratum).into_iter().chain([refused]).collect();
        let counts = Counts { strata, mutations: vec!["bidirectional", "lens"], ..Counts::default() };
        let warnings = losses(&Film::new(4, 1.0), &counts, 2);
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(
            warnings[0].starts_with("8 paths") && warnings[0].contains("made by lens; strata 1, 2, 3, 4 and 2 more")
        );
        assert!(warnings[1].starts_with("2 chains") && warnings[1].ends_with("(strata 6)"), "{warnings:?}");
    }

    #[test]
    fn pixels_out_of_range_are_named() {
        let mut film = Film::<3>::new(4, 1.0);
        for value in [1e11, 3e11] {
            let mut deposits = film.deposits();
            deposits.deposit(Splat { site: 3, value: [value; 3] }, 1.0);
            film.add(&[deposits]);
            film.close_round(1);
        }
        let warnings = losses(&film, &Counts::default(), 2);
        assert!(warnings.len() == 1 && warnings[0].ends_with("clipped ((1, 1))"), "{warnings:?}");
        assert!(losses(&Film::new(4, 1.0), &Counts::default(), 2).is_empty());
    }

    #[test]
    fn what_is_not_finite_is_named_by_pixel() {
        let mut film = Film::<3>::new(6, 1.0);
        let mut deposits = film.deposits();
        for site in [4, 1, 4] {
            deposits.deposit(Splat { site, value: [f64::NAN, 1.0, 1.0] }, 1.0);
        }
        film.add(&[deposits]);
        let warnings = losses(&film, &Counts::default(), 3);
        assert_eq!(warnings, ["3 contributions were not finite; they are left out (in (1, 0), (1, 1))"]);
    }
}
