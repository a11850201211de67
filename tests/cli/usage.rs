//! Wrong usage of `mlt`: exit code 2, one sentence on standard error, nothing on standard output.

use std::{
    fs,
    process::{Command, Output},
};

/// Every command, as completions and the manual have to name them.
const COMMANDS: [&str; 11] =
    ["render", "inspect", "scenes", "merge", "farm", "info", "diff", "verify", "bench", "completions", "man"];

fn mlt(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mlt")).args(arguments).output().expect("mlt starts")
}

#[test]
fn wrong_usage_is_one_sentence_and_exit_code_2() {
    for (arguments, part) in [
        (vec![], "no command given"),
        (vec!["paint"], "there is no command 'paint'; 'mlt --help' lists"),
        (vec!["rendr", "a.glb"], "did you mean 'render'?"),
        (vec!["render", "--widht", "8"], "did you mean '--width'?"),
        (vec!["diff", "--width", "8"], "unexpected argument '--width' found; see 'mlt diff --help'"),
        (vec!["render", "corneel"], "did you mean cornell? give a .gltf"),
        (vec!["render", "cornell", "--camera", "Cam"], "there is no camera \"Cam\"; "),
        (vec!["render", "-s", "64"], "(samples per pixel are --spp)"),
        (vec!["man", "--command", "rendr"], "did you mean \"render\"?"),
        (vec!["man", "no/such/folder"], "make it first"),
        (vec!["completions", "csh"], "[possible values: bash, elvish, fish, powershell, zsh]"),
        (vec!["diff"], "<REFERENCE> <IMAGE>..."),
        (vec!["diff", "a.exr"], "<IMAGE>..."),
        (vec!["diff", "a.exr", "b.exr", "--jsn"], "'--json'"),
    ] {
        let output = mlt(&arguments);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(text.starts_with("error: ") && text.lines().count() == 1 && text.contains(part), "{text}");
    }
}

#[test]
fn help_and_version_are_answers() {
    for (argument, part) in [("--help", "Usage: mlt"), ("--version", env!("CARGO_PKG_VERSION")), ("help", "diff")] {
        let output = mlt(&[argument]);
        assert_eq!(output.status.code(), Some(0));
        assert!(output.stderr.is_empty());
        assert!(String::from_utf8_lossy(&output.stdout).contains(part), "{argument}");
    }
}

fn said(arguments: &[&str]) -> String {
    let output = mlt(arguments);
    assert!(output.status.success() && output.stderr.is_empty(), "{arguments:?}");
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn short_help_fits_one_screen_and_long_help_has_everything() {
    let (short, long) = (said(&["render", "-h"]), said(&["render", "--help"]));
    assert!(short.lines().count() <= 44, "{short}");
    let headings = ["Image:", "Camera:", "Budget:", "Method:", "Output:", "Scene:"];
    let apart = ["Files of Blender and other programs:", "Checkpoint and parts:", "Research:"];
    let at = |heading: &&str| long.find(&format!("\n{heading}\n")).unwrap_or_else(|| panic!("{heading}: {long}"));
    assert!(headings.iter().chain(&apart).map(at).collect::<Vec<_>>().is_sorted());
    assert!(headings.iter().all(|heading| short.contains(heading)));
    assert!(!apart.iter().any(|heading| short.contains(heading)), "{short}");
    assert!(long.contains("--perturbations") && !short.contains("--perturbations"));
}

#[test]
fn completions_name_every_command() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = said(&["completions", shell]);
        assert!(COMMANDS.iter().all(|command| text.contains(command)), "{shell}");
        assert!(text.contains("samples-per-pixel") && text.contains("spp"), "{shell}");
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(said(&["man", folder.path().to_str().expect("text")]), "");
    let page = |name: &str| fs::read_to_string(folder.path().join(name)).expect(name);
    assert!(page("mlt.1").contains(".TH mlt 1"));
    for command in COMMANDS {
        let text = page(&format!("mlt-{command}.1"));
        assert!(text.contains(&format!(".TH mlt-{command} 1")) && text.contains("SYNOPSIS"), "{text}");
        assert!(page("mlt.1").contains(&format!("mlt\\-{command}")), "{command}");
    }
    for task in ["slurm", "openjd", "task"] {
        assert!(page(&format!("mlt-farm-{task}.1")).contains("SYNOPSIS"), "{task}");
        assert!(page("mlt-farm.1").contains(&format!("mlt\\-farm\\-{task}")), "{task}");
    }
    // A page names no other that is not there.
    assert!(!page("mlt.1").contains("\\-help(1)") && !page("mlt-farm.1").contains("\\-help(1)"));
    // Options that short help hides have their words, too.
    assert!(page("mlt-render.1").contains("Stop after this many mutations per pixel"));
    assert_eq!(said(&["man", "--command", "render"]), page("mlt-render.1"));
    assert_eq!(said(&["man"]), page("mlt.1"));
}

#[test]
fn the_built_in_scenes_are_listed() {
    let text = said(&["scenes"]);
    for name in ["  cornell ", "  ring ", "  suzanne ", "  door-ajar "] {
        assert!(text.contains(name), "{text}");
    }
    let list: serde_json::Value = serde_json::from_str(&said(&["scenes", "--json"])).expect("JSON");
    assert_eq!((&list[0]["name"], &list[0]["for"]), (&"cornell".into(), &"render".into()));
}

#[test]
fn a_scene_without_a_command_is_rendered() {
    let folder = tempfile::tempdir().expect("a folder");
    let run =
        |line: &[&str]| Command::new(env!("CARGO_BIN_EXE_mlt")).current_dir(&folder).args(line).output().expect("mlt");
    let output = run(&["cornell", "-s8x8", "--spp", "2", "-j1", "-q"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path().join("cornell.png").exists());
    fs::write(folder.path().join("kitchen.glb"), "").expect("written");
    let message = |line: &[&str]| String::from_utf8(run(line).stderr).expect("text");
    for line in [&["kichen.glb"][..], &["render", "kitchen"], &["render", "kitchen.gltf"]] {
        assert!(message(line).contains("did you mean kitchen.glb? "), "{}", message(line));
    }
}

#[test]
fn colours_are_for_those_who_want_them() {
    let coloured = |arguments: &[&str], variable: (&str, &str)| {
        let output = Command::new(env!("CARGO_BIN_EXE_mlt")).args(arguments).env(variable.0, variable.1).output();
        let output = output.expect("mlt starts");
        [output.stdout, output.stderr].concat().contains(&0x1b)
    };
    for line in [&["paint"][..], &["render", "-h"]] {
        let with = |colour: &'static str| [line, &["--color", colour]].concat();
        assert!(coloured(&with("always"), ("NO_COLOR", "1")), "{line:?}");
        assert!(!coloured(&with("never"), ("CLICOLOR_FORCE", "1")) && !coloured(line, ("TERM", "xterm")), "{line:?}");
        assert!(coloured(line, ("CLICOLOR_FORCE", "1")), "the control: {line:?}");
    }
}
