//! Formats of images, from outside: each tells how it was made, and any goes to standard output.

use std::{fs, path::Path, process::Command};

use mlt_cli::output::{Format, read_image};

const RENDER: &str = "render --size 16x12 --samples-per-pixel 8 --threads 1";

/// Standard output and standard error of a run that succeeds.
fn run(folder: &Path, line: &str) -> (Vec<u8>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_mlt")).current_dir(folder).args(line.split_whitespace()).output();
    let output = output.expect("mlt starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{line}: {said}");
    (output.stdout, said)
}

#[test]
fn every_format_tells_how_it_was_made() {
    let folder = tempfile::tempdir().expect("a folder");
    run(folder.path(), &format!("{RENDER} -o a.exr -o a.hdr -o a.png -o a.jpeg"));
    let command = |name: &str| -> serde_json::Value {
        let facts: serde_json::Value =
            serde_json::from_slice(&run(folder.path(), &format!("info {name} --json")).0).expect("JSON");
        assert_eq!((&facts["image"], &facts["scene"]), (&"16x12".into(), &"cornell".into()), "{name}");
        facts["command"].clone()
    };
    let whole = command("a.exr");
    assert!(whole.as_str().is_some_and(|line| line.contains("--size=16x12")), "{whole}");
    ["a.hdr", "a.png", "a.jpeg"].iter().for_each(|name| assert_eq!(command(name), whole, "{name}"));
    run(folder.path(), "diff a.exr a.hdr a.png a.jpeg");
}

#[test]
fn standard_output_takes_the_image_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    run(folder.path(), &format!("{RENDER} -o a.exr -o a.png -o a.jpg -o a.hdr"));
    for (target, file, format) in [
        ("-", "a.exr", Format::Exr),
        ("png:-", "a.png", Format::Png),
        ("jpg:-", "a.jpg", Format::Jpg),
        ("hdr:-", "a.hdr", Format::Hdr),
    ] {
        let (bytes, said) = run(folder.path(), &format!("{RENDER} -o {target}"));
        assert!(said.contains("written         -"), "{said}");
        let path = folder.path().join("stream");
        fs::write(&path, bytes).expect("written");
        let [stream, named] = [&path, &folder.path().join(file)].map(|path| read_image(path).expect("an image"));
        assert_eq!((stream.1, stream.0.same_bits(&named.0)), (format, true), "{target}");
    }
}
