//! `mlt verify` from outside.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

fn verify(line: &str, more: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    command.arg("verify").args(line.split_whitespace()).args(more);
    command.output().expect("started")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

#[test]
fn a_method_that_can_be_trusted_gives_zero() {
    let output = verify("cornell --methods pt --replicas 8 --per-pixel 512 --size 8x8 --detect 10% --json", &[]);
    assert!(output.status.success(), "{}", stderr(&output));
    let verdicts: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let verdict = &verdicts[0];
    assert_eq!((&verdict["status"], &verdict["reference"]), (&"passes".into(), &"bdpt".into()), "{verdict:#}");
    for (part, field) in
        [("bias", "p"), ("bias", "visible"), ("chains", "r_hat"), ("errors", "coverage"), ("errors", "moved")]
    {
        assert!(verdict[part][field].is_number(), "{part}.{field}: {verdict:#}");
    }
    assert!(verdict["bias"]["injected"]["caught"].is_boolean() && verdict["errors"]["deciles"].is_array());
}

#[test]
fn what_is_inconclusive_gives_one() {
    let output = verify("cornell --methods bdpt --replicas 4 --per-pixel 8 --size 8x8", &[]);
    assert_eq!(output.status.code(), Some(1));
    let (message, text) = (stderr(&output), String::from_utf8_lossy(&output.stdout).into_owned());
    assert!(
        message.starts_with("error: cornell: the verdict on bdpt is inconclusive") && message.lines().count() == 1,
        "{message}"
    );
    assert!(text.contains("against pt") && text.contains("95 % error bars"), "{text}");
    let last = text.lines().last().unwrap_or_default();
    assert!(last.starts_with("  so do this ") && last.contains("mlt ") && last.contains(" cornell --"), "{text}");
}

#[test]
fn wrong_usage_gives_two() {
    for (line, part) in [
        ("", "required"),
        ("--gallery", "--output"),
        ("cornell -o out", "--gallery"),
        ("cornell --methods photon", "photon"),
        ("cornell --replicas 1", "--replicas"),
        ("cornell --rounds 1", "--rounds"),
        ("cornell --methods mlt:seed=3", "seed"),
        ("none.gltf", "none.gltf"),
        ("--gallery teapot -o out", "islands"),
    ] {
        let output = verify(line, &[]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {message}");
        assert!(message.contains(part) && message.lines().count() == 1, "{line}: {message}");
    }
    assert!(!Path::new("out").exists());
}

/// Scenes that are black or refused pass as such, and what was judged is not judged again.
#[test]
fn the_gallery_goes_on_where_it_stopped() {
    let parent = tempfile::tempdir().expect("a folder");
    let folder = parent.path().join("study");
    let line = "--gallery camera-sees-nothing no-light --methods mlt,pt --replicas 4 --per-pixel 1 --size 4x4 -o";
    let run = |more: &str| verify(&format!("{more} {line}"), &[&folder]);
    let output = run("");
    assert!(output.status.success(), "{}", stderr(&output));
    let page = fs::read_to_string(folder.join("stability.md")).expect("written");
    assert!(page.contains("| camera-sees-nothing | the camera is turned away | passes | passes |"), "{page}");
    assert!(page.contains("| no-light | no light | passes | passes |"), "{page}");
    let command = "mlt verify --gallery -o FOLDER camera-sees-nothing no-light --methods mlt,pt --replicas 4 --size 4x4 --per-pixel 1";
    assert!(page.contains(&format!("\n\n    {command}\n\n")), "{page}");

    let kept = folder.join("verdicts/camera-sees-nothing-mlt.json");
    let before = fs::read_to_string(&kept).expect("kept");
    fs::write(&kept, before.replace("black, as it has to be", "kept")).expect("written");
    assert!(run("").status.success());
    assert!(fs::read_to_string(&kept).expect("kept").contains("kept"));
    assert!(run("--seed 7").status.success());
    assert!(!fs::read_to_string(&kept).expect("kept").contains("\"kept\""), "another seed is another study");
}

/// Light that needs 12 edges does not come in 11.
#[test]
fn the_duct_is_as_long_as_it_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/stability/duct/scene.gltf");
    let says_black = |edges: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
        let options = [
            "--method",
            "bdpt",
            "--samples-per-pixel",
            "64",
            "--size",
            "8x8",
            "-q",
            "-o",
            "a.exr",
            "--max-length",
            edges,
        ];
        let output =
            command.current_dir(folder.path()).arg("render").arg(scene).args(options).output().expect("started");
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output).contains("the image is black")
    };
    assert!(says_black("11") && !says_black("14"));
}

/// A study that was stopped leaves some renders, and perhaps a file that is cut off.
#[test]
fn a_study_of_the_choice_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    let line = "--choice cornell --budgets 4 --replicas 4 --size 8x8 --json";
    let kept = || verify(&format!("{line} -o"), &[folder.path()]);
    let whole = verify(line, &[]);
    assert!(!whole.stdout.is_empty(), "{}", stderr(&whole));
    assert_eq!(kept().stdout, whole.stdout);

    let file = |seed: u64| folder.path().join(format!("cornell-auto-4-{seed}.mltp"));
    fs::remove_file(file(1)).expect("removed");
    let bytes = fs::read(file(2)).expect("there");
    fs::write(file(2), &bytes[..bytes.len() / 2]).expect("cut");
    let again = kept();
    assert!(stderr(&again).contains("it is made again"), "{}", stderr(&again));
    assert_eq!(again.stdout, whole.stdout);

    // The control: what is there is what is used.
    fs::copy(file(3), file(4)).expect("copied");
    let refused = kept();
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("seed is 3 in it and 4 here"), "{}", stderr(&refused));
}
