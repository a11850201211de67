//! A quick version of the study: no method shows another mean image than the reference, but where that is known.

use std::path::Path;

use mlt_cli::{
    interrupt::Interrupt,
    verify::{
        evidence::Evidence,
        study::{Effort, Subject, reference_for},
        verdict::{Names, Verdict, judge},
    },
};
use mlt_scene::gallery::{Outcome, SCENES};

const METHODS: [&str; 4] = ["mlt", "bdpt", "pt", "mmlt"];

/// Scenes that no method without strata sees all of, in so short a time: the reference adds its lights up one by one.
const KNOWN: [&str; 1] = ["tiny-and-huge"];

fn verdicts(file: &Path) -> Vec<Verdict> {
    let size = "16x16".parse().expect("a size");
    let effort = Effort { size, replicas: 12, per_pixel: 16.0, rounds: 4, seed: 1 };
    let (subject, interrupt) = (Subject::load(file, effort).expect("loaded"), Interrupt::default());
    let judged = |method: &&str| {
        let variant = method.parse().expect("a method");
        let by = reference_for(&variant, file, &"bdpt".parse().expect("a method")).expect("another");
        let (made, _) = subject.replicas(&variant, &interrupt).expect("rendered");
        let reference = subject.reference(&by, &interrupt).expect("rendered");
        let evidence =
            Evidence { size: [16, 16], method: made, reference: reference.replicas, groups: reference.groups };
        let names = Names { scene: file.display().to_string(), method: method.to_string(), reference: by.to_string() };
        judge(names, &evidence, 0.01, None)
    };
    METHODS.iter().map(judged).collect()
}

fn differs(verdict: &Verdict) -> bool {
    verdict.faults.iter().any(|fault| fault.word == "wrong")
}

#[test]
fn no_scene_shows_a_bias_but_the_known() {
    let folder = tempfile::tempdir().expect("a folder");
    for scene in SCENES.iter().filter(|scene| scene.outcome != Outcome::Refused) {
        let file = scene.write(folder.path()).expect("written");
        for verdict in verdicts(&file) {
            println!("{} × {}: {:?} {}", scene.name, verdict.method, verdict.status, verdict.reasons());
            assert_eq!(differs(&verdict), KNOWN.contains(&scene.name), "{}", verdict.text());
            assert_eq!(verdict.bias.is_none(), scene.outcome == Outcome::Black, "{}", verdict.text());
        }
    }
}
