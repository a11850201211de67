//! Rooms depend on those below them alone.

use std::fs;
use std::path::{Path, PathBuf};

/// The rooms, from the top to the ground.
const ROOMS: [&str; 10] =
    ["render", "methods", "image", "paths", "lights", "scene", "bsdf", "accel", "geometry", "colour"];

fn floor(room: &str) -> usize {
    ROOMS.iter().position(|&name| name == room).unwrap_or_else(|| panic!("{room} is no room"))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Rooms that are not below its own, but are named by code `depth` modules below the renderer; tests are left out.
fn faults(room: &str, depth: usize, source: &str) -> Vec<String> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = code.lines().map(str::trim).filter(|line| !line.starts_with("//"));
    let names = lines.flat_map(|line| line.split("crate::transport::").skip(1));
    let word =
        |rest: &str| rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default().to_owned();
    let above = names.map(word).filter(|name| name.is_empty() || floor(name) < floor(room));
    let outside = code.contains(&"super::".repeat(depth)).then(|| "what is outside by super".to_owned());
    above.chain(outside).collect()
}

#[test]
fn each_room_names_only_rooms_below_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/transport");
    let mut seen = 0;
    for path in files(&root) {
        let inside = path.strip_prefix(&root).unwrap().with_extension("");
        let modules: Vec<_> = inside.iter().map(|name| name.to_str().unwrap()).filter(|&name| name != "mod").collect();
        let Some(&room) = modules.first().filter(|&&room| room != "tests") else { continue };
        if modules.last() != Some(&"tests") {
            let found = faults(room, modules.len(), &fs::read_to_string(&path).unwrap());
            assert!(found.is_empty(), "{} names {found:?}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 80, "{seen}");
}

#[test]
fn a_name_from_above_is_found() {
    assert_eq!(faults("scene", 2, "use crate::transport::lights::Cell;\nuse super::Scene;"), ["lights"]);
    assert_eq!(faults("scene", 2, "use super::super::lights::Cell;").len(), 1);
    assert_eq!(faults("scene", 2, "fn f(_: crate::transport::paths::Kind) {}"), ["paths"]);
    assert_eq!(faults("methods", 2, "use crate::transport::paths::Kind;\n// crate::transport::render").len(), 0);
    assert_eq!(faults("image", 1, "#[cfg(test)]\nmod tests {\n use crate::transport::render::Renderer;").len(), 0);
}
