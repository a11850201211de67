//! Ctrl-C: the first is noted, the second ends the program.
//!
//! A handler holds for a whole process, so the test starts itself again as the program to interrupt.

use std::{
    env,
    io::{BufRead, BufReader, Write},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

use mlt_cli::interrupt::Interrupt;

const AS_CHILD: &str = "MLT_TEST_INTERRUPTED_CHILD";

/// The interrupted program: says "ready", then "noted", then waits to be ended.
#[test]
fn child() {
    if env::var_os(AS_CHILD).is_none() {
        return;
    }
    let interrupt = Interrupt::install().expect("the first handler");
    assert!(Interrupt::install().is_err(), "a second handler");
    say("ready");
    while !interrupt.requested() {
        sleep(Duration::from_millis(5));
    }
    say("noted");
    sleep(Duration::from_secs(60));
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
fn the_second_signal_ends_the_program() {
    for (name, code) in [("INT", 130), ("TERM", 143)] {
        let mut child = Command::new(env::current_exe().expect("this test"))
            .args(["--exact", "interrupt::child", "--nocapture"])
            .env(AS_CHILD, "yes")
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
    }
}
