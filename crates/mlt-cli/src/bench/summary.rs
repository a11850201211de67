//! Rows gathered into curves: a scene, a method, error over budget.

use super::{
    axis::Axis,
    row::Row,
    statistics::{Crossing, crossing, log_log_slope, mean_of, median_of},
    study::Study,
};
use crate::args::{bench::Budget, contestant::Contestant};

/// Runs that differ in the seed alone; never empty.
#[derive(Clone, Debug)]
pub(super) struct Point<'a> {
    /// The work that each was given.
    pub budget: Budget,
    /// In the order of the seeds.
    pub rows: Vec<&'a Row>,
}

impl Point<'_> {
    /// A figure of each run.
    pub(super) fn values(&self, figure: impl Fn(&Row) -> f64) -> Vec<f64> {
        self.rows.iter().map(|row| figure(row)).collect()
    }

    /// Median over the seeds.
    pub(super) fn median(&self, figure: impl Fn(&Row) -> f64) -> f64 {
        median_of(self.values(figure).into_iter())
    }

    /// Mean over the seeds of a figure that some runs do not have; `None` if none has it.
    pub(super) fn mean(&self, figure: impl Fn(&Row) -> Option<f64>) -> Option<f64> {
        let mean = mean_of(self.rows.iter().filter_map(|row| figure(row)));
        mean.is_finite().then_some(mean)
    }

    /// relMSE of each run.
    pub(super) fn errors(&self) -> Vec<f64> {
        self.values(|row| row.errors.rel_mse)
    }

    /// Whether any of the runs missed the budget.
    pub(super) fn missed(&self) -> bool {
        self.rows.iter().any(|row| row.missed(&self.budget).is_some())
    }

    /// Largest relMSE over the median one; `None` for exact images.
    pub(super) fn worst_over_median(&self) -> Option<f64> {
        let ratio = self.errors().into_iter().fold(0.0, f64::max) / self.median(|row| row.errors.rel_mse);
        ratio.is_finite().then_some(ratio)
    }
}

/// A method on a scene: a point a budget, rising; never empty.
#[derive(Clone, Debug)]
pub(super) struct Curve<'a> {
    /// Index of the method in the study.
    pub method: usize,
    /// As named on the command line.
    pub name: &'a str,
    /// Budgets that have a run.
    pub points: Vec<Point<'a>>,
}

impl Curve<'_> {
    /// The point of the largest budget.
    pub(super) fn last(&self) -> &Point<'_> {
        &self.points[self.points.len() - 1]
    }

    /// Medians of abscissa and relMSE, of points with an error above zero.
    pub(super) fn medians(&self, axis: Axis) -> Vec<(f64, f64)> {
        let median = |point: &Point| (point.median(|row| axis.of(row)), point.median(|row| row.errors.rel_mse));
        self.points.iter().map(median).filter(|(x, y)| *x > 0.0 && *y > 0.0).collect()
    }

    /// Exponent of the error's fall: −1 for independent samples. `None` from fewer than three points, whose line says nothing of how far
    /// it is from them.
    pub(super) fn slope(&self, axis: Axis) -> Option<f64> {
        let medians = self.medians(axis);
        if medians.len() < 3 { None } else { log_log_slope(&medians) }
    }

    /// Where the median error reaches a target.
    pub(super) fn reaches(&self, axis: Axis, target: f64) -> Option<Crossing> {
        crossing(&self.medians(axis), target)
    }
}

/// All curves of a scene, in the order of the methods.
pub(super) fn curves<'a>(study: &Study, rows: &'a [Row], scene: &str) -> Vec<Curve<'a>> {
    let of_method = |(method, contestant): (usize, &Contestant)| {
        let text = contestant.to_string();
        let mine = || rows.iter().filter(|row| row.key.scene == scene && row.key.method == text);
        let of_budget = |&budget: &Budget| {
            let name = budget.to_string();
            let rows: Vec<&Row> = mine().filter(|row| row.key.budget == name).collect();
            (!rows.is_empty()).then_some(Point { budget, rows })
        };
        let points: Vec<Point> = study.budgets.iter().filter_map(of_budget).collect();
        let name = &mine().next()?.key.method;
        Some(Curve { method, name, points })
    };
    study.methods.iter().enumerate().filter_map(of_method).collect()
}

/// The curves that reach as far as any, least median error at their ends first.
pub(super) fn ranking<'c, 'a>(curves: &'c [Curve<'a>]) -> Vec<&'c Curve<'a>> {
    let amount = |curve: &Curve| curve.last().budget.amount();
    let largest = curves.iter().map(amount).fold(0.0, f64::max);
    let mut ranked: Vec<_> = curves.iter().filter(|curve| amount(curve) == largest).collect();
    let error = |curve: &Curve| curve.last().median(|row| row.errors.rel_mse);
    ranked.sort_by(|a, b| error(a).total_cmp(&error(b)));
    ranked
}

/// The error to compare times at: the geometric mean of the medians that the methods end with.
pub(super) fn usual_target(curves: &[Curve]) -> Option<f64> {
    let ends = curves.iter().map(|curve| curve.last().median(|row| row.errors.rel_mse)).filter(|error| *error > 0.0);
    let target = mean_of(ends.map(f64::ln)).exp();
    target.is_finite().then_some(target)
}

#[cfg(test)]
mod tests {
    use super::{super::row::tests::row, *};

    #[test]
    fn rows_become_curves() {
        let methods = ["mlt", "pt"].map(|text| text.parse().expect("valid")).to_vec();
        let budgets = vec![Budget::PerPixel(8.0), Budget::PerPixel(16.0)];
        let study = Study { scenes: vec![], methods, budgets, seeds: 3, truths: vec![] };
        let rows = [row("pt", 1, 0.5), row("pt", 2, 0.2), row("pt", 3, 0.3)];
        let scene = rows[0].key.scene.clone();
        let found = curves(&study, &rows, &scene);
        assert_eq!((found.len(), found[0].method, found[0].points.len()), (1, 1, 1));
        assert_eq!(found[0].last().errors(), [0.5, 0.2, 0.3]);
        assert!((found[0].last().worst_over_median().expect("known") - 5.0 / 3.0).abs() < 1e-12);
        assert_eq!(found[0].medians(Axis::Rays), [(100.0, 0.3)]);
        assert_eq!(found[0].slope(Axis::Rays), None);
        assert!((usual_target(&found).expect("known") - 0.3).abs() < 1e-12);
        assert!(curves(&study, &rows, "other").is_empty());
    }

    /// A method that was interrupted before the largest budget is not compared, however small its error.
    #[test]
    fn curves_are_ranked_by_what_they_end_with() {
        let methods = ["mlt", "pt", "bdpt"].map(|text| text.parse().expect("valid")).to_vec();
        let budgets = [4.0, 8.0].map(Budget::PerPixel).to_vec();
        let study = Study { scenes: vec![], methods, budgets, seeds: 1, truths: vec![] };
        let mut rows = [row("mlt", 1, 0.3), row("pt", 1, 0.2), row("bdpt", 1, 0.1)];
        rows[2].key.budget = "4 per pixel".into();
        let scene = rows[0].key.scene.clone();
        let found = curves(&study, &rows, &scene);
        assert_eq!(ranking(&found).iter().map(|curve| curve.name).collect::<Vec<_>>(), ["pt", "mlt"]);
    }

    #[test]
    fn a_slope_needs_three_points() {
        let budgets = [2.0, 4.0, 8.0].map(Budget::PerPixel);
        let study = Study {
            scenes: vec![],
            methods: vec!["pt".parse().expect("valid")],
            budgets: budgets.to_vec(),
            seeds: 1,
            truths: vec![],
        };
        let rows: Vec<Row> = budgets
            .iter()
            .map(|budget| {
                let mut row = row("pt", 1, 1.0 / budget.amount());
                (row.key.budget, row.rays) = (budget.to_string(), budget.amount() as u64);
                row
            })
            .collect();
        let slope = |rows: &[Row]| curves(&study, rows, &rows[0].key.scene)[0].slope(Axis::Rays);
        assert!((slope(&rows).expect("three points") + 1.0).abs() < 1e-12);
        assert_eq!(slope(&rows[..2]), None);
    }
}
