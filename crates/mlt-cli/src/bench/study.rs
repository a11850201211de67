//! Runs of a study: a grid of scenes, methods, budgets and seeds.

use std::path::PathBuf;

use crate::{
    Failure,
    args::{
        bench::{BenchOptions, Budget},
        contestant::Contestant,
    },
};

/// Samples of the reference per pixel in the paper's table.
const PAPER_REFERENCE: f64 = 1280.0;
/// The reference's budget over the largest budget of the runs, unless told otherwise; also the paper's.
const REFERENCE_FACTOR: f64 = 10.0;

/// A grid of runs and how to find the truth.
#[derive(Clone, Debug)]
pub(super) struct Study {
    /// Files or built-in names.
    pub scenes: Vec<PathBuf>,
    /// The methods compared.
    pub methods: Vec<Contestant>,
    /// Budgets, rising.
    pub budgets: Vec<Budget>,
    /// Runs of each, with the seeds 1, 2, ….
    pub seeds: u64,
    /// Where each scene's reference comes from.
    pub truths: Vec<Truth>,
}

/// Where a reference comes from.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Truth {
    /// An image file.
    File(PathBuf),
    /// A render.
    Render(Budget),
}

/// One cell of the grid; indices into the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    /// Index of the scene.
    pub scene: usize,
    /// Index of the budget.
    pub budget: usize,
    /// Index of the method.
    pub method: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Study {
    /// The study that was asked for, or what is wrong with it.
    pub(super) fn new(options: &BenchOptions) -> Result<Self, Failure> {
        let (mut study, truth) = if options.paper { paper(options)? } else { asked(options)? };
        study.budgets.sort_by(|a, b| a.amount().total_cmp(&b.amount()));
        unique("budget", &study.budgets)?;
        unique("method", &study.methods)?;
        unique("scene", &study.scenes)?;
        study.truths = match options.references.len() {
            0 => vec![Truth::Render(truth); study.scenes.len()],
            files if files == study.scenes.len() => options.references.iter().cloned().map(Truth::File).collect(),
            files => {
                let scenes = study.scenes.len();
                return usage(format!("{files} references for {scenes} scenes; give --reference once for each scene"));
            }
        };
        Ok(study)
    }

    /// All runs, seed by seed: a study that is stopped early has few seeds, but of everything, and a machine that
    /// changes its speed changes it for all methods.
    pub(super) fn runs(&self) -> impl Iterator<Item = Run> + '_ {
        let methods =
            move |seed, scene, budget| (0..self.methods.len()).map(move |method| Run { scene, budget, method, seed });
        let budgets = move |seed, scene| (0..self.budgets.len()).flat_map(move |budget| methods(seed, scene, budget));
        (1..=self.seeds).flat_map(move |seed| (0..self.scenes.len()).flat_map(move |scene| budgets(seed, scene)))
    }

    /// Whether the runs end at the same place every time.
    pub(super) fn repeats(&self) -> bool {
        self.budgets.iter().all(Budget::repeats)
    }
}

fn asked(options: &BenchOptions) -> Result<(Study, Budget), Failure> {
    let budgets =
        [&options.times, &options.mutations, &options.rays].into_iter().flatten().copied().collect::<Vec<_>>();
    let largest = budgets.iter().copied().max_by(|a, b| a.amount().total_cmp(&b.amount()));
    let times_ten = match largest {
        Some(Budget::Time(time)) => Budget::Time(time.mul_f64(REFERENCE_FACTOR)),
        Some(Budget::PerPixel(n)) => Budget::PerPixel(n * REFERENCE_FACTOR),
        Some(Budget::Rays(n)) => Budget::Rays(n * REFERENCE_FACTOR),
        None => return usage("no budget given; give --times, --mutations or --rays".into()),
    };
    let (scenes, methods) = (options.scenes.clone(), options.methods.clone());
    let study = Study { scenes, methods, budgets, seeds: options.seeds, truths: Vec::new() };
    Ok((study, reference(options).unwrap_or(times_ten)))
}

/// The reference's budget, if given.
fn reference(options: &BenchOptions) -> Option<Budget> {
    options.reference_time.map(Budget::Time).or(options.reference_samples.map(Budget::PerPixel))
}

/// Section 5 of the paper.
fn paper(options: &BenchOptions) -> Result<(Study, Budget), Failure> {
    let truth = reference(options).unwrap_or(Budget::PerPixel(PAPER_REFERENCE));
    let methods = super::paper::METHODS.iter().map(|text| text.parse()).collect::<Result<_, _>>();
    let methods = methods.map_err(|message: String| Failure::Run(anyhow::anyhow!(message)))?;
    let scenes = super::paper::SCENES.iter().map(|scene| scene.name.into()).collect();
    let budgets = vec![Budget::PerPixel(truth.amount() / REFERENCE_FACTOR)];
    Ok((Study { scenes, methods, budgets, seeds: options.seeds, truths: Vec::new() }, truth))
}

fn unique<T: PartialEq + std::fmt::Debug>(what: &str, values: &[T]) -> Result<(), Failure> {
    match values.iter().enumerate().find(|(index, value)| values[..*index].contains(value)) {
        Some((index, _)) => usage(format!("{what} number {} is given twice", index + 1)),
        None => Ok(()),
    }
}

fn usage<T>(message: String) -> Result<T, Failure> {
    Err(Failure::Usage(anyhow::anyhow!(message)))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: BenchOptions,
    }

    fn study(line: &str) -> Result<Study, String> {
        let words = std::iter::once("mlt").chain(line.split_whitespace());
        let line = Line::try_parse_from(words).map_err(|error| error.to_string())?;
        Study::new(&line.options).map_err(|failure| format!("{failure:?}"))
    }

    #[test]
    fn the_grid_is_complete_and_goes_seed_by_seed() {
        let study = study("cornell ring --methods mlt,pt --seeds 2 --times 3s,1s -o out").expect("valid");
        let runs: Vec<Run> = study.runs().collect();
        assert_eq!(runs.len(), 2 * 2 * 2 * 2);
        assert!(runs[..8].iter().all(|run| run.seed == 1) && runs[8..].iter().all(|run| run.seed == 2));
        assert_eq!(runs[1], Run { scene: 0, budget: 0, method: 1, seed: 1 });
        assert_eq!(study.budgets[0].to_string(), "1 s");
        assert_eq!(study.truths[1], Truth::Render(Budget::Time(std::time::Duration::from_secs(30))));
        assert!(!study.repeats());
    }

    #[test]
    fn references_are_found() {
        let truth = |line: &str| study(line).map(|study| study.truths[0].clone());
        let samples = |n| Ok(Truth::Render(Budget::PerPixel(n)));
        assert_eq!(truth("a --mutations 4,8 -o out"), samples(80.0));
        assert_eq!(truth("a --mutations 8 --reference-samples 99 -o out"), samples(99.0));
        assert_eq!(truth("a --rays 8 -o out"), Ok(Truth::Render(Budget::Rays(80.0))));
        assert_eq!(truth("a --mutations 8 --reference b.exr -o out"), Ok(Truth::File("b.exr".into())));
        assert!(truth("a b --mutations 8 --reference b.exr -o out").is_err_and(|e| e.contains("1 references for 2")));
    }

    #[test]
    fn the_paper_has_its_own_grid() {
        let study = study("--paper --reference-samples 50 -o out").expect("valid");
        assert_eq!((study.scenes.len(), study.methods.len(), study.seeds), (3, 2, 10));
        assert_eq!(study.budgets, [Budget::PerPixel(5.0)]);
    }

    #[test]
    fn contradictions_are_refused() {
        for (line, part) in [
            ("a -o out", "required"),
            ("--times 1s -o out", "required"),
            ("a --times 1s", "--output"),
            ("a --times 1s --rays 3 -o out", "cannot be used with"),
            ("--paper --times 1s -o out", "cannot be used with"),
            ("a --paper -o out", "cannot be used with"),
            ("--paper --methods pt -o out", "cannot be used with"),
            ("a --times 1s --methods pt,pt -o out", "method number 2 is given twice"),
            ("a --times 1s,1000ms -o out", "budget number 2 is given twice"),
            ("a --times 1 -o out", "as in 30s"),
            ("a --mutations 0 -o out", "greater than zero"),
            ("a --mutations 1 --seeds 0 -o out", "--seeds"),
            ("a --mutations 1 --reference b --reference-time 1s -o out", "cannot be used with"),
        ] {
            let message = study(line).expect_err(line);
            assert!(message.contains(part), "{line}: {message}");
        }
    }
}
