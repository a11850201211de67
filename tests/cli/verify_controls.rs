//! Every check of `mlt verify` passes on what is right and fails on what is made wrong on purpose.

use std::{path::PathBuf, sync::LazyLock};

use mlt_cli::{
    args::scene::SceneOptions,
    interrupt::Interrupt,
    verify::{
        evidence::Evidence,
        study::{Effort, Subject},
        verdict::{Names, Status, Verdict, judge},
    },
};

const SIZE: [usize; 2] = [16, 16];

/// Replicas of a scene of the gallery: 24 of each, small but honest.
fn evidence(scene: &str, method: &str, reference: &str, per_pixel: f64) -> Evidence {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let file = match scene {
        "lights-200" => folder.join("lights-200/lights-200.gltf"),
        name => folder.join("stability").join(name).join("scene.gltf"),
    };
    let size = "16x16".parse().expect("a size");
    let effort = Effort { size, replicas: 24, per_pixel: Some(per_pixel), rounds: Some(8), seed: 1 };
    let subject = Subject::load(&file, &SceneOptions::default(), effort).expect("loaded");
    let interrupt = Interrupt::default();
    let (replicas, _) = subject.replicas(&method.parse().expect("a method"), &interrupt).expect("rendered");
    let reference = subject.reference(&reference.parse().expect("a method"), &interrupt).expect("rendered");
    Evidence { size: SIZE, method: replicas, reference: reference.replicas, groups: reference.groups }
}

/// Bidirectional tracing of the plain room, by path tracing: nothing is wrong with it.
static PLAIN: LazyLock<Evidence> = LazyLock::new(|| evidence("plain", "bdpt", "pt", 256.0));
/// Metropolis in the same room, with strata.
static METROPOLIS: LazyLock<Evidence> = LazyLock::new(|| evidence("plain", "mlt:2x2", "bdpt", 256.0));

fn verdict(evidence: &Evidence) -> Verdict {
    let names = Names { scene: "scene".into(), method: "method".into(), reference: "reference".into() };
    judge(names, evidence, 0.05, None)
}

/// The same evidence with every replica changed.
fn changed(evidence: &Evidence, change: impl Fn(usize, &mut mlt_cli::verify::evidence::Replica)) -> Evidence {
    let mut wrong = evidence.clone();
    wrong.method.iter_mut().enumerate().for_each(|(index, replica)| change(index, replica));
    wrong
}

fn assert_fails(evidence: &Evidence, reason: &str) {
    let verdict = verdict(evidence);
    println!("{}", verdict.text());
    assert_eq!(verdict.status, Status::Fails, "{}", verdict.text());
    assert!(verdict.faults.iter().any(|fault| fault.sentence.contains(reason)), "{reason}: {:?}", verdict.faults);
}

#[test]
fn what_is_right_passes() {
    let plain = verdict(&PLAIN);
    println!("{}", plain.text());
    assert_eq!(plain.status, Status::Passes, "{}", plain.text());
    let bias = plain.bias.expect("compared");
    let injected = bias.injected.expect("one per cent is injected");
    assert!(injected.caught && bias.visible < 0.01, "{injected:?}");
}

/// So short a chain leaves bright spots, which the verdict tells of; what it must not find is a wrong image.
#[test]
fn metropolis_is_noisy_and_right() {
    let verdict = verdict(&METROPOLIS);
    println!("{}", verdict.text());
    let noisy = |word: &str| ["unsteady", "bars"].contains(&word);
    assert!(verdict.faults.iter().all(|fault| noisy(&fault.word)), "{}", verdict.text());
}

/// A mutation that is not balanced visits one side of the image more often than the other, at the same mean.
#[test]
fn an_unbalanced_mutation_is_found() {
    let wrong = changed(&PLAIN, |_, replica| {
        for (pixel, x) in replica.pixels.iter_mut().enumerate() {
            *x *= if pixel % SIZE[0] < SIZE[0] / 2 { 1.02 } else { 0.98 };
        }
    });
    assert_fails(&wrong, "differs from the reference");
}

#[test]
fn a_wrong_b_is_found() {
    for factor in [0.99, 1.01] {
        let wrong = changed(&PLAIN, |_, replica| replica.pixels.iter_mut().for_each(|x| *x *= factor));
        assert_fails(&wrong, "differs from the reference");
    }
}

/// Some of the lights are left out.
#[test]
fn a_dropped_stratum_is_found() {
    let right = evidence("lights-200", "bdpt", "bdpt", 256.0);
    assert_ne!(verdict(&right).status, Status::Fails, "{}", verdict(&right).text());
    let weight = |pixels: &[f64]| pixels.iter().sum::<f64>();
    let middle = &right.groups[6].pixels;
    let share = weight(middle) / right.groups.iter().map(|group| weight(&group.pixels)).sum::<f64>();
    println!("dropped: {share:.3} of the light");
    let wrong = changed(&right, |_, replica| replica.pixels.iter_mut().zip(middle).for_each(|(x, part)| *x -= part));
    assert_fails(&wrong, "differs from the reference");
}

/// A generator whose streams are the same for several seeds.
#[test]
fn equal_seeds_are_found() {
    let first = PLAIN.method[0].clone();
    assert_fails(
        &changed(&PLAIN, |index, replica| {
            if index % 8 == 0 {
                *replica = first.clone()
            }
        }),
        "repeat another's",
    );
}

/// A generator whose streams are the same in each round of a render.
#[test]
fn correlated_rounds_are_found() {
    let wrong = changed(&PLAIN, |_, replica| {
        let first = replica.rounds[0].clone();
        for round in &mut replica.rounds[1..] {
            round.iter_mut().zip(&first).for_each(|(x, first)| *x = 0.5 * (*x + first));
        }
    });
    assert_fails(&wrong, "rounds of a replica agree more than replicas do");
}

#[test]
fn error_bars_that_are_too_short_are_found() {
    let wrong = changed(&PLAIN, |_, replica| replica.stderr.iter_mut().for_each(|x| *x *= 0.6));
    assert_fails(&wrong, "95 % error bars hold the truth in");
}

#[test]
fn an_error_of_b_that_is_understated_is_found() {
    let wrong = changed(&METROPOLIS, |_, replica| replica.strata.iter_mut().for_each(|s| s.b_stderr *= 0.4));
    assert_fails(&wrong, "a stratum's b scatters");
}

/// A deposit without bound in one seed's image.
#[test]
fn an_unsteady_method_is_found() {
    let wrong = changed(&PLAIN, |index, replica| {
        if index == 5 {
            replica.pixels[40] += 3.0;
        }
    });
    assert_fails(&wrong, "the worst seed's error");
}

/// Few and noisy replicas are no proof of anything.
#[test]
fn noise_is_not_trusted() {
    let verdict = verdict(&evidence("islands", "bdpt", "pt", 8.0));
    assert_ne!(verdict.status, Status::Passes, "{}", verdict.text());
    let black = changed(&PLAIN, |_, replica| replica.pixels.iter_mut().for_each(|x| *x = 0.0));
    assert_eq!(self::verdict(&black).status, Status::Fails);
}
