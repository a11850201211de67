//! `mlt verify`: can this image be trusted?
//!
//! Many short, independent renders of a method and of one that it shares little code with, and what can be told from them.
//! See docs/verify.md.

mod advice;
pub mod bias;
pub mod chains;
pub mod choice;
pub mod errors;
pub mod evidence;
pub mod fault;
mod gallery;
pub mod study;
pub mod verdict;
mod warnings;
mod words;

use std::path::Path;

use anyhow::Context;

use crate::{
    Failure,
    args::{contestant::Contestant, scene::SceneOptions, verify::VerifyOptions},
    interrupt::Interrupt,
    print,
};
use evidence::Evidence;
use study::{Effort, Reference, Subject, reference_for};
use verdict::{Names, Status, Verdict, judge};

/// Judges methods on scenes, and says what came out.
pub fn run(options: &VerifyOptions) -> Result<(), Failure> {
    let threads = options.threads.map_or(0, std::num::NonZeroUsize::get);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start the threads")?;
    if options.choice {
        return pool.install(|| choice::run(options));
    }
    let court = Court::new(options)?;
    let scenes = if options.gallery { gallery::scenes(options)? } else { Vec::new() };
    let verdicts = pool.install(|| match &options.output {
        Some(folder) if options.gallery => gallery::run(&court, options, &scenes, folder),
        _ => {
            let judged =
                options.scenes.iter().map(|scene| court.judge(scene, &court.reading, &|_| None, &mut |_, _| Ok(())));
            judged.collect::<Result<Vec<_>, _>>().map(|verdicts| verdicts.concat())
        }
    })?;
    if options.json {
        print(&(serde_json::to_string_pretty(&verdicts).context("cannot encode the verdicts")? + "\n"))?;
    }
    match verdicts.iter().filter(|verdict| verdict.status != Status::Passes).count() {
        0 => Ok(()),
        1 if verdicts.len() == 1 => Err(Failure::Run(anyhow::anyhow!(verdicts[0].sentence()))),
        n => Err(Failure::Run(anyhow::anyhow!("{n} of {} cannot be trusted as they are", verdicts.len()))),
    }
}

/// The methods to judge, and how.
#[derive(Debug)]
pub struct Court {
    methods: Vec<Contestant>,
    against: Contestant,
    reading: SceneOptions,
    effort: Effort,
    /// Everything besides scene and method that decides a verdict, in words.
    identity: String,
    detect: f64,
    silent: bool,
    interrupt: Interrupt,
}

/// Looks a verdict up.
type Kept<'a> = dyn Fn(&Contestant) -> Option<Verdict> + 'a;
/// Keeps a verdict, and may change it.
type Keep<'a> = dyn FnMut(&Contestant, &mut Verdict) -> Result<(), Failure> + 'a;

impl Court {
    fn new(options: &VerifyOptions) -> Result<Self, Failure> {
        let methods = match (&options.methods[..], options.gallery) {
            ([], true) => gallery::all_methods()?,
            ([], false) => vec![Contestant::default()],
            (given, _) => given.to_vec(),
        };
        let VerifyOptions { size, replicas, per_pixel, rounds, seed, .. } = *options;
        let effort = Effort { size, replicas, per_pixel, rounds, seed };
        let facts = vec![effort.identity(), format!("compared with {}", options.against)];
        Ok(Self {
            methods,
            against: options.against.clone(),
            reading: options.reading.clone(),
            effort,
            identity: [facts, options.reading.words()?].concat().join(", "),
            detect: options.detect,
            silent: options.quiet || options.json,
            interrupt: Interrupt::install()?,
        })
    }

    /// Judges each method on a scene, but for those whose verdicts were kept.
    fn judge(
        &self,
        scene: &Path,
        reading: &SceneOptions,
        kept: &Kept,
        keep: &mut Keep,
    ) -> Result<Vec<Verdict>, Failure> {
        let found: Vec<_> = self.methods.iter().map(kept).collect();
        if found.iter().all(Option::is_some) {
            return Ok(found.into_iter().flatten().collect());
        }
        let subject = Subject::load(scene, reading, self.effort)?;
        let mut references: Vec<(Contestant, Reference)> = Vec::new();
        let mut verdicts = Vec::new();
        for (method, found) in self.methods.iter().zip(found) {
            if let Some(verdict) = found {
                verdicts.push(verdict);
                continue;
            }
            let by = reference_for(method, scene, &self.against)?;
            if !references.iter().any(|(contestant, _)| *contestant == by) {
                references.push((by.clone(), subject.reference(&by, &self.interrupt)?));
            }
            let reference =
                references.iter().find(|(contestant, _)| *contestant == by).map(|(_, reference)| reference.clone());
            let Reference { replicas, groups } = reference.context("the reference was not made")?;
            let (made, moved) = subject.replicas(method, &self.interrupt)?;
            let evidence = Evidence { size: subject.size(), method: made, reference: replicas, groups };
            let names =
                Names { scene: scene.display().to_string(), method: method.to_string(), reference: by.to_string() };
            let mut verdict = judge(names, &evidence, self.detect, Some(moved));
            keep(method, &mut verdict)?;
            self.say(&verdict)?;
            verdicts.push(verdict);
        }
        Ok(verdicts)
    }

    /// The text goes out as it comes; JSON is printed once, at the end.
    fn say(&self, verdict: &Verdict) -> anyhow::Result<()> {
        if self.silent { Ok(()) } else { print(&verdict.text()) }
    }
}
