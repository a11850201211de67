//! Packages are complete: what is built into a crate lies in its folder, which is all that is published.

use std::{
    fs,
    path::{Component, Path, PathBuf},
};

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

/// The first text in each `include_bytes!` and `include_str!` of a file: a path, or the beginning of one.
fn included(source: &str) -> Vec<&str> {
    source
        .split("include_")
        .skip(1)
        .filter(|rest| rest.starts_with("bytes!(") || rest.starts_with("str!("))
        .map(|rest| rest.split('"').nth(1).expect("a path"))
        .collect()
}

/// Whether a relative path from a file of a crate stays in its folder.
fn stays_inside(file_in_crate: &Path, relative: &str) -> bool {
    let mut depth = file_in_crate.components().count() - 1;
    Path::new(relative).components().all(|component| match component {
        Component::RootDir | Component::Prefix(_) => false,
        Component::ParentDir => depth.checked_sub(1).map(|up| depth = up).is_some(),
        _ => {
            depth += 1;
            true
        }
    })
}

#[test]
fn crates_hold_all_that_is_built_into_them() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crates");
    let mut seen = 0;
    for name in ["mlt-core", "mlt-scene", "mlt-cli"] {
        let folder = crates.join(name);
        for path in sources(&folder.join("src")) {
            let source = fs::read_to_string(&path).expect("text");
            for relative in included(&source) {
                let inside = path.strip_prefix(&folder).expect("inside");
                assert!(relative != "CARGO_MANIFEST_DIR", "{} hides where a file lies", path.display());
                assert!(stays_inside(inside, relative), "{} takes in {relative}", path.display());
                seen += 1;
            }
        }
    }
    assert!(seen >= 5, "{seen}");
    let outside = |relative| !stays_inside(Path::new("src/gallery/mod.rs"), relative);
    assert!(outside("../../../scenes/a.bin") && outside("/scenes/a.bin") && !outside("../../scenes/a.bin"));
}
