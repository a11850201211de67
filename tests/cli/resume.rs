//! Renders that outlive their process: checkpoints, parts, and what is refused of them.

use std::{
    fs,
    path::Path,
    process::{Child, Command, Output, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use mlt_cli::{
    kept::{self, Kept},
    output::exr::{self, ExrFile},
};
use tempfile::TempDir;

pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

pub(crate) fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    command.current_dir(folder).args(line.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

pub(crate) fn run(folder: &TempDir, line: &str) -> Output {
    command(folder.path(), line).output().expect("mlt starts")
}

/// Runs to success.
pub(crate) fn made(folder: &TempDir, line: &str) {
    let output = run(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Runs to exit code 2 and one sentence, after the warnings, which is returned.
pub(crate) fn refused(folder: &TempDir, line: &str) -> String {
    let output = run(folder, line);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{line}: {message}");
    let errors: Vec<_> = message.lines().filter(|line| !line.starts_with("warning: ")).collect();
    assert!(errors.len() == 1 && errors[0].starts_with("error: "), "{line}: {message}");
    errors[0].to_owned()
}

/// A render in the background, once it has kept a round.
fn under_way(folder: &TempDir, line: &str) -> Child {
    let child = command(folder.path(), line).stderr(Stdio::null()).spawn().expect("mlt starts");
    let (file, start) = (folder.path().join("kept.mltp"), Instant::now());
    while !file.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{line}: no checkpoint");
        sleep(Duration::from_millis(1));
    }
    child
}

pub(crate) fn held(folder: &TempDir, name: &str) -> Kept {
    kept::read(&folder.path().join(name)).expect("sound")
}

fn image(folder: &TempDir, name: &str) -> ExrFile {
    exr::read(&folder.path().join(name)).expect("an EXR")
}

pub(crate) fn same(folder: &TempDir, a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(|name| image(folder, name));
    a.image.same_bits(&b.image) && a.stderr == b.stderr
}

/// Methods with and without a pilot; 200 rounds of a sample each, so that there is time to end them.
pub(crate) const METHODS: [&str; 6] = [
    "--method pt --samples-per-pixel 200",
    "--method bdpt --samples-per-pixel 200",
    "--method auto --samples-per-pixel 200",
    "--method mlt --strata 2x2 --mutations-per-pixel 200",
    "--method pssmlt --mutations-per-pixel 200",
    "--method mmlt --mutations-per-pixel 200",
];
pub(crate) const SCENE: &str = "render cornell --size 16x16 --threads 1 --quiet";

#[test]
fn a_render_that_is_killed_goes_on_to_the_same_bits() {
    for method in METHODS {
        let (folder, line) = (folder(), format!("{SCENE} {method} --rounds 200"));
        made(&folder, &format!("{line} -o whole.exr -o whole.mltp"));
        let mut child = under_way(&folder, &format!("{line} -o no.exr --checkpoint kept.mltp --checkpoint-every 1ms"));
        child.kill().expect("killed");
        child.wait().expect("ended");
        let rounds = held(&folder, "kept.mltp").sums.rounds().count();
        assert!((1..200).contains(&rounds) && !folder.path().join("no.exr").exists(), "{method}: {rounds} rounds");

        made(&folder, "merge kept.mltp -o first.mltp");
        made(&folder, &format!("{line} -o resumed.exr --resume kept.mltp").replace("--threads 1", "--threads 2"));
        assert!(same(&folder, "whole.exr", "resumed.exr"), "{method}");
        let [whole, kept] = ["whole.mltp", "kept.mltp"].map(|name| held(&folder, name).sums.to_bytes());
        assert!(whole == kept && whole != held(&folder, "first.mltp").sums.to_bytes(), "{method}");
    }
}

/// The plans of `auto` where light is hard, some with more samples than mutations.
#[test]
fn a_mixture_is_resumed_whatever_its_pilot_found() {
    for scene in ["caustic/caustic.gltf", "stability/pool/scene.gltf", "stability/camera-in-glass/scene.gltf"] {
        let (folder, scenes) = (folder(), concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
        let line = format!("render {scenes}/{scene} --size 64x64 --quiet --force");
        made(&folder, &format!("{line} --samples-per-pixel 16 --rounds 4 -o part.mltp"));
        let longer = format!("{line} --samples-per-pixel 32 --rounds 8");
        made(&folder, &format!("{longer} --resume part.mltp -o resumed.exr"));
        made(&folder, &format!("{longer} -o whole.exr"));
        assert!(same(&folder, "whole.exr", "resumed.exr"), "{scene}");
    }
}

#[cfg(unix)]
#[test]
fn a_signal_keeps_what_is_done_and_tells_by_the_exit_code() {
    for (signal, code) in [("TERM", 143), ("INT", 130)] {
        let folder = folder();
        let line = format!("{SCENE} --method pt --samples-per-pixel 1e6 --rounds 500000 -o a.exr");
        let mut child = under_way(&folder, &format!("{line} --checkpoint kept.mltp --checkpoint-every 1ms"));
        let kill = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status();
        assert!(kill.expect("kill starts").success());
        assert_eq!(child.wait().expect("ended").code(), Some(code), "SIG{signal}");
        let rounds = held(&folder, "kept.mltp").sums.rounds().count();
        let samples = 2 * rounds;
        made(&folder, &format!("{SCENE} --method pt --samples-per-pixel {samples} --rounds {rounds} -o b.exr"));
        assert!(same(&folder, "a.exr", "b.exr"), "SIG{signal}: {rounds} rounds");
    }
}

/// Two rounds of half a second; the signal comes in the first one, which is kept where it ends within 3 s.
#[cfg(unix)]
#[test]
fn a_signal_lets_the_round_in_work_end() {
    let (folder, start) = (folder(), Instant::now());
    let line = "render cornell --size 32x32 --threads 1 --quiet --method mlt --mutations-per-pixel 800 --rounds 2";
    made(&folder, &format!("{line} -o whole.exr"));
    let time = start.elapsed();
    let mut child =
        command(folder.path(), &format!("{line} -o a.mltp")).stderr(Stdio::null()).spawn().expect("mlt starts");
    sleep(time.mul_f64(0.35));
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(kill.expect("kill starts").success());
    assert_eq!(child.wait().expect("ended").code(), Some(143));
    let kept = folder.path().join("a.mltp").exists();
    assert!(kept || time > Duration::from_secs(5), "two rounds took {time:?}");
    if kept {
        assert_eq!(held(&folder, "a.mltp").sums.rounds().count(), 1);
        made(&folder, &format!("{line} --resume a.mltp -o b.exr"));
        assert!(same(&folder, "whole.exr", "b.exr"));
    }
}

#[test]
fn a_larger_budget_extends_and_a_smaller_one_is_refused() {
    let folder = folder();
    let line = format!("{SCENE} --method mlt -o a.exr");
    made(&folder, &format!("{line} --mutations-per-pixel 8 --checkpoint a.mltp"));
    made(&folder, &format!("{line} --mutations-per-pixel 12 --resume a.mltp --checkpoint b.mltp"));
    assert_eq!(["a.mltp", "b.mltp"].map(|name| held(&folder, name).sums.rounds().count()), [16, 24]);
    made(&folder, &format!("{line} --mutations-per-pixel 12 --rounds 24 -o whole.exr"));
    assert!(same(&folder, "a.exr", "whole.exr"));
    let message = refused(&folder, &format!("{line} --mutations-per-pixel 8 --resume b.mltp"));
    assert!(message.contains("b.mltp: it holds the rounds 0 to 23, but this render makes 0 to 15"), "{message}");
    let message = refused(&folder, &format!("{line} --mutations-per-pixel 24 --rounds 2 --resume b.mltp"));
    assert!(message.contains("per_pixel_per_round is 0.5 in it and 12 here"), "{message}");
    made(&folder, &format!("{line} --error 100% --resume a.mltp"));
    made(&folder, &format!("{line} --time 10ms --resume a.mltp"));
}

#[test]
fn another_scene_or_option_is_refused_by_name() {
    let folder = folder();
    made(&folder, &format!("{SCENE} --method pt --samples-per-pixel 2 -o a.mltp --seed 7"));
    for (options, part) in [
        ("cornell --method pt --seed 8", "seed is 7 in it and 8 here"),
        ("cornell --method bdpt --seed 7", "method is pt in it and bdpt here"),
        ("cornell --method pt --seed 7 --max-length 4", "max_length is missing in it and 4 here"),
        ("cornell --method pt --seed 7 --fov 30", "fov is missing in it and 30.0 here"),
        ("cornell --method pt --seed 7 --size 16x17", "size is 16x16 in it and 16x17 here"),
        ("ring --method pt --seed 7", "scene file is"),
    ] {
        let size = if options.contains("--size") { "" } else { "--size 16x16" };
        let message =
            refused(&folder, &format!("render {options} {size} --samples-per-pixel 4 --resume a.mltp -o a.exr -q"));
        assert!(message.contains("a.mltp: ") && message.contains(part), "{options}: {message}");
    }
}

#[test]
fn parts_make_the_bits_of_one_machine_in_any_order() {
    for method in METHODS {
        let (folder, line) = (folder(), format!("{SCENE} {method} --rounds 10"));
        made(&folder, &format!("{line} -o whole.exr"));
        (1..=4).for_each(|i| made(&folder, &format!("{line} --shard {i}/4 -o {i}.mltp")));
        for order in ["1 2 3 4", "4 2 1 3"] {
            let parts: Vec<_> = order.split(' ').map(|i| format!("{i}.mltp")).collect();
            made(&folder, &format!("merge {} -o merged.exr -q", parts.join(" ")));
            assert!(same(&folder, "whole.exr", "merged.exr"), "{method}: {order}");
        }
        made(&folder, "merge 4.mltp 1.mltp -o 14.mltp -q");
        made(&folder, "merge 3.mltp 14.mltp 2.mltp -o tree.exr -o tree.png -q");
        assert!(same(&folder, "whole.exr", "tree.exr"), "{method}");
        let command = |name: &str| {
            image(&folder, name).attributes.into_iter().find(|(name, _)| name == "mlt.command").expect("written").1
        };
        assert_eq!(command("whole.exr"), command("merged.exr"));
    }
}

#[test]
fn parts_share_one_pilot_by_a_file() {
    for method in &METHODS[2..] {
        let (folder, line) = (folder(), format!("{SCENE} {method} --rounds 10"));
        made(&folder, &format!("{line} -o whole.exr -o whole.mltp"));
        (1..=3).for_each(|i| made(&folder, &format!("{line} --shard {i}/3 --pilot a.pilot -o {i}.mltp")));
        made(&folder, "merge 2.mltp 3.mltp 1.mltp -o merged.exr -o merged.mltp -q");
        assert!(same(&folder, "whole.exr", "merged.exr"), "{method}");
        let pilots = ["whole.mltp", "1.mltp", "3.mltp", "merged.mltp"].map(|name| held(&folder, name).pilot);
        assert!(pilots[0].is_some() && pilots.iter().all(|pilot| *pilot == pilots[0]), "{method}");
        // It is read: another render's is refused, and so is every byte that is damaged.
        let message = refused(&folder, &format!("{line} --seed 1 --pilot a.pilot -o x.exr"));
        assert!(message.contains("a.pilot: seed is 0 in it and 1 here"), "{message}");
        let bytes = fs::read(folder.path().join("a.pilot")).expect("read");
        for at in (0..bytes.len()).step_by(bytes.len() / 4) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            fs::write(folder.path().join("b.pilot"), &damaged).expect("written");
            let message = refused(&folder, &format!("{line} --pilot b.pilot -o x.exr"));
            assert!(message.contains("b.pilot: cannot be read as what 'mlt render --pilot' has written"), "{message}");
        }
    }
    let folder = folder();
    made(&folder, &format!("{SCENE} {} --pilot none.pilot -o a.exr", METHODS[0]));
    assert!(!folder.path().join("none.pilot").exists(), "path tracing has no pilot");
}

#[test]
fn parts_that_do_not_make_one_render_are_refused_by_name() {
    let folder = folder();
    let part = |name: &str, options: &str| {
        made(&folder, &format!("{SCENE} --method pt --samples-per-pixel 8 --rounds 8 -o {name}.mltp {options}"))
    };
    part("a", "--shard 1/3");
    part("b", "--shard 2/3");
    part("c", "--shard 3/3");
    part("seed", "--shard 2/3 --seed 1");
    part("overlap", "--shard 2/4");
    made(&folder, &format!("{SCENE} --method pt --samples-per-pixel 16 --rounds 16 --shard 8/8 -o longer.mltp"));
    for (line, part) in [
        ("merge a.mltp c.mltp -o x.exr", "the rounds 2 to 4 of 0 to 7 are in no part"),
        ("merge a.mltp b.mltp -o x.exr", "the rounds 5 to 7 of 0 to 7 are in no part"),
        ("merge a.mltp b.mltp a.mltp -o x.exr", "both films hold the rounds 0 to 1"),
        (
            "merge b.mltp overlap.mltp -o x.exr",
            "overlap.mltp does not go with b.mltp: both films hold the rounds 2 to 3",
        ),
        ("merge a.mltp seed.mltp c.mltp -o x.exr", "seed.mltp does not go with a.mltp: seed is 0 in one and 1"),
        ("merge a.mltp longer.mltp -o x.exr", "the whole render is 0 to 15 in one and 0 to 7 in the other"),
        ("merge none.mltp -o x.exr", "none.mltp: No such file"),
        ("merge . -o x.exr", "not a regular file"),
    ] {
        let message = refused(&folder, line);
        assert!(message.contains(part) && !folder.path().join("x.exr").exists(), "{line}: {message}");
    }
    for (options, part) in [
        ("--shard 2/3 --resume a.mltp -o a.mltp", "it holds the rounds 0 to 1, but this render makes 2 to 4"),
        ("--shard 9/9 -o x.mltp", "there are only 8 rounds to share out"),
        ("--shard 1/2 -o x.exr", "images of parts cannot be added up"),
        ("--shard 0/2 -o x.mltp", "as in 1/4 to 4/4"),
        ("-o x.exr --checkpoint x.exr", "x.exr is given twice"),
        ("-o x.exr --resume none.mltp", "none.mltp: No such file"),
    ] {
        let line = format!("{SCENE} --method pt --samples-per-pixel 8 --rounds 8 {options}");
        let message = refused(&folder, &line);
        assert!(message.contains(part), "{line}: {message}");
    }
}

#[test]
fn every_damaged_byte_and_every_end_that_is_cut_off_is_refused() {
    let folder = folder();
    made(
        &folder,
        &format!("{SCENE} --size 3x2 --method pt --samples-per-pixel 1 -o a.mltp").replace("--size 16x16 ", ""),
    );
    let (bytes, path) = (fs::read(folder.path().join("a.mltp")).expect("read"), folder.path().join("b.mltp"));
    let reads = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("written");
        kept::read(&path).is_ok()
    };
    assert!(reads(&bytes));
    for at in 0..bytes.len() {
        assert!(!reads(&bytes[..at]), "the first {at} bytes");
        for flip in [1, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            assert!(!reads(&damaged), "byte {at} ^ {flip}");
        }
    }
    assert!(!reads(&[&bytes[..], b"\0"].concat()));
    for (content, part) in [(&bytes[..bytes.len() - 1], "damaged or cut off"), (b"a text", "not a file of")] {
        fs::write(&path, content).expect("written");
        let message = refused(&folder, &format!("{SCENE} -o a.exr --resume b.mltp"));
        assert!(message.contains("b.mltp: ") && message.contains(part), "{message}");
    }
}

#[test]
fn a_file_tells_what_it_holds() {
    let folder = folder();
    made(&folder, &format!("{SCENE} --method mlt --mutations-per-pixel 8 --shard 2/4 -o a.mltp -o a.exr -o a.png"));
    let facts = |name: &str| -> serde_json::Value {
        let output = command(folder.path(), &format!("info {name} --json")).stdout(Stdio::piped()).output();
        serde_json::from_slice(&output.expect("mlt starts").stdout).expect("JSON")
    };
    let part = facts("a.mltp");
    assert_eq!((&part["rounds"], &part["rounds_of_render"]), (&"4 to 7".into(), &"0 to 15".into()));
    assert_eq!((&part["image"], &part["key.seed"]), (&"16x16".into(), &"0".into()));
    made(&folder, &format!("{SCENE} --method mlt --mutations-per-pixel 8 --shard 2/4 -o b.mltp"));
    made(&folder, &format!("{SCENE} --method mlt --mutations-per-pixel 8 --shard 3/4 -o c.mltp"));
    assert_eq!(part["checksum"], facts("b.mltp")["checksum"]);
    assert_ne!(part["checksum"], facts("c.mltp")["checksum"]);
    made(&folder, &format!("{SCENE} --method mlt --mutations-per-pixel 8 --pilot a.pilot -o d.png"));
    assert_eq!(facts("a.pilot")["key.seed"], "0");
    assert_eq!((&facts("a.exr")["first_round"], &facts("a.exr")["method"]), (&"4".into(), &"mlt".into()));
    assert_eq!(facts("a.png")["command"], facts("a.exr")["command"]);
    assert!(refused(&folder, "info none.exr").contains("none.exr: No such file"));
    assert!(!run(&folder, "diff a.exr a.mltp").status.success());
}
