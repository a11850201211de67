//! Error bars, the end of a render, and files that ask for too much.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use mlt_cli::output::exr;
use serde_json::Value;

use super::support::{Render, render};

/// The program in a folder.
fn mlt(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    command.current_dir(folder).args(line.split_whitespace()).output().expect("mlt starts")
}

/// A shell with a limit on what the program may use.
fn mlt_within(folder: &Path, limit: &str, line: &str) -> Output {
    let script = format!("{limit}; exec {} {line}", env!("CARGO_BIN_EXE_mlt"));
    Command::new("sh").current_dir(folder).args(["-c", &script]).output().expect("a shell")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn report(output: &Output) -> Value {
    assert!(output.status.success(), "{}", said(output));
    serde_json::from_slice(&output.stdout).expect("JSON on standard output")
}

/// Of mixtures, b is no better known than the part of it that chains make: `tests/auto.rs` has the statistics.
#[test]
fn the_error_of_b_has_that_of_the_chains() {
    let of_seed = |seed: u32| {
        let line = format!("--size 16x16 --samples-per-pixel 512 --seed {seed} --threads 2");
        let rendered = render("slit/scene.gltf", &line);
        let strata = rendered.report["strata"].as_array().expect("a list").clone();
        let square = |stratum: &Value| stratum["b_stderr"].as_f64().expect("a number").powi(2);
        let of_chains = strata.iter().map(square).sum::<f64>().sqrt();
        (!strata.is_empty()).then(|| rendered.b().1 / of_chains)
    };
    // Sixteen rounds tell an error to a factor of two. It was a twelfth when pixels were taken for independent.
    let ratios: Vec<f64> = (0..6).filter_map(of_seed).collect();
    assert!(!ratios.is_empty() && ratios.iter().all(|ratio| *ratio > 0.4), "{ratios:?}");
}

#[test]
fn a_triangle_far_away_leaves_the_film_its_range() {
    for method in ["auto", "mlt"] {
        let render = render("stray-1e5/scene.gltf", &format!("--size 24x24 --error 5% --method {method}"));
        render.expect_b(0.4112, 0.004);
        assert!(render.report["relative_error"].as_f64().is_some_and(|error| error <= 0.05), "{}", render.report);
        assert!(!render.said.contains("brighter"), "{}", render.said);
    }
}

/// A floor under a lamp; lengths times `scale`, emission `light`, and a triangle so many lengths away.
fn lamp(folder: &Path, scale: f64, light: f64, far: f64) {
    let corners = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]];
    let lamp = [[-0.1, 1.0, -0.1], [0.1, 1.0, -0.1], [0.1, 1.0, 0.1], [-0.1, 1.0, 0.1]];
    let stray = [[far, far, far], [far + 1.0, far, far], [far, far + 1.0, far]];
    let mut text = "mtllib a.mtl\n".to_owned();
    for [x, y, z] in corners.into_iter().chain(lamp).chain(stray) {
        text += &format!("v {} {} {}\n", scale * x, scale * y, scale * z);
    }
    text += "usemtl floor\nf 1 2 3 4\nf 9 10 11\nusemtl lamp\nf 5 6 7 8\n";
    fs::write(folder.join("a.obj"), text).expect("written");
    let material = format!("newmtl floor\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe {light} {light} {light}\n");
    fs::write(folder.join("a.mtl"), material).expect("written");
}

#[test]
fn errors_are_known_at_any_scale_and_brightness() {
    let folder = folder();
    for (scale, light, far) in [(1e-4, 1.0, 2.0), (1e6, 1.0, 2.0), (1.0, 1e-12, 2.0), (1.0, 1e12, 2.0), (1.0, 1.0, 1e4)]
    {
        lamp(folder.path(), scale, light, far);
        let (from, to) = ([0.0, 1.5 * scale, 4.0 * scale], [0.0, 0.5 * scale, 0.0]);
        let point = |[x, y, z]: [f64; 3]| format!("{x},{y},{z}");
        let camera = format!("--camera-from {} --camera-to {} --fov 30", point(from), point(to));
        for method in ["pt", "mlt"] {
            let line =
                format!("render a.obj {camera} --size 16x16 --error 20% --method {method} --threads 2 --json -o a.exr");
            let report = report(&mlt(folder.path(), &line));
            let case = format!("{scale} {light} {far} {method}: {report}");
            assert!(report["relative_error"].as_f64().is_some_and(|error| error > 0.0 && error <= 0.2), "{case}");
            let b = report["b"].as_f64().expect("b") / light;
            assert!((b / 8.08e-4 - 1.0).abs() < 0.2, "{case}");
        }
    }
}

#[test]
fn an_error_that_cannot_be_reached_ends_the_render_with_a_sentence() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/stability/camera-sees-nothing/scene.gltf");
    let folder = folder();
    let black = mlt(folder.path(), &format!("render {} --size 8x8 --error 5% -q -o a.exr", scene.display()));
    assert!(black.status.success() && said(&black).contains("--error 5 % cannot be reached"), "{}", said(&black));
    let few = mlt(folder.path(), "render --size 8x8 --error 0.01% --rounds 9 --method pt -q -o a.exr");
    assert!(said(&few).contains("--error 0.01 % is not reached in 9 rounds"), "{}", said(&few));
    let reached = mlt(folder.path(), "render --size 8x8 --error 50% --method pt -q -o a.exr");
    assert_eq!(said(&reached), "");
}

#[test]
fn one_round_tells_no_error() {
    let folder = folder();
    let line = "render --size 8x8 --mutations-per-pixel 4 --rounds 1 -o a.exr";
    let text = String::from_utf8_lossy(&mlt(folder.path(), line).stdout).into_owned();
    assert!(text.contains("± unknown") && !text.contains("inf"), "{text}");
    let report = report(&mlt(folder.path(), &format!("{line} --json")));
    assert!(report["b"].is_number() && report["b_stderr"].is_null(), "{report}");
    let attributes = exr::read(&folder.path().join("a.exr")).expect("read").attributes;
    assert!(attributes.contains(&("mlt.b_stderr".into(), "unknown".into())), "{attributes:?}");
}

#[test]
fn more_rounds_than_samples_are_refused() {
    let folder = folder();
    for (line, fits) in [
        ("--method pt --samples-per-pixel 1 --rounds 1000", false),
        ("--samples-per-pixel 8 --rounds 9", false),
        ("--method bdpt --samples-per-pixel 0.5", false),
        ("--method bdpt --samples-per-pixel 8 --rounds 8", true),
        ("--method mlt --mutations-per-pixel 1 --rounds 10", true),
    ] {
        let output = mlt(folder.path(), &format!("render {line} --size 8x8 -q -o a.exr"));
        assert_eq!(output.status.code(), Some(if fits { 0 } else { 2 }), "{line}: {}", said(&output));
        assert!(
            fits || said(&output).contains("takes one sample of every pixel at least"),
            "{line}: {}",
            said(&output)
        );
    }
}

/// Samples for each second of the processor with a clock and without.
#[test]
fn a_clock_wastes_no_rounds_of_a_small_image() {
    let folder = folder();
    let rate = |budget: &str| {
        let line = format!("render --method bdpt --size 64x64 --threads 2 --json -o a.exr {budget}");
        let report = report(&mlt(folder.path(), &line));
        let seconds = report["cpu_seconds"].as_f64().expect("a clock");
        (report["samples"].as_f64().expect("samples") / seconds, report["seconds"].as_f64().expect("a clock"))
    };
    let ((timed, seconds), (counted, _)) = (rate("--time 1s"), rate("--samples-per-pixel 64"));
    assert!(timed > 0.5 * counted, "{timed} and {counted} samples per second");
    assert!(seconds > 0.7, "{seconds} s");
}

#[test]
fn bars_are_doubted_where_few_rounds_met_the_light_and_nowhere_else() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/stability");
    let doubted = |scene: &str, method: &str, seed: u32| {
        let folder = folder();
        let scene = scenes.join(scene).join("scene.gltf");
        let line = format!(
            "render {} --method {method} --samples-per-pixel 64 --size 24x24 --seed {seed} --threads 2 -q -o a.exr",
            scene.display()
        );
        let output = mlt(folder.path(), &line);
        assert!(output.status.success(), "{}", said(&output));
        said(&output).contains("cannot be trusted")
    };
    for method in ["auto", "mlt", "pt"] {
        assert!((0..4).all(|seed| !doubted("plain", method, seed)), "{method}");
        assert!((0..2).all(|seed| doubted("gloss", method, seed)), "{method}");
    }
}

#[test]
fn b_is_a_lower_bound_where_samples_hardly_find_the_way_and_nowhere_else() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let bounded = |scene: &str, seed: u32| {
        let folder = folder();
        let line = format!(
            "render {} --method mmlt --mutations-per-pixel 128 --size 24x24 --seed {seed} --threads 2 -q -o a.exr",
            scenes.join(scene).display()
        );
        let output = mlt(folder.path(), &line);
        assert!(output.status.success(), "{}", said(&output));
        said(&output).contains("b is a lower bound")
    };
    assert!((1..4).all(|seed| bounded("door-ajar/door-ajar.gltf", seed)));
    assert!((1..4).all(|seed| !bounded("stability/plain/scene.gltf", seed)));
}

#[cfg(unix)]
#[test]
fn one_file_under_two_names_is_refused() {
    let folder = folder();
    std::os::unix::fs::symlink("a.exr", folder.path().join("link.exr")).expect("linked");
    for names in ["-o a.exr -o ./a.exr", "-o a.exr -o link.exr"] {
        let output = mlt(folder.path(), &format!("render --size 4x4 --samples-per-pixel 1 -q {names}"));
        assert_eq!(output.status.code(), Some(2));
        assert!(said(&output).contains("are the same file"), "{}", said(&output));
    }
    // Alone the link, whose end is missing, is written through.
    assert!(mlt(folder.path(), "render --size 4x4 --samples-per-pixel 1 -q -o link.exr").status.success());
    assert!(fs::symlink_metadata(folder.path().join("link.exr")).expect("there").is_symlink());
    assert!(exr::read(&folder.path().join("a.exr")).is_ok());
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_on_files_leaves_nothing_behind() {
    let folder = folder();
    let output = mlt_within(folder.path(), "ulimit -f 4", "render --size 64x64 --samples-per-pixel 1 -q -o a.exr");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(said(&output).contains("a.exr: cannot be written: File too large"), "{}", said(&output));
    assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);
}

/// CRC-32 of PNG, over a chunk's type and data.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg()))
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// So many times 258 zeros, as zlib writes them at best: 13 bits for each.
fn deflated_zeros(repeats: usize) -> Vec<u8> {
    let mut bits = vec![true, true, false];
    // The literal 0, then matches of 258 bytes at distance 1, then the end, by the fixed codes of RFC 1951.
    let mut put = |code: u32, length: u32| bits.extend((0..length).rev().map(|i| code >> i & 1 == 1));
    put(0b0011_0000, 8);
    (0..repeats).for_each(|_| put(0b1_1000_1010_0000, 13));
    put(0, 7);
    let byte = |bits: &[bool]| bits.iter().enumerate().fold(0, |byte, (i, &bit)| byte | u8::from(bit) << i);
    let length = 1 + 258 * repeats as u64;
    let adler = ((length % 65521) as u32) << 16 | 1;
    [vec![0x78, 0xda], bits.chunks(8).map(byte).collect(), adler.to_be_bytes().to_vec()].concat()
}

#[cfg(target_os = "linux")]
#[test]
fn a_profile_that_inflates_is_skipped() {
    let folder = folder();
    assert!(mlt(folder.path(), "render --size 16x16 --samples-per-pixel 1 -q -o a.png").status.success());
    let mut png = fs::read(folder.path().join("a.png")).expect("there");
    let chunk = [b"iCCPname\0\0".to_vec(), deflated_zeros(2_500_000)].concat();
    let length = (chunk.len() as u32 - 4).to_be_bytes();
    // After the signature and IHDR.
    png.splice(33..33, [length.to_vec(), chunk.clone(), crc(&chunk).to_be_bytes().to_vec()].concat());
    fs::write(folder.path().join("profile.png"), png).expect("written");
    let output = mlt_within(folder.path(), "ulimit -v 400000", "diff a.png profile.png --json");
    assert_eq!(report(&output)[0]["identical"], true);
}

#[test]
fn weights_are_adaptive_unless_power_is_asked_for() {
    let weights = |more: &str| {
        let Render { report, .. } =
            render("slit/scene.gltf", &format!("--size 16x16 --mutations-per-pixel 512 --method mlt {more}"));
        (report["weights"].clone(), report["pilot_mutations"].as_u64())
    };
    assert!(matches!(weights("--strata 2x2"), (Value::String(name), Some(1..)) if name == "adaptive"));
    assert!(matches!(weights("--strata 2x2 --weights power"), (Value::String(name), Some(0)) if name == "power"));
    // One stratum has nothing to share.
    assert!(matches!(weights(""), (_, Some(0))));
}
