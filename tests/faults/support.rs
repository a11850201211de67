//! Renders of the scenes in `data/` by the program, and their reports.

use std::{
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;

/// Report of one render.
pub(crate) struct Render {
    /// The report that `--json` prints.
    pub report: Value,
    /// Standard error: warnings and notes.
    pub said: String,
}

impl Render {
    /// Mean luminance of the image and its standard error.
    pub(crate) fn b(&self) -> (f64, f64) {
        let number = |name: &str| self.report[name].as_f64().unwrap_or_else(|| panic!("no {name}: {}", self.report));
        (number("b"), number("b_stderr"))
    }

    /// Fails unless b is within `tolerance` and four and a half of its standard errors of `truth`.
    pub(crate) fn expect_b(&self, truth: f64, tolerance: f64) {
        let (b, stderr) = self.b();
        assert!((b - truth).abs() <= tolerance + 4.5 * stderr, "b = {b} ± {stderr}, not {truth} ± {tolerance}");
    }
}

/// A file of `data/`.
pub(crate) fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/faults/data").join(name)
}

/// Renders a file of `data/`, or one at an absolute path, with these further arguments; the render must succeed.
pub(crate) fn render(name: &str, arguments: &str) -> Render {
    let output = run(name, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{name} {arguments}: {said}");
    Render { report: serde_json::from_slice(&output.stdout).expect("JSON on standard output"), said }
}

/// Message of the program about a file that it must refuse, on standard error.
pub(crate) fn refusal(name: &str, arguments: &str) -> String {
    let output = run(name, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(output.status.code(), Some(1 | 2)), "{name} {arguments}: {said}");
    said
}

fn run(name: &str, arguments: &str) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    Command::new(env!("CARGO_BIN_EXE_mlt"))
        .current_dir(folder.path())
        .arg("render")
        .arg(data(name))
        .args(arguments.split_whitespace())
        .args(["--json", "-o", "image.exr"])
        .output()
        .expect("mlt starts")
}
