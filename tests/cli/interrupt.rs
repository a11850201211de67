//! Ctrl-C: the first is noted, the second ends the program.
//!
//! A handler holds for a whole process, so a test starts itself again as the program to interrupt.

use std::{
    env,
    fs::{self, read_dir},
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

use mlt_cli::{atomic, interrupt::Interrupt};
use tempfile::tempdir;

/// The file that the child writes.
const AS_CHILD: &str = "MLT_TEST_INTERRUPTED_CHILD";

/// The interrupted program: in the middle of a file says "ready", then "noted", then waits to be ended.
#[test]
fn child() {
    let Some(path) = env::var_os(AS_CHILD) else { return };
    let interrupt = Interrupt::install().expect("the first handler");
    assert!(Interrupt::install().is_err(), "a second handler");
    let content = |file: &mut fs::File| {
        file.write_all(b"half of a file")?;
        say("ready");
        while !interrupt.requested() {
            sleep(Duration::from_millis(5));
        }
        say("noted");
        sleep(Duration::from_secs(60));
        Ok(())
    };
    atomic::write_with(Path::new(&path), content).expect("written");
}

fn say(word: &str) {
    let mut stderr = std::io::stderr();
    writeln!(stderr, "{word}").expect("standard error is open");
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status();
    assert!(status.expect("kill starts").success());
}

#[test]
fn the_second_signal_ends_the_program_and_leaves_files_as_they_were() {
    for (name, code) in [("INT", 130), ("TERM", 143)] {
        let folder = tempdir().expect("a folder");
        let path = folder.path().join("old.exr");
        fs::write(&path, "old").expect("written");
        let mut child = Command::new(env::current_exe().expect("this test"))
            .args(["--exact", "interrupt::child", "--nocapture"])
            .env(AS_CHILD, &path)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the child starts");
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let mut next = || lines.next().expect("a line").expect("readable");
        assert_eq!(next(), "ready");
        signal(&child, name);
        assert_eq!(next(), "noted");
        signal(&child, name);
        assert_eq!(child.wait().expect("the child ends").code(), Some(code), "SIG{name}");
        assert_eq!(fs::read(&path).expect("there"), b"old");
        assert_eq!(read_dir(folder.path()).expect("a folder").count(), 1, "SIG{name}: a temporary file is left");
    }
}

/// Starts a render in the folder, sends it a signal once it makes its first round, and gives its exit code and standard output.
fn signalled(folder: &Path, line: &str) -> (Option<i32>, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_mlt"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("mlt starts");
    let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines().map(|line| line.expect("text"));
    assert!(lines.any(|line| line.contains("set up after")), "{line}: no rounds");
    signal(&child, "TERM");
    lines.for_each(drop);
    let output = child.wait_with_output().expect("mlt ends");
    (output.status.code(), String::from_utf8(output.stdout).expect("text"))
}

/// One round of one batch of work, so that a signal is seen at its end. It takes about a second; a signal that comes later is seen nowhere.
const LAST_ROUND: &str = "--size 2x2 --threads 1 --method pt --samples-per-pixel 2e5 --rounds 1 -v --json";

#[test]
fn a_signal_in_the_last_round_changes_nothing() {
    let folder = tempdir().expect("a folder");
    let (code, report) = signalled(folder.path(), &format!("render cornell {LAST_ROUND} -o a.exr"));
    assert_eq!(code, Some(0), "{report}");
    assert!(report.contains("\"interrupted\": false"), "{report}");
}

/// The part is there, and its checkpoint, which is of no use any more, is not.
#[test]
fn a_signal_in_the_last_round_of_a_part_of_a_farm_changes_nothing() {
    let folder = tempdir().expect("a folder");
    let line = format!("-v farm task --parts . --shard 1/1 -- cornell {LAST_ROUND} --checkpoint-every 1ms -o a.exr");
    let (code, report) = signalled(folder.path(), &line);
    assert_eq!(code, Some(0), "{report}");
    let names = read_dir(folder.path()).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    assert_eq!(names.collect::<Vec<_>>(), ["part-1.mltp"]);
}

/// The frame is whole; those after it are not begun.
#[test]
fn a_signal_in_the_last_round_of_a_frame_ends_after_the_frame() {
    let folder = tempdir().expect("a folder");
    super::frames::with_animation(folder.path(), 0, 0.1);
    let line = format!("render room.gltf {LAST_ROUND} --frames 1-1000 -o a.####.exr");
    let (code, report) = signalled(folder.path(), &line);
    assert_eq!(code, Some(143), "{report}");
    assert!(report.contains("\"interrupted\": false") && !report.contains("\"interrupted\": true"), "{report}");
}
