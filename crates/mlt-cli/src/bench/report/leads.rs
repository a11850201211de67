//! Who is ahead in each scene, and by how much.

use super::{
    super::{
        chart::{self, significant},
        statistics::{self, Verdict, median},
        summary::{Curve, ranking},
    },
    tables::{figure, interval},
};

/// The method that leaves the least error in a scene, and the next one.
pub(super) struct Lead {
    /// The scene.
    pub scene: String,
    /// The work that all methods were given.
    pub budget: String,
    /// The method.
    pub name: String,
    /// The class that colours it.
    pub method: &'static str,
    /// Its median relMSE.
    pub error: String,
    /// The next one's name; empty where there is no other.
    pub next: String,
    /// The next one's relMSE over this one's.
    pub factor: String,
    /// The factor's 95 % confidence interval; empty if unknown.
    pub interval: String,
    /// The meaning of that.
    pub verdict: &'static str,
}

/// The lead in a scene, at the largest budget that any method has runs of.
pub(super) fn lead(scene: &str, curves: &[Curve]) -> Lead {
    let ranked = ranking(curves);
    let first = ranked[0];
    let mut lead = Lead {
        scene: scene.to_owned(),
        budget: first.last().budget.to_string(),
        name: first.name.to_owned(),
        method: chart::class(first.method),
        error: figure(first.last(), |row| row.errors.rel_mse),
        next: String::new(),
        factor: String::new(),
        interval: String::new(),
        verdict: "alone",
    };
    if let Some(next) = ranked.get(1) {
        let factor = statistics::ratio(&next.last().errors(), &first.last().errors(), median);
        lead.next = next.name.to_owned();
        lead.factor = significant(factor.value);
        lead.interval = interval(factor.interval);
        lead.verdict = match (factor.verdict(), factor.interval) {
            (Verdict::Greater, _) => "ahead",
            (_, Some(_)) => "not decided",
            (_, None) => "too few seeds to tell",
        };
    }
    lead
}

#[cfg(test)]
mod tests {
    use super::{
        super::super::{row::tests::row, study::Study, summary::curves},
        *,
    };
    use crate::args::bench::Budget;

    /// relMSE of so many seeds of two methods.
    fn lead_of(mlt: &[f64], pt: &[f64]) -> Lead {
        let methods = ["mlt", "pt"].map(|text| text.parse().expect("valid")).to_vec();
        let study = Study { scenes: vec![], methods, budgets: vec![Budget::PerPixel(8.0)], seeds: 4, truths: vec![] };
        let of =
            |method, errors: &[f64]| -> Vec<_> { (1..).zip(errors).map(|(seed, e)| row(method, seed, *e)).collect() };
        let rows = [of("mlt", mlt), of("pt", pt)].concat();
        lead("room", &curves(&study, &rows, &rows[0].key.scene))
    }

    #[test]
    fn the_least_error_leads_by_what_the_interval_says() {
        let clear = lead_of(&[0.1, 0.11, 0.12, 0.13], &[0.01, 0.011, 0.012, 0.013]);
        assert_eq!((&*clear.name, &*clear.next, clear.verdict, &*clear.factor), ("pt", "mlt", "ahead", "10.0"));
        let open = lead_of(&[0.1, 0.2, 0.3, 0.1], &[0.1, 0.3, 0.2, 0.2]);
        assert_eq!((open.verdict, open.interval.is_empty()), ("not decided", false));
        assert_eq!(lead_of(&[0.1], &[0.2]).verdict, "too few seeds to tell");
        assert_eq!(lead_of(&[], &[0.2]).verdict, "alone");
    }
}
