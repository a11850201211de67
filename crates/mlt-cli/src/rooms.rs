//! Modules depend on those below them alone.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// The modules, from the top to the ground; those of one floor do not name each other.
const FLOORS: [&[&str]; 10] = [
    &["farm", "verify"],
    &["bench"],
    &["merge", "info", "inspect"],
    &["render", "diff", "tools"],
    &["report"],
    &["args"],
    &["output"],
    &["kept", "denoise", "exit"],
    &["provenance", "progress", "image", "interrupt", "system"],
    &["log", "terminal", "atomic"],
];

/// Files that no module names: the program, the library's root, and this test.
const ROOTS: [&str; 3] = ["main", "lib", "rooms"];

fn floor(module: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&module))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// The modules that code names by `crate::`, its tests left out.
fn named(source: &str) -> BTreeSet<String> {
    let code = source.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    lines.split("crate::").skip(1).flat_map(first_words).filter(|word| floor(word).is_some()).collect()
}

/// The first word of a path, or of each path in a list of them.
fn first_words(paths: &str) -> Vec<String> {
    let (mut depth, mut words) = (0, vec![String::new()]);
    let mut fresh = true;
    for c in paths.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => {
                words.push(String::new());
                fresh = true;
            }
            c if fresh && (c.is_alphanumeric() || c == '_') && depth < 2 => {
                words.last_mut().expect("a word").push(c);
                continue;
            }
            c if c.is_whitespace() && words.last().is_some_and(String::is_empty) => {}
            _ => fresh = false,
        }
        if depth == 0 && c != '{' {
            break;
        }
    }
    words
}

#[test]
fn each_module_names_only_modules_below_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut seen = 0;
    for path in files(&root) {
        let inside = path.strip_prefix(&root).expect("inside").with_extension("");
        let module = inside.iter().next().and_then(|name| name.to_str()).expect("a name").to_owned();
        if ROOTS.contains(&module.as_str()) {
            continue;
        }
        let own = floor(&module).unwrap_or_else(|| panic!("{module} has no floor"));
        let names = named(&fs::read_to_string(&path).expect("read"));
        let above: Vec<_> = names.iter().filter(|name| **name != module && floor(name) <= Some(own)).collect();
        assert!(above.is_empty(), "{} names {above:?}", path.display());
        seen += 1;
    }
    assert!(seen > 60, "{seen}");
}

#[test]
fn a_name_from_above_is_found() {
    let words = |source: &str| named(source).into_iter().collect::<Vec<_>>().join(" ");
    assert_eq!(words("use crate::render::Plan;"), "render");
    assert_eq!(
        words("use crate::{\n    Failure,\n    args::{kept::Shard, merge::A},\n    output::{self},\n};\nuse std::fmt;"),
        "args output"
    );
    assert_eq!(words("fn f(_: crate::report::Report) {}\n// crate::farm\n"), "report");
}
