//! `mlt render`, from outside: its files, its report, renders that repeat to the bit, and what it says about bad input.

use std::{
    fs,
    path::Path,
    process::{Command, Output, Stdio},
};

use mlt_cli::output::{
    exr::{self, ExrFile},
    png,
};
use serde_json::Value;
use tempfile::TempDir;

/// A square light that looks down on a square floor.
const OBJ: &str = "\
mtllib light.mtl
v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1
v -0.5 2 -0.5\nv 0.5 2 -0.5\nv 0.5 2 0.5\nv -0.5 2 0.5
usemtl floor\nf 1 2 3 4
usemtl light\nf 5 6 7 8
";
const MTL: &str = "newmtl floor\nKd 0.5 0.5 0.5\nnewmtl light\nKd 0 0 0\nKe 5 5 5\n";

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn with_obj() -> TempDir {
    let folder = folder();
    fs::write(folder.path().join("light.obj"), OBJ).expect("written");
    fs::write(folder.path().join("light.mtl"), MTL).expect("written");
    folder
}

fn command(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    command.current_dir(folder).arg("render").args(line.split_whitespace());
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn made(folder: &TempDir, line: &str) -> Output {
    let output = command(folder.path(), line).output().expect("mlt starts");
    assert!(output.status.success(), "{line}: {}", text(&output.stderr));
    output
}

fn report(folder: &TempDir, line: &str) -> Value {
    serde_json::from_slice(&made(folder, &format!("{line} --json")).stdout).expect("JSON on standard output")
}

/// Runs to an error: this exit code, nothing on standard output, one line on standard error, which is returned.
fn refused(folder: &Path, line: &str, code: i32) -> String {
    let output = command(folder, line).output().expect("mlt starts");
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{line}: {message}");
    assert!(output.stdout.is_empty(), "{line}");
    assert!(message.starts_with("error: ") && message.lines().count() == 1, "{line}: {message}");
    message
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("readable");
    let mut names: Vec<_> =
        entries.map(|entry| text(entry.expect("an entry").file_name().as_encoded_bytes())).collect();
    names.sort();
    names
}

fn image(folder: &TempDir, name: &str) -> ExrFile {
    exr::read(&folder.path().join(name)).expect("an EXR")
}

fn attribute<'a>(file: &'a ExrFile, name: &str) -> &'a str {
    let found = file.attributes.iter().find(|attribute| attribute.0 == format!("mlt.{name}"));
    &found.unwrap_or_else(|| panic!("no attribute {name}")).1
}

#[test]
fn alone_it_renders_the_cornell_box_into_two_files_here() {
    let folder = folder();
    let output = made(&folder, "--size 32x32");
    assert_eq!(names(folder.path()), ["cornell.exr", "cornell.png"]);
    let (said, report) = (text(&output.stderr), text(&output.stdout));
    assert!(said.starts_with("no budget given; 64 samples per pixel in 16 rounds\n"), "{said}");
    assert!(report.starts_with("cornell: auto, strata none, 32x32, seed 0\n"), "{report}");
    assert!(report.ends_with("written         cornell.exr\n  written         cornell.png\n"), "{report}");
}

#[test]
fn json_tells_everything_of_every_method() {
    let folder = folder();
    for method in ["mlt", "bdpt", "pt", "pssmlt", "mmlt"] {
        let line = format!(
            "--method {method} --strata 2x1 --weights power --samples-per-pixel 16 --size 32x32 --threads 2 --seed 3 -o a.exr"
        );
        let report = report(&folder, &line);
        let mutates = !["bdpt", "pt"].contains(&method);
        for (name, value) in [("scene", "cornell"), ("method", method), ("strata_option", "2x1")] {
            assert_eq!(report[name], value, "{method}");
        }
        let [rounds, mutations] = if mutates { [16, 16 * 1024] } else { [8, 0] };
        for (name, value) in [("seed", 3), ("threads", 2), ("rounds", rounds), ("mutations", mutations)] {
            assert_eq!(report[name], value, "{method}: {name}");
        }
        for name in ["samples", "rays"] {
            assert!(report[name].as_u64().is_some_and(|n| n > 0), "{method}: {name}");
        }
        for name in ["seconds", "cpu_seconds", "b", "b_stderr", "relative_error"] {
            assert!(report[name].as_f64().is_some_and(|x| x > 0.0), "{method}: {name}");
        }
        let strata = report["strata"].as_array().expect("a list");
        assert_eq!(strata.len(), if mutates { 2 } else { 0 }, "{method}");
        for stratum in strata {
            assert!(stratum["b"].as_f64().is_some_and(|b| b > 0.0) && stratum["b_stderr"].is_f64(), "{stratum}");
            assert_eq!(stratum["mutations"], 8 * 1024);
        }
        let total = &report["acceptance"]["total"];
        assert_eq!(total.as_f64().is_some_and(|rate| rate > 0.05 && rate <= 1.0), mutates, "{method}: {total}");
        assert!(report["warnings"].as_array().is_some_and(|list| list.iter().all(Value::is_string)));
        assert_eq!(report["outputs"], serde_json::json!(["a.exr"]));
    }
}

#[test]
fn the_files_hold_image_error_and_origin() {
    let folder = folder();
    made(&folder, "--method pt --samples-per-pixel 32 --size 24x16 -o a.exr -o b.PNG -q");
    assert_eq!(names(folder.path()), ["a.exr", "b.PNG"]);
    let file = image(&folder, "a.exr");
    assert_eq!((file.image.width, file.image.height), (24, 16));
    assert_eq!(png::read(&folder.path().join("b.PNG")).map(|png| (png.width, png.height)).ok(), Some((24, 16)));
    assert!(file.image.luminance().iter().all(|value| value.is_finite()));
    let errors = file.stderr.as_ref().expect("standard errors").as_flattened();
    assert!(errors.iter().all(|e| e.is_finite() && *e >= 0.0) && errors.iter().any(|e| *e > 0.0));
    for (name, value) in [("version", env!("CARGO_PKG_VERSION")), ("scene", "cornell"), ("method", "pt"), ("seed", "0")]
    {
        assert_eq!(attribute(&file, name), value);
    }
    for name in ["b", "b_stderr", "seconds", "rounds", "relative_error"] {
        assert!(attribute(&file, name).parse::<f64>().is_ok_and(|x| x > 0.0), "{name}");
    }
}

/// Runs the command in an EXR's header elsewhere; true if that gives the same bits.
fn repeats(folder: &TempDir, name: &str) -> bool {
    let file = folder.path().join(name);
    let line = attribute(&exr::read(&file).expect("an EXR"), "command").to_owned();
    let words = line.strip_prefix("mlt ").expect("a command of mlt");
    let shell = format!("\"$MLT\" {words} --quiet -o again.exr 2> /dev/null");
    let mlt = env!("CARGO_BIN_EXE_mlt");
    let status = Command::new("sh").args(["-c", &shell]).env("MLT", mlt).current_dir(folder.path()).status();
    assert!(status.expect("sh starts").success(), "{line}");
    let diff = Command::new(mlt).args(["diff", "--json"]).arg(&file).arg(folder.path().join("again.exr")).output();
    let list: Value = serde_json::from_slice(&diff.expect("mlt starts").stdout).expect("JSON");
    list[0]["identical"] == true
}

#[cfg(unix)]
#[test]
fn the_command_in_the_file_makes_it_again() {
    let folder = with_obj();
    fs::copy(folder.path().join("light.obj"), folder.path().join("it's a light.obj")).expect("copied");
    for line in [
        "--mutations-per-pixel 10 --rounds 3 --strata 3x2 --seed 9 --max-length 4",
        "--mutations-per-pixel 0.3 --first-round 5 --rounds 7",
        "--method bdpt --samples-per-pixel 10 --rounds 3",
        "--time 1s",
        "--time 1s --method pt",
        "--time 1s --rounds 3 --method mmlt",
        "--error 60%",
        "light.obj --mutations-per-pixel 8 --camera-from -1,2.5,0.1 --camera-to 0,0,0 --fov 33.3",
    ] {
        made(&folder, &format!("{line} --size 32x24 -q -o a.exr"));
        assert!(repeats(&folder, "a.exr"), "{line}");
    }
    let mut spaced = command(folder.path(), "--size 32x24 -q -o a.exr --samples-per-pixel 8");
    assert!(spaced.arg("it's a light.obj").status().expect("mlt starts").success());
    assert!(repeats(&folder, "a.exr"));
}

/// The negative control of the test above, and of all that compare bits: other seeds, other bits.
#[test]
fn bits_depend_on_the_seed_and_not_on_the_threads() {
    let folder = folder();
    for method in ["mlt", "bdpt", "pt"] {
        let render = |more: &str| {
            made(
                &folder,
                &format!("--method {method} --samples-per-pixel 16 --strata 2x2 --size 40x30 -q -o a.exr {more}"),
            );
            image(&folder, "a.exr")
        };
        let one = render("--threads 1");
        for threads in ["2", "3", "8"] {
            let other = render(&format!("--threads {threads}"));
            assert!(one.image.same_bits(&other.image) && one.stderr == other.stderr, "{method} on {threads} threads");
        }
        assert!(!one.image.same_bits(&render("--seed 1").image), "{method}");
    }
}

#[test]
fn rounds_may_be_made_apart_and_averaged() {
    let folder = folder();
    for (method, unit) in [("mlt", "mutations"), ("bdpt", "samples"), ("pt", "samples")] {
        let render = |total: u32, more: &str| {
            made(&folder, &format!("--method {method} --{unit}-per-pixel {total} --size 32x32 -q -o a.exr {more}"));
            image(&folder, "a.exr").image
        };
        let whole = render(20, "--rounds 8");
        let (first, second) = (render(10, "--rounds 4"), render(10, "--rounds 4 --first-round 4"));
        let differs = |other: fn(f32, f32) -> f32| {
            let halves = first.rgb.as_flattened().iter().zip(second.rgb.as_flattened());
            let pairs = whole.rgb.as_flattened().iter().zip(halves);
            pairs.filter(|&(&w, (&a, &b))| (w - other(a, b)).abs() > 2.0 * f32::EPSILON * w).count()
        };
        assert_eq!(differs(|a, b| (a + b) / 2.0), 0, "{method}");
        assert!(differs(|a, _| a) > 100, "{method}: half of it is not the whole");
    }
}

#[test]
fn an_obj_file_has_the_camera_that_is_asked_for() {
    let folder = with_obj();
    let mean = |line: &str| {
        made(&folder, &format!("light.obj --method pt --samples-per-pixel 16 --size 32x32 -q -o a.exr {line}"));
        let luminance = image(&folder, "a.exr").image.luminance();
        luminance.iter().sum::<f32>() / luminance.len() as f32
    };
    let seen = |line: &str, low: f32, high: f32| {
        let mean = mean(line);
        assert!((low..high).contains(&mean), "{line}: {mean}");
    };
    seen("", 0.01, 4.0);
    // Into the light, which fills the view; at its dark back; away from everything.
    seen("--camera-from 0,1,0.001 --camera-to 0,2,0 --fov 20", 4.999, 5.001);
    seen("--camera-from 0,3,0.001 --camera-to 0,2,0 --fov 20", -0.001, 0.001);
    // A half side of 0.5 at a distance of 1 in a view of half side tan 60°: 5 · (0.5 / tan 60°)² = 0.4167.
    seen("--camera-from 0,1,0.001 --camera-to 0,2,0 --fov 120", 0.40, 0.43);
}

#[test]
fn quiet_is_quiet_and_time_is_kept() {
    let folder = folder();
    let output = made(&folder, "--method pt --samples-per-pixel 32 --size 32x32 --quiet -o a.exr");
    assert!(output.stdout.is_empty(), "{}", text(&output.stdout));
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    let report = report(&folder, "--time 1s --size 32x32 -o a.exr");
    assert!(report["seconds"].as_f64().is_some_and(|seconds| (0.3..4.0).contains(&seconds)), "{report}");
}

#[test]
fn wrong_usage_is_refused_before_anything_is_rendered() {
    let folder = with_obj();
    fs::write(folder.path().join("bad.gltf"), "{ \"asset\": ").expect("written");
    fs::write(folder.path().join("bad.glb"), [0x67; 40]).expect("written");
    fs::write(folder.path().join("bad.obj"), "f 1 2 9\n").expect("written");
    fs::write(folder.path().join("image.jpg"), "").expect("written");
    let before = names(folder.path());
    for (line, part) in [
        ("none.gltf", "none.gltf"),
        ("nowhere", "nowhere"),
        (".", "not a regular file"),
        ("image.jpg", "convert the scene"),
        ("bad.gltf", "bad.gltf: "),
        ("bad.glb", "bad.glb: "),
        ("bad.obj", "bad.obj: "),
        ("--camera left", "cornell: there is no camera \"left\""),
        ("light.obj --camera left", "it has none"),
        ("-o none/a.exr", "the folder none does not exist"),
        ("-o a.gif", "has to end in .exr, .hdr, .png or .jpg"),
        ("-o a.exr -o a.exr", "given twice"),
        ("--method pt --mutations-per-pixel 8", "pt is not told how many to make; use --samples-per-pixel"),
        ("--method bdpt --mutations-per-pixel 8", "bdpt is not told how many to make; use --samples-per-pixel"),
        ("--mutations-per-pixel 1e300", "at most 1e9"),
        ("--time 3", "as in 30s"),
        ("--threads 100000", "between 1 and 1024"),
        ("--rounds 2 --first-round 18446744073709551615", "--first-round"),
        ("--size 10", "640x480"),
        ("a.gltf b.gltf", "unexpected argument 'b.gltf'"),
    ] {
        let message = refused(folder.path(), line, 2);
        assert!(message.contains(part), "{line}: {message}");
    }
    assert_eq!(names(folder.path()), before);
}

#[test]
fn a_scene_that_cannot_be_rendered_is_a_failed_run() {
    let folder = with_obj();
    fs::write(folder.path().join("dark.obj"), OBJ.replace("usemtl light", "usemtl floor")).expect("written");
    fs::write(folder.path().join("empty.obj"), "v 0 0 0\n").expect("written");
    for (line, part) in [
        ("dark.obj --environment none", "dark.obj: the scene has no light"),
        ("empty.obj", "empty.obj: the scene has no triangle"),
        ("--size 65536x65536", "an image of 65536x65536"),
        ("--rounds 1 --mutations-per-pixel 1e9", "a round of 1000000000 mutations per pixel"),
        ("--rounds 1 --samples-per-pixel 1e9 --method pt", "a round of 1000000000 samples per pixel"),
    ] {
        let message = refused(folder.path(), line, 1);
        assert!(message.contains(part), "{line}: {message}");
    }
}

/// The parts left out may be why there is nothing to render.
#[test]
fn what_was_left_out_is_said_of_a_scene_that_cannot_be_rendered() {
    let folder = with_obj();
    let dark = OBJ.replace("usemtl light", "usemtl floor") + "p 1\n";
    fs::write(folder.path().join("dark.obj"), dark).expect("written");
    let output = command(folder.path(), "dark.obj --environment none").output().expect("mlt starts");
    let lines: Vec<_> = text(&output.stderr).lines().map(str::to_owned).collect();
    assert_eq!((output.status.code(), lines.len()), (Some(1), 2), "{lines:?}");
    assert!(lines[0].starts_with("warning: ") && lines[0].contains("points and lines"), "{lines:?}");
    assert!(lines[1].starts_with("error: ") && lines[1].contains("no light"), "{lines:?}");
}

/// Options of chains do nothing for a method that has none, and choose `mlt` where no method is named.
#[test]
fn options_of_chains_are_missed_where_there_are_none() {
    let folder = with_obj();
    for (options, said) in [("--method pt --strata 4x4", true), ("--strata 4x4", false), ("--method pt", false)] {
        let line = format!("light.obj {options} --size 8x8 --samples-per-pixel 16");
        let output = command(folder.path(), &line).output().expect("mlt starts");
        assert_eq!(text(&output.stderr).contains("pt has no chains"), said, "{options}: {}", text(&output.stderr));
    }
}

#[cfg(unix)]
mod unix {
    use std::{
        io::Read,
        thread::sleep,
        time::{Duration, Instant},
    };

    use super::*;

    /// Starts a render, interrupts it after a while, and gives its exit code and standard error.
    fn interrupted(folder: &TempDir, line: &str) -> (Option<i32>, String) {
        let mut child = command(folder.path(), line).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("mlt");
        sleep(Duration::from_secs(2));
        let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(kill.expect("kill starts").success());
        let asked = Instant::now();
        let code = child.wait().expect("mlt ends").code();
        assert!(asked.elapsed() < Duration::from_secs(20), "{line}: {:?}", asked.elapsed());
        let mut said = String::new();
        child.stderr.take().expect("piped").read_to_string(&mut said).expect("text");
        (code, said)
    }

    #[test]
    fn ctrl_c_writes_the_finished_rounds() {
        let folder = folder();
        for method in ["mlt", "bdpt"] {
            let line =
                format!("--method {method} --samples-per-pixel 1e5 --rounds 100000 --size 32x32 -o a.exr -o a.png");
            let (code, said) = interrupted(&folder, &line);
            assert_eq!(code, Some(130), "{said}");
            assert!(said.lines().any(|line| line.starts_with("warning: interrupted after")), "{said}");
            assert_eq!(names(folder.path()), ["a.exr", "a.png"]);
            assert!(png::read(&folder.path().join("a.png")).is_ok());
            let rounds: u64 = attribute(&image(&folder, "a.exr"), "rounds").parse().expect("a number");
            assert!((1..100_000).contains(&rounds), "{rounds}");
            assert!(repeats(&folder, "a.exr"), "{method}");
            fs::remove_file(folder.path().join("again.exr")).expect("there");
        }
    }

    #[test]
    fn ctrl_c_in_the_first_round_writes_nothing() {
        let folder = folder();
        let (code, said) = interrupted(&folder, "--method pt --rounds 1 --samples-per-pixel 2e4 --size 128x128");
        assert_eq!(code, Some(130), "{said}");
        let said: Vec<_> = said.lines().filter(|line| !line.starts_with("progress: ")).collect();
        assert!(said.len() == 1 && said[0].starts_with("error: interrupted before the first round"), "{said:?}");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn a_reader_that_goes_away_is_no_error() {
        let folder = folder();
        let mut child = command(folder.path(), "--method pt --samples-per-pixel 8 --size 16x16 --json -o a.exr");
        let mut child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("mlt starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("mlt ends");
        assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
        assert_eq!(names(folder.path()), ["a.exr"]);
    }

    /// The old file stays, nothing is left half written, and the file that fits is written all the same.
    fn survives_a_full_disk(folder: &Path, output: &Output) {
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.starts_with("error: a.exr: cannot be written: ") && message.lines().count() == 1, "{message}");
        assert_eq!(names(folder), ["a.exr", "b.png"]);
        assert_eq!(fs::read(folder.join("a.exr")).expect("kept"), b"old");
        assert!(png::read(&folder.join("b.png")).is_ok());
    }

    const LARGE_AND_SMALL: &str = "--method pt --samples-per-pixel 8 --size 40x40 -q --force -o a.exr -o b.png";

    /// Takes a file system away again.
    struct Mounted<'a>(&'a Path);

    impl Drop for Mounted<'_> {
        fn drop(&mut self) {
            let _ = Command::new("umount").arg(self.0).status();
        }
    }

    #[test]
    fn a_full_disk_is_an_error_and_keeps_the_old_file() {
        let folder = folder();
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=16k", "tmpfs"]).arg(folder.path()).output();
        if !mount.is_ok_and(|mount| mount.status.success()) {
            eprintln!("SKIPPED: no permission to mount a small file system; a_file_too_large… tests the same path");
            return;
        }
        let _mounted = Mounted(folder.path());
        fs::write(folder.path().join("a.exr"), "old").expect("written");
        let output = command(folder.path(), LARGE_AND_SMALL).output().expect("mlt starts");
        survives_a_full_disk(folder.path(), &output);
    }

    #[test]
    fn a_file_too_large_is_an_error_and_keeps_the_old_file() {
        let folder = folder();
        fs::write(folder.path().join("a.exr"), "old").expect("written");
        // Blocks of 512 bytes (of 1024 in some shells); the signal would end the process before it sees the error.
        let shell = format!("trap '' XFSZ; ulimit -f 12; exec \"$MLT\" render {LARGE_AND_SMALL}");
        let mut limited = Command::new("sh");
        limited.args(["-c", &shell]).env("MLT", env!("CARGO_BIN_EXE_mlt")).current_dir(folder.path());
        survives_a_full_disk(folder.path(), &limited.output().expect("sh starts"));
    }

    #[test]
    fn a_folder_without_permission_is_found_out_first() {
        use std::os::unix::fs::PermissionsExt;
        let folder = folder();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).expect("set");
        if fs::write(folder.path().join("probe"), "").is_ok() {
            eprintln!("SKIPPED: this user may write everywhere");
            return;
        }
        assert!(refused(folder.path(), "", 2).contains("cannot write in the folder"));
    }
}
