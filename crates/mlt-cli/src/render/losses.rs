//! Losses and warnings of a render, with figures and places.

use mlt_core::engine::{Film, WarningKind};
use mlt_core::transport::render::Counts;

/// Places that a warning names.
const NAMED: usize = 4;

/// One warning for each kind of loss, those of chains first. `width`: pixels in a row.
pub(super) fn losses(film: &Film<3>, counts: &Counts, width: usize) -> Vec<String> {
    // A black image has a warning of its own, whatever made it.
    let of_chains = counts.chains().warnings().into_iter().filter(|warning| warning.kind != WarningKind::Black);
    let mut warnings: Vec<_> = of_chains.map(|warning| warning.to_string()).collect();
    let pixels_of = |sites: &[usize]| named(sites.iter().map(|site| format!("({}, {})", site % width, site / width)));
    let lost = film.lost();
    if lost.count > 0 {
        let sites: Vec<_> = lost.sites.iter().map(|&site| site as usize).collect();
        let pixels = pixels_of(&sites);
        warnings.push(format!("{} contributions were not finite; they are left out: look there for materials and lights of extreme values (in {pixels})", lost.count));
    }
    let clipped = clipped(film);
    if !clipped.is_empty() {
        let pixels = pixels_of(&clipped);
        warnings.push(format!(
            "{} pixels are brighter than the film can hold: their values or errors are clipped; make the lamps seen there weaker ({pixels})",
            clipped.len()
        ));
    }
    warnings
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
    use mlt_core::engine::{MutationStats, Sink, Splat, StratumStats, Tally};
    use mlt_core::transport::methods::SampleTally;

    use super::*;

    #[test]
    fn places_are_named() {
        let lens = |non_finite| MutationStats { non_finite, ..MutationStats::default() };
        let stratum = |n| StratumStats { mutations: vec![lens(0), lens(n)], ..StratumStats::default() };
        let refused = StratumStats { refused_starts: 2, ..stratum(1) };
        let strata = [0, 3, 1, 1, 1, 1].map(stratum).into_iter().chain([refused]).collect();
        let chains = Tally { strata, mutations: vec!["bidirectional".into(), "lens".into()] };
        let counts = Counts::new(SampleTally::default(), chains);
        let warnings = losses(&Film::new(4, 1.0), &counts, 2);
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings[0].starts_with("8 paths, made by lens"), "{warnings:?}");
        assert!(warnings[0].ends_with("(strata 1, 2, 3, 4 and 2 more)"), "{warnings:?}");
        assert!(warnings[1].starts_with("2 chains") && warnings[1].ends_with("(stratum 6)"), "{warnings:?}");
    }

    #[test]
    fn pixels_out_of_range_are_named() {
        let mut film = Film::<3>::new(4, 1.0);
        for value in [1e15, 3e15] {
            let mut deposits = film.deposits();
            deposits.deposit(Splat { site: 3, value: [value; 3] }, 1.0);
            film.add(&mut [deposits]);
            film.close_round(film.rounds(), 1);
        }
        let warnings = losses(&film, &Counts::default(), 2);
        assert!(warnings.len() == 1 && warnings[0].ends_with("weaker ((1, 1))"), "{warnings:?}");
        assert!(losses(&Film::new(4, 1.0), &Counts::default(), 2).is_empty());
    }

    #[test]
    fn what_is_not_finite_is_named_by_pixel() {
        let mut film = Film::<3>::new(6, 1.0);
        let mut deposits = film.deposits();
        for site in [4, 1, 4] {
            deposits.deposit(Splat { site, value: [f64::NAN, 1.0, 1.0] }, 1.0);
        }
        film.add(&mut [deposits]);
        let warnings = losses(&film, &Counts::default(), 3);
        assert_eq!(
            warnings,
            [
                "3 contributions were not finite; they are left out: look there for materials and lights of extreme values (in (1, 0), (1, 1))"
            ]
        );
    }
}
