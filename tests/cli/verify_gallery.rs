//! A quick version of the study: no method shows another mean image than the reference.

use std::path::Path;

use mlt_cli::{
    args::scene::SceneOptions,
    interrupt::Interrupt,
    verify::{
        evidence::Evidence,
        study::{Effort, Subject, reference_for},
        verdict::{Names, Verdict, judge},
    },
};
use mlt_scene::gallery::{RightOutcome, SCENES, find};

const EFFORT: (u64, f64, u64) = (12, 32.0, 4);
const METHODS: [&str; 5] = ["auto", "mlt", "bdpt", "pt", "mmlt"];

fn subject(file: &Path, seed: u64, factor: f64) -> Subject {
    let (size, (replicas, per_pixel, rounds)) = ("16x16".parse().expect("a size"), EFFORT);
    Subject::load(
        file,
        &SceneOptions::default(),
        Effort { size, replicas, per_pixel: Some(factor * per_pixel), rounds: Some(rounds), seed },
    )
    .expect("loaded")
}

fn verdicts(file: &Path) -> Vec<Verdict> {
    let (subject, interrupt) = (subject(file, 1, 1.0), Interrupt::default());
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
fn no_scene_shows_a_bias() {
    let folder = tempfile::tempdir().expect("a folder");
    for scene in SCENES.iter().filter(|scene| scene.outcome != RightOutcome::Refused) {
        let file = scene.write(folder.path()).expect("written");
        for verdict in verdicts(&file) {
            println!("{} × {}: {:?} {}", scene.name, verdict.method, verdict.status, verdict.reasons());
            assert!(!differs(&verdict), "{}", verdict.text());
            assert_eq!(verdict.bias.is_none(), scene.outcome == RightOutcome::Black, "{}", verdict.text());
        }
    }
}

/// Pixels of replicas of bidirectional tracing, and the means by each group of lights.
fn bidirectional(scene: &str, seed: u64) -> Evidence {
    let folder = tempfile::tempdir().expect("a folder");
    let file = find(scene).expect("in the gallery").write(folder.path()).expect("written");
    let (subject, interrupt, method) =
        (subject(&file, seed, 16.0), Interrupt::default(), "bdpt".parse().expect("a method"));
    let (made, _) = subject.replicas(&method, &interrupt).expect("rendered");
    let reference = subject.reference(&method, &interrupt).expect("rendered");
    Evidence { size: [16, 16], method: made, reference: reference.replicas, groups: reference.groups }
}

fn compared(method: &Evidence, reference: Vec<Vec<f64>>) -> Verdict {
    let names = Names { scene: String::new(), method: "bdpt".into(), reference: "the truth".into() };
    judge(names, &Evidence { reference, ..method.clone() }, 0.05, None)
}

/// Other units, another place, and careless triangles: the image of the plain scene. A box less is another image.
#[test]
fn distorted_controls_show_the_control() {
    let plain: Vec<Vec<f64>> = bidirectional("plain", 1000).method.into_iter().map(|r| r.pixels).collect();
    for (index, scene) in ["scale-small", "scale-large", "offset", "broken"].into_iter().enumerate() {
        let verdict = compared(&bidirectional(scene, 100 * index as u64), plain.clone());
        assert!(!differs(&verdict), "{scene}: {}", verdict.text());
    }
    assert!(differs(&compared(&bidirectional("touching", 900), plain)));
}

/// Both keyholes give the same: an image and its mirror image agree, and one with a darker half does not.
#[test]
fn the_islands_shine_alike() {
    let evidence = bidirectional("islands", 1);
    let mirrored = |half: f64| -> Vec<Vec<f64>> {
        let rows = |image: &Vec<f64>| {
            image
                .chunks(16)
                .flat_map(|row| row.iter().rev().zip(0..).map(|(x, i)| if i < 8 { x * half } else { *x }))
                .collect()
        };
        bidirectional("islands", 500).method.iter().map(|replica| rows(&replica.pixels)).collect()
    };
    assert!(!differs(&compared(&evidence, mirrored(1.0))));
    assert!(differs(&compared(&evidence, mirrored(0.0))));
}

/// The sealed lamp, a million times as strong as the other, adds nothing.
#[test]
fn a_sealed_lamp_is_dark() {
    let groups = bidirectional("occluded", 1).groups;
    let light = |name: &str| -> f64 {
        groups.iter().find(|group| group.name == name).expect("a group of lights").pixels.iter().sum()
    };
    assert_eq!(light("sealed"), 0.0);
    assert!(light("faint") > 0.0);
}
