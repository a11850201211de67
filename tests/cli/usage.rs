//! Wrong usage of `mlt`: exit code 2, one sentence on standard error, nothing on standard output.

use std::process::{Command, Output};

fn mlt(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mlt")).args(arguments).output().expect("mlt starts")
}

#[test]
fn wrong_usage_is_one_sentence_and_exit_code_2() {
    for (arguments, part) in [
        (vec![], "no command given"),
        (vec!["paint"], "unrecognized subcommand 'paint'"),
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
