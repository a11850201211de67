//! Scenes that are asked for and not there.

use crate::{builtin::BUILTIN, names::meant, text::shown};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Extensions of scene files.
pub const SCENE_EXTENSIONS: [&str; 3] = ["gltf", "glb", "obj"];
/// Most entries of a folder that are looked at.
const MOST_ENTRIES: usize = 4096;

/// Whether a file is a scene by its name.
pub fn is_scene_file(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| SCENE_EXTENSIONS.contains(&&*extension))
}

/// A question after the scene that was meant by a path that leads to none, or else what is in its folder; it goes on by a semicolon.
pub(crate) fn hint(path: &Path) -> String {
    let folder = path.parent().unwrap_or(Path::new(""));
    let found = scenes_in(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let files: Vec<_> = found.iter().map(|file| folder.join(file).to_string_lossy().into_owned()).collect();
    let stems: Vec<_> =
        files.iter().map(|file| Path::new(file).with_extension("").to_string_lossy().into_owned()).collect();
    let name = path.to_string_lossy();
    // A name without an extension may stand for a file with one.
    let of_stem = || stems.iter().position(|stem| *stem == name).map(|at| files[at].as_str());
    let builtin = BUILTIN.iter().map(|scene| scene.name);
    let names: Vec<_> = files.iter().chain(&stems).map(String::as_str).chain(builtin).collect();
    let of_likeness =
        || meant(&name, &names).map(|name| stems.iter().position(|stem| stem == name).map_or(name, |at| &files[at]));
    match of_stem().or_else(of_likeness) {
        Some(other) => format!("did you mean {}? ", shown(other)),
        None => String::new(),
    }
}

/// Names of the scene files in a folder, sorted.
fn scenes_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().take(MOST_ENTRIES).flatten();
    let mut found: Vec<_> =
        entries.map(|entry| PathBuf::from(entry.file_name())).filter(|name| is_scene_file(name)).collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_that_was_meant_is_asked_for() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["kitchen.glb", "room.obj", "notes.txt"] {
            fs::write(folder.path().join(name), "").expect("written");
        }
        let of = |name: &str| hint(&folder.path().join(name));
        let meant = |name: &str| format!("did you mean {}? ", shown(&folder.path().join(name).to_string_lossy()));
        for name in ["kitchen", "kitchen.gltf", "kichen.glb", "Kitchen.glb"] {
            assert_eq!(of(name), meant("kitchen.glb"), "{name}");
        }
        assert_eq!(hint(Path::new("corneel")), "did you mean cornell? ");
        assert_eq!(hint(Path::new("zzzzzzz.glb")), "");
    }
}
