//! The default method: chains get what the plan promises them, and no seed draws a blank.

use std::process::Command;

use super::support::render;

/// A plan that priced one sample of eight branches at more than a round's work left sixteen mutations to chains that had been
/// promised two fifths of it; the dearest of equal candidates had been taken.
#[test]
fn chains_get_what_the_plan_promises() {
    let file = "../../../scenes/stability/pool/scene.gltf";
    for seed in [0, 9] {
        let report = render(file, &format!("--size 64x64 --seed {seed}")).report;
        let number = |name: &str| report[name].as_f64().expect(name);
        let planned = report["decision"]["chain_share"].as_f64().expect("a share");
        let found = number("chain_rays") / number("rays");
        assert!(planned > 0.2 && found > 0.5 * planned, "seed {seed}: {found} of {planned}");
    }
}

/// The law of the choice in small: where light comes through a gap, and where it is easy.
#[test]
fn no_seed_is_much_worse_than_a_single_method() {
    let output = Command::new(env!("CARGO_BIN_EXE_mlt"))
        .args(["verify", "--choice", "door-ajar", "cornell", "--size", "64x64", "--budgets", "64", "--replicas", "4"])
        .output()
        .expect("mlt starts");
    let [table, message] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{message}{table}");
    assert_eq!(table.matches("| holds |").count(), 2, "{table}");
}
