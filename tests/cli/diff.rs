//! `mlt diff`, from outside: figures, formats, and what it says about files that it cannot use.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use mlt_cli::{
    image::Image,
    output::{exr, png},
};
use serde_json::Value;
use tempfile::TempDir;

fn mlt(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mlt")).current_dir(folder).args(arguments).output().expect("mlt starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).expect("JSON on standard output")
}

/// A folder with grey images, each named NAME.exr with one luminance a pixel, 4 pixels wide and 2 high.
fn folder_with(images: &[(&str, [f32; 8])]) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, values) in images {
        let image = Image::new(4, 2, values.map(|value| [value; 3]).to_vec()).expect("eight pixels");
        write(folder.path().join(format!("{name}.exr")), &exr::encode(&image, None, &[]).expect("encoded"));
    }
    folder
}

fn write(path: PathBuf, bytes: &[u8]) {
    fs::write(path, bytes).expect("written");
}

fn assert_near(found: &Value, expected: f64) {
    let found = found.as_f64().expect("a number");
    assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} is not {expected}");
}

/// Every pixel a = 2, b = 2.5: (a-b)² = 0.25.
#[test]
fn each_measure_has_its_closed_form() {
    let folder = folder_with(&[("a", [2.0; 8]), ("b", [2.5; 8])]);
    let list = json(&mlt(folder.path(), &["diff", "a.exr", "b.exr", "a.exr", "--json"]));
    assert_eq!(list.as_array().map(Vec::len), Some(2));
    let (different, same) = (&list[0], &list[1]);
    assert_eq!(different["image"], "b.exr");
    assert_near(&different["relative_diff"], 0.25 / 2.0);
    assert_near(&different["rel_mse"], 0.25 / 4.01);
    assert_near(&different["mape"], 0.25);
    assert_near(&different["mean_ratio"], 1.25);
    assert_eq!(different["identical"], false);
    assert!(different["flip"].as_f64().expect("a number") > 0.01);

    assert_eq!(same["identical"], true);
    for name in ["relative_diff", "rel_mse", "mape", "flip"] {
        assert_eq!(same[name], 0.0, "{name}");
    }
    assert_near(&same["mean_ratio"], 1.0);
}

#[test]
fn one_bit_of_difference_is_not_identical() {
    let folder = folder_with(&[("a", [1.0; 8]), ("b", [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.000_000_1])]);
    assert_eq!(json(&mlt(folder.path(), &["diff", "a.exr", "b.exr", "--json"]))[0]["identical"], false);
}

#[test]
fn a_table_is_printed_for_people() {
    let folder = folder_with(&[("a", [2.0; 8]), ("b", [2.5; 8])]);
    let output = mlt(folder.path(), &["diff", "a.exr", "b.exr"]);
    let text = String::from_utf8_lossy(&output.stdout);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 2, "{text}");
    assert!(lines[0].contains("relativeDiff") && lines[1].contains("1.2500e-1") && lines[1].ends_with("no"), "{text}");
}

#[test]
fn png_and_exr_of_one_image_agree_up_to_rounding() {
    let values = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.75, 1.0];
    let folder = folder_with(&[("a", values)]);
    let image = Image::new(4, 2, values.map(|value| [value; 3]).to_vec()).expect("eight pixels");
    write(folder.path().join("a.png"), &png::encode(&image, 0.0, &[]).expect("encoded"));
    let found = &json(&mlt(folder.path(), &["diff", "a.exr", "a.png", "--json"]))[0];
    assert!(found["rel_mse"].as_f64().expect("a number") < 1e-4, "{found}");
    assert!((found["mean_ratio"].as_f64().expect("a number") - 1.0).abs() < 5e-3, "{found}");
    let flip = &json(&mlt(folder.path(), &["diff", "a.png", "a.png", "--json"]))[0]["flip"];
    assert_eq!(flip, 0.0);
}

#[test]
fn a_black_reference_has_no_mean_ratio() {
    let folder = folder_with(&[("black", [0.0; 8]), ("grey", [0.5; 8])]);
    let found = &json(&mlt(folder.path(), &["diff", "black.exr", "grey.exr", "--json"]))[0];
    assert!(found["mean_ratio"].is_null(), "{found}");
    assert_near(&found["relative_diff"], 250.0);
    assert!(found["flip"].as_f64().expect("a number") > 0.1);
}

/// Runs `mlt diff good.exr BAD`: exit code 1, nothing on standard output, one sentence that names the file.
fn refused(folder: &TempDir, bad: &str) -> String {
    let output = mlt(folder.path(), &["diff", "good.exr", bad]);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(output.stdout.is_empty());
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(text.starts_with(&format!("error: {bad}: ")), "{text}");
    text
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = folder_with(&[("good", [1.0; 8])]);
    let whole = fs::read(folder.path().join("good.exr")).expect("read");
    write(folder.path().join("cut.exr"), &whole[..whole.len() - 3]);
    write(folder.path().join("text.png"), b"this is a text\n");
    write(folder.path().join("empty.exr"), b"");
    fs::create_dir(folder.path().join("folder.exr")).expect("created");
    assert!(refused(&folder, "none.exr").contains("No such file"));
    assert!(refused(&folder, "cut.exr").contains("cannot be read as OpenEXR"));
    assert!(refused(&folder, "text.png").contains("neither an OpenEXR nor a Radiance HDR, PNG or JPEG file"));
    refused(&folder, "empty.exr");
    refused(&folder, "folder.exr");
}

#[test]
fn images_that_cannot_be_compared_are_named() {
    let folder = folder_with(&[("good", [1.0; 8]), ("nan", [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, f32::NAN, 1.0])]);
    let small = Image::new(3, 2, vec![[1.0; 3]; 6]).expect("six pixels");
    write(folder.path().join("small.exr"), &exr::encode(&small, None, &[]).expect("encoded"));
    assert!(refused(&folder, "nan.exr").contains("pixel (2, 1) is NaN or infinite"));
    assert!(refused(&folder, "small.exr").contains("3x2 pixels, but the reference good.exr has 4x2"));
}

/// A PNG of 65 bytes can claim any size: it has to be refused before memory is taken for its pixels.
#[test]
fn a_small_file_that_claims_a_huge_image_is_refused() {
    let folder = folder_with(&[("good", [1.0; 8])]);
    for (name, side) in [("huge.png", 60_000_u32), ("huger.png", 2_000_000_000)] {
        write(folder.path().join(name), &png_header(side));
        refused(&folder, name);
    }
}

/// Signature, header chunk and the start of a data chunk of a square PNG with 8-bit colours.
fn png_header(side: u32) -> Vec<u8> {
    let mut header = b"IHDR".to_vec();
    header.extend([side.to_be_bytes(), side.to_be_bytes()].concat());
    header.extend([8, 2, 0, 0, 0]);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    for chunk in [header, b"IDAT\x78\x9c\x63\x00\x00".to_vec()] {
        file.extend((chunk.len() as u32 - 4).to_be_bytes());
        file.extend(&chunk);
        file.extend(crc32(&chunk).to_be_bytes());
    }
    file
}

/// CRC-32 of ISO 3309, as in PNG.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_is_no_error() {
    use std::process::Stdio;
    let folder = folder_with(&[("a", [2.0; 8])]);
    for arguments in [vec!["diff", "a.exr", "a.exr", "--json"], vec!["diff", "a.exr", "a.exr"], vec!["--help"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_mlt"))
            .current_dir(folder.path())
            .args(&arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("mlt starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("mlt ends");
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()), "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error() {
    let folder = folder_with(&[("a", [2.0; 8])]);
    let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("a full device");
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    let command = command.current_dir(folder.path()).args(["diff", "a.exr", "a.exr"]);
    let output = command.stdout(full).output().expect("mlt starts");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).starts_with("error: cannot write to standard output: "), "{}", stderr(&output));
}
