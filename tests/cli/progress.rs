//! Lines that `mlt render` writes while it works, where standard error is no terminal.

use std::process::Command;

/// Standard error of a render of two seconds.
fn said(options: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let line = format!("render cornell -s 32x32 -o a.exr -j1 --time 2s {options}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    let output = command.current_dir(&folder).args(line.split_whitespace()).output().expect("mlt starts");
    assert!(output.status.success());
    String::from_utf8(output.stderr).expect("text")
}

#[test]
fn a_line_now_and_then_tells_how_far_it_is() {
    let text = said("");
    let lines: Vec<_> = text.lines().filter(|line| line.starts_with("progress: ")).collect();
    assert!((1..=3).contains(&lines.len()), "{text}");
    assert!(lines[0].contains(" %, ") && lines[0].contains("s left") && !text.contains('\r'), "{text}");
    assert!(!said("--quiet").contains("progress"));
}

#[test]
fn decisions_are_told_to_those_who_ask() {
    let [silent, some, all] = ["", "-v", "-vv"].map(said);
    for part in ["cornell is read after", "32 triangles and 1 lights", "a round is", "set up after", "a.exr is written"]
    {
        assert!(some.contains(part) && !silent.contains(part), "{part}: {some}");
    }
    assert!(all.contains("DEBUG") && !some.contains("DEBUG"), "{all}");
    assert!(!some.contains('\u{1b}'), "{some}");
}
