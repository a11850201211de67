//! Whether the choice that `auto` makes is safe: it keeps to its budget and to its plan, and no seed is much worse than the best
//! single method with as many rays.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, anyhow};
use mlt_core::transport::methods::auto::TIME_OF_A_CHAINS_RAY;
use mlt_scene::gallery::find;
use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{DiscreteCDF, Hypergeometric};

use super::{errors::rel_mse, evidence::pixels};
use crate::{
    Failure,
    args::{contestant::Contestant, render::RenderOptions, verify::VerifyOptions},
    bench::statistics::{mean_of, median_of},
    interrupt::Interrupt,
    print,
    render::{self, Setup},
    report::Report,
};

/// Scenes of easy and of hard light.
const SCENES: [&str; 7] = ["cornell", "ring", "lights-200", "door-ajar", "islands", "caustic", "pool"];
/// Methods that the choice is measured by.
const SINGLE: [&str; 3] = ["pt", "bdpt", "mlt"];
/// Rays over those of path tracing with as many samples, at least and at most.
const WORK: [f64; 2] = [0.5, 1.5];
/// The chains' share of the work over the planned one, at most, and one over it at least.
const SHARE: f64 = 2.0;
/// Shares of the work that are too small to be held to that.
const SMALL_SHARE: f64 = 0.05;
/// Error of a seed over the best method's median that is too much. The seeds of a good method may leave so much too, where it
/// samples something rare: what counts is whether `auto` does so more often.
const ERROR: f64 = 3.0;
/// Error of a seed over that, and over the best method's worst seed, that no chance explains.
const RUIN: f64 = 10.0;
/// Probability of as many bad seeds or more, if `auto` and the best method have the same law, below which they have not.
const SIGNIFICANCE: f64 = 0.05;
/// Work of the image that is taken for true, in largest budgets.
const TRUTH: f64 = 32.0;
/// Seed of that.
const SEED_OF_TRUTH: u64 = 1 << 32;

/// Renders of one method with one budget.
struct Runs {
    /// Pixels by seed.
    images: Vec<Vec<f64>>,
    reports: Vec<Report>,
}

/// Figures of one scene and budget.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The scene as it was named.
    pub scene: String,
    /// Samples a pixel.
    pub budget: f64,
    /// Rays over those of path tracing, by seed.
    pub work: Vec<f64>,
    /// The chains' share of the work, and the planned one, by seed.
    pub shares: Vec<[f64; 2]>,
    /// relMSE of `auto` by seed.
    pub errors: Vec<f64>,
    /// The best single method.
    pub best: &'static str,
    /// relMSE of it, by seed.
    pub best_errors: Vec<f64>,
}

impl Row {
    /// The faults, in words; empty if there is none.
    pub fn faults(&self) -> Vec<String> {
        let all = self.errors.len();
        let seeds = |count: usize, text: &str| (count > 0).then(|| format!("{count} of {all} seeds {text}"));
        let off = |[found, planned]: &&[f64; 2]| {
            found.max(*planned) > SMALL_SHARE && (found / planned).max(planned / found) > SHARE
        };
        let most = ERROR * median_of(self.best_errors.iter().copied());
        let bad = |errors: &[f64]| errors.iter().filter(|error| **error > most).count() as u64;
        let [found, own] = [&self.errors, &self.best_errors].map(|errors| [bad(errors), errors.len() as u64]);
        let too_many = if p_of_more(found, own) < SIGNIFICANCE { found[0] as usize } else { 0 };
        let ruin = RUIN * largest(&self.best_errors).max(most);
        let ruined = self.errors.iter().filter(|error| **error > ruin).count();
        let work = self.work.iter().filter(|work| !(WORK[0]..=WORK[1]).contains(*work)).count();
        let shares = self.shares.iter().filter(off).count();
        [
            seeds(work, "miss the budget"),
            seeds(shares, "miss the plan"),
            seeds(too_many, "leave too much error"),
            seeds(ruined, "are ruined"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// A line of a table.
    fn line(&self) -> String {
        let median = |values: &[f64]| median_of(values.iter().copied());
        let least = self.work.iter().copied().fold(f64::INFINITY, f64::min);
        let share = mean_of(self.shares.iter().map(|[found, _]| *found));
        let planned = mean_of(self.shares.iter().map(|[_, planned]| *planned));
        let faults = self.faults();
        format!(
            "| {} | {} | {:.2e} | {:.2e} | {} | {:.2e} | {:.2e} | {least:.2}–{:.2} | {:.0} % of {:.0} % | {} |\n",
            self.scene,
            self.budget,
            median(&self.errors),
            largest(&self.errors),
            self.best,
            median(&self.best_errors),
            largest(&self.best_errors),
            largest(&self.work),
            100.0 * share,
            100.0 * planned,
            if faults.is_empty() { "holds".into() } else { format!("**{}**", faults.join(", ")) },
        )
    }
}

/// Probability that a part of n of all events has k of the bad ones or more by chance, from [k, n] of it and of the others: the
/// hypergeometric law.
///
/// Source: [Fisher22].
fn p_of_more(found: [u64; 2], others: [u64; 2]) -> f64 {
    let (bad, all) = (found[0] + others[0], found[1] + others[1]);
    match Hypergeometric::new(all, bad, found[1]) {
        Ok(law) if found[0] > 0 => law.sf(found[0] - 1),
        _ => 1.0,
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// Studies each scene with each budget, and prints a table.
pub fn run(options: &VerifyOptions) -> Result<(), Failure> {
    let interrupt = Interrupt::install()?;
    if let Some(folder) = &options.output {
        fs::create_dir_all(folder).with_context(|| format!("{}: cannot be created", folder.display()))?;
    }
    let folder = tempfile::tempdir().context("there is no place for temporary files")?;
    let scenes = match &options.scenes[..] {
        [] => SCENES.map(PathBuf::from).to_vec(),
        given => given.to_vec(),
    };
    let silent = options.quiet || options.json;
    if !silent {
        print(&heading(options))?;
    }
    let mut rows = Vec::new();
    for scene in &scenes {
        let study = Study::load(scene, folder.path(), options, &interrupt)?;
        for row in study.rows(&options.budgets)? {
            if !silent {
                print(&row.line())?;
            }
            rows.push(row);
        }
    }
    if options.json {
        print(&(serde_json::to_string_pretty(&rows).context("cannot encode the rows")? + "\n"))?;
    }
    match rows.iter().filter(|row| !row.faults().is_empty()).count() {
        0 => Ok(()),
        n => Err(Failure::Run(anyhow!("auto is not safe in {n} of {} cases", rows.len()))),
    }
}

fn heading(options: &VerifyOptions) -> String {
    format!(
        "{} seeds of {}; relMSE at as many rays; work over that of pt; the chains' share of it, found and planned\n\n\
         | scene | samples a pixel | auto, median | worst | best alone | median | worst | work | chains | the law |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
        options.replicas, options.size
    )
}

/// A scene to study.
#[derive(Debug)]
pub struct Study<'a> {
    name: String,
    file: PathBuf,
    setup: Setup,
    options: &'a VerifyOptions,
    interrupt: &'a Interrupt,
}

impl<'a> Study<'a> {
    /// Loads a scene, which may be one of the gallery's by name; that is written to `folder`.
    pub fn load(
        scene: &Path,
        folder: &Path,
        options: &'a VerifyOptions,
        interrupt: &'a Interrupt,
    ) -> Result<Self, Failure> {
        let name = scene.display().to_string();
        let file = match find(&name) {
            Some(scene) => scene.write(folder).with_context(|| format!("{}: cannot be written", folder.display()))?,
            None => scene.to_owned(),
        };
        let words = [options.reading.words()?, vec![format!("--size={}", options.size)]].concat();
        let setup = Setup::new(&render_options(&Contestant::default(), &file, &words)?)?;
        Ok(Self { name, file, setup, options, interrupt })
    }

    /// One row a budget.
    pub fn rows(&self, budgets: &[f64]) -> Result<Vec<Row>, Failure> {
        let auto: Vec<Runs> = budgets.iter().map(|n| self.runs("auto", *n)).collect::<Result<_, _>>()?;
        let single: Vec<Vec<Runs>> = budgets.iter().map(|n| self.single(*n)).collect::<Result<_, _>>()?;
        // The method whose seeds differ least makes the image that is taken for true.
        let most = (0..budgets.len()).max_by(|&i, &j| budgets[i].total_cmp(&budgets[j])).context("no budget")?;
        let flicker = |runs: &Runs| median_of(runs.images.windows(2).map(|pair| error(&pair[0], &pair[1])));
        let steadiest = (0..SINGLE.len())
            .min_by(|&i, &j| flicker(&single[most][i]).total_cmp(&flicker(&single[most][j])))
            .context("no method")?;
        let units = units(&single[most][steadiest].reports[0]) * TRUTH;
        let truth = self.render(SINGLE[steadiest], units, SEED_OF_TRUTH)?.0;
        let row = |(budget, (auto, single)): (&f64, (&Runs, &Vec<Runs>))| {
            let errors = |runs: &Runs| -> Vec<f64> { runs.images.iter().map(|image| error(&truth, image)).collect() };
            let of_single: Vec<_> = single.iter().map(errors).collect();
            let median = |i: usize| median_of(of_single[i].iter().copied());
            let best = (0..SINGLE.len()).min_by(|&i, &j| median(i).total_cmp(&median(j))).unwrap_or(0);
            let rays = mean_of(single[0].reports.iter().map(|report| report.rays as f64));
            Row {
                scene: self.name.clone(),
                budget: *budget,
                work: auto.reports.iter().map(|report| report.rays as f64 / rays).collect(),
                shares: auto.reports.iter().map(shares).collect(),
                errors: errors(auto),
                best: SINGLE[best],
                best_errors: of_single[best].clone(),
            }
        };
        Ok(budgets.iter().zip(auto.iter().zip(&single)).map(row).collect())
    }

    /// Each single method with about as many rays as path tracing has.
    fn single(&self, budget: f64) -> Result<Vec<Runs>, Failure> {
        let mut all = vec![self.runs(SINGLE[0], budget)?];
        let rays = all[0].reports[0].rays as f64;
        for method in &SINGLE[1..] {
            let (_, trial) = self.render(method, budget.max(4.0), SEED_OF_TRUTH)?;
            all.push(self.runs(method, (units(&trial) * rays / trial.rays as f64).max(1.0))?);
        }
        Ok(all)
    }

    fn runs(&self, method: &str, budget: f64) -> Result<Runs, Failure> {
        let seeds = self.options.seed..self.options.seed + self.options.replicas;
        let made: Result<Vec<_>, Failure> =
            seeds.into_par_iter().map(|seed| self.render(method, budget, seed)).collect();
        let (images, reports) = made?.into_iter().unzip();
        Ok(Runs { images, reports })
    }

    /// Pixels and report of a render with so many samples or mutations a pixel. It goes on from its checkpoint, if there is a folder of these.
    fn render(&self, method: &str, per_pixel: f64, seed: u64) -> Result<(Vec<f64>, Report), Failure> {
        let contestant = method.parse().map_err(|message: String| Failure::Run(anyhow!(message)))?;
        let unit = render_options(&contestant, &self.file, &[])?.method().unit();
        let words = [format!("--seed={seed}"), format!("--{unit}-per-pixel={per_pixel}")];
        let mut options = render_options(&contestant, &self.file, &words)?;
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let name: String = format!("{}-{method}-{per_pixel}-{seed}.mltp", self.name).chars().map(plain).collect();
        options.keeping.checkpoint = self.options.output.as_ref().map(|folder| folder.join(name));
        let rendered = render::in_memory(&options, &self.setup, self.interrupt)?;
        if rendered.report.interrupted {
            return Err(Failure::InterruptedEarly(anyhow!("interrupted")));
        }
        Ok((pixels(&rendered.image), rendered.report))
    }
}

fn render_options(contestant: &Contestant, scene: &Path, words: &[String]) -> Result<RenderOptions, Failure> {
    contestant.render_options(scene, words).map_err(|message| Failure::Run(anyhow!(message)))
}

/// relMSE of `image`.
fn error(truth: &[f64], image: &[f64]) -> f64 {
    rel_mse(truth.iter().copied(), image, mean_of(truth.iter().copied()))
}

/// Mutations or samples a pixel.
fn units(report: &Report) -> f64 {
    let total = if report.mutations > 0 { report.mutations } else { report.samples };
    total as f64 / (report.width * report.height) as f64
}

/// The chains' share of the work, and the planned one.
fn shares(report: &Report) -> [f64; 2] {
    let decision = report.decision.as_ref();
    let chains = TIME_OF_A_CHAINS_RAY * report.chain_rays as f64;
    let samples = (report.rays - report.chain_rays) as f64;
    [chains / (chains + samples), decision.map_or(0.0, |decision| decision.chain_share)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Row {
        Row {
            scene: "room".into(),
            budget: 64.0,
            work: vec![0.9, 1.1, 1.2],
            shares: vec![[0.0, 0.0], [0.5, 0.4], [0.9, 0.95]],
            errors: vec![1.0, 2.0, 3.5],
            best: "mlt",
            best_errors: vec![0.9, 1.0, 4.0],
        }
    }

    #[test]
    fn a_choice_that_keeps_the_law_has_no_fault() {
        assert!(row().faults().is_empty());
        let steady = Row { best_errors: vec![0.9, 1.2, 1.3], ..row() };
        assert!(steady.faults().is_empty());
    }

    /// One bad seed of eight may be chance, also where the best method has none; five of eight are not.
    #[test]
    fn bad_seeds_are_counted_against_those_of_the_best_method() {
        let with = |bad: usize, own: usize| {
            let errors = |bad| (0..8).map(|i| if i < bad { 9.0 } else { 1.0 }).collect::<Vec<_>>();
            Row { errors: errors(bad), best_errors: errors(own), ..row() }.faults()
        };
        assert!(with(1, 0).is_empty() && with(4, 3).is_empty());
        assert_eq!(with(5, 0), ["5 of 8 seeds leave too much error"]);
        // 5 of 8 and none of 8: (8 choose 5)/(16 choose 5).
        assert!((p_of_more([5, 8], [0, 8]) - 56.0 / 4368.0).abs() < 1e-12);
    }

    /// Chains that make a handful of mutations where they were promised nearly all of the work, rays that nobody asked for, and
    /// errors that a single method does not leave.
    #[test]
    fn each_part_of_the_law_can_be_broken() {
        let starved = Row { shares: vec![[1e-5, 0.99]; 3], ..row() };
        assert_eq!(starved.faults(), ["3 of 3 seeds miss the plan"]);
        let late = Row { work: vec![1.0, 1.6, 0.4], ..row() };
        assert_eq!(late.faults(), ["2 of 3 seeds miss the budget"]);
        let unlucky = Row { errors: vec![1.0, 2.0, 50.0], ..row() };
        assert_eq!(unlucky.faults(), ["1 of 3 seeds are ruined"]);
    }
}
