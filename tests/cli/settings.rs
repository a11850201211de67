//! Options from files (`--config`, `--like`), and files that are there already (`--force`).

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use mlt_cli::{image::Image, output::exr};
use serde_json::Value;
use tempfile::TempDir;

fn run(folder: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlt"));
    command.current_dir(folder).arg("render").args(line.split_whitespace()).output().expect("mlt starts")
}

fn report(folder: &TempDir, line: &str) -> Value {
    let output = run(folder.path(), &format!("{line} --json"));
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn refused(folder: &TempDir, config: &str, line: &str) -> String {
    fs::write(folder.path().join("bad.toml"), config).expect("written");
    let output = run(folder.path(), &format!("--config bad.toml {line}"));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{config}: {message}");
    assert!(message.lines().count() == 1, "{message}");
    message
}

fn with_config(config: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("render.toml"), config).expect("written");
    folder
}

const CONFIG: &str = "file = \"ring\"\nspp = 4\nsize = \"24x16\"\nseed = 3\noutput = [\"a.exr\", \"b.exr\"]\n\
                      camera-from = [0, 2.5, 4]\ncamera_to = [0, 0, 0]\nquiet = false\nthreads = 1\nmethod = 'pt'\n";

#[test]
fn a_file_gives_options_and_the_command_line_wins() {
    let folder = with_config(CONFIG);
    let found = report(&folder, "--config render.toml");
    for (name, value) in [("scene", "ring"), ("method", "pt")] {
        assert_eq!(found[name], value);
    }
    for (name, value) in [("width", 24), ("height", 16), ("seed", 3), ("rounds", 4), ("threads", 1)] {
        assert_eq!(found[name], value, "{name}");
    }
    assert_eq!(found["outputs"], serde_json::json!(["a.exr", "b.exr"]));
    assert_eq!(found["camera"]["origin"], "by --camera-from and --camera-to");

    // Another budget, the whole size by half of it, another camera, other files.
    let found = report(
        &folder,
        "cornell --config render.toml --error 50% --width 8 --height 8 --camera camera --seed 9 -o c.exr",
    );
    assert_eq!((&found["scene"], &found["seed"], &found["width"]), (&"cornell".into(), &9.into(), &8.into()));
    assert_eq!(found["camera"]["origin"], "by --camera");
    assert_eq!(found["outputs"], serde_json::json!(["c.exr"]));
    assert_eq!(found["rounds"], 8);
}

#[test]
fn what_a_file_cannot_say_is_refused_by_its_name() {
    let folder = with_config("");
    for (config, part) in [
        ("tiem = '3s'", "bad.toml: there is no option tiem; did you mean time?"),
        ("widthh = 3", "did you mean width?"),
        ("zzzz = 3", "the long options of 'mlt render --help'"),
        ("time = 30", "bad.toml: invalid value '30' for '--time <TIME>'"),
        ("time = '3s'\nerror = '2%'", "bad.toml: the argument '--error <ERROR>' cannot be used with '--time"),
        ("size = '8x8\n", "bad.toml: line 1"),
        ("json = 3", "json is true or false"),
        ("time = true", "time needs a value"),
        ("time = { s = 3 }", "time: give a text, a number, or a list of them"),
        ("config = 'other.toml'", "config belongs on the command line"),
    ] {
        let message = refused(&folder, config, "-s 4x4 --spp 2 -q");
        assert!(message.contains(part), "{config}: {message}");
    }
    assert!(refused(&folder, "", "--like none.exr").contains("none.exr"));
    let output = run(folder.path(), "--config none.toml");
    assert!(String::from_utf8_lossy(&output.stderr).contains("none.toml: cannot be read"));
}

#[test]
fn an_image_gives_the_options_that_it_was_made_with() {
    let folder = with_config("");
    let pixels = |name: &str| exr::read(&folder.path().join(name)).expect("an EXR").image;
    let line = "ring --method mlt --strata 2x2 --mutations-per-pixel 8 --rounds 4 --seed 5 -s 20x12 --environment 1,1,1 \
                --exposure 1 -j1 -q -o a.exr";
    report(&folder, line);
    report(&folder, "--like a.exr -o again.exr -j1");
    assert!(pixels("a.exr").same_bits(&pixels("again.exr")));
    report(&folder, "--like a.exr -o other.exr -j1 --seed 6");
    assert!(!pixels("a.exr").same_bits(&pixels("other.exr")), "the control");

    let found = report(&folder, "--like a.exr --mutations-per-pixel 4 --method pssmlt -o b.exr -j1");
    assert_eq!((&found["scene"], &found["method"], &found["rounds"]), (&"ring".into(), &"pssmlt".into(), &16.into()));
    assert_eq!((&found["width"], &found["height"]), (&20.into(), &12.into()));

    // The command line before the file, the file before the image.
    fs::write(folder.path().join("render.toml"), "seed = 7\nsize = '10x10'\n").expect("written");
    let found = report(&folder, "--like a.exr --config render.toml -s 6x6 --spp 4 -o b.exr -j1");
    assert_eq!((&found["seed"], &found["width"], &found["strata_option"]), (&7.into(), &6.into(), &"2x2".into()));

    let output = run(folder.path(), "--like render.toml");
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("error: render.toml: "));
}

/// An image of somebody else decides how it looks, and not which files are written.
#[test]
fn an_image_names_no_files_to_write() {
    let folder = with_config("");
    let command =
        "mlt render cornell --size=6x6 --samples-per-pixel 2 --output=evil.exr --checkpoint=evil.mltp --force=true";
    let image = Image::new(1, 1, vec![[0.5; 3]]).expect("a pixel");
    let bytes = exr::encode(&image, None, &[("mlt.command".to_owned(), command.to_owned())]).expect("encoded");
    fs::write(folder.path().join("a.exr"), bytes).expect("written");
    let found = report(&folder, "--like a.exr -j1");
    assert_eq!((&found["width"], &found["outputs"]), (&6.into(), &serde_json::json!(["cornell.exr", "cornell.png"])));
}

#[test]
fn only_files_of_others_need_force() {
    let folder = with_config("");
    let outputs = "-o a.exr -o a.hdr -o a.png -o a.jpg -o a.mltp --preview p.png";
    let line = format!("cornell -s 8x8 --spp 4 -j1 -q {outputs}");
    let again = |line: &str| run(folder.path(), line);
    for _ in 0..2 {
        let output = again(&line);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    for name in ["a.exr", "a.hdr", "a.png", "a.jpg", "a.mltp", "p.png"] {
        let (path, own) = (folder.path().join(name), fs::read(folder.path().join(name)).expect("written"));
        fs::write(&path, "a photograph").expect("written");
        let output = again(&line);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {message}");
        assert!(message.contains(&format!("{name}: is there already")) && message.contains("--force"), "{message}");
        assert_eq!(fs::read(&path).expect("kept"), b"a photograph");
        assert!(again(&format!("{line} --force")).status.success(), "{name}");
        assert_ne!(fs::read(&path).expect("written"), b"a photograph");
        fs::write(&path, own).expect("written");
    }
}
