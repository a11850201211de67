//! Material libraries: the files, what their statements say to the parser, and where a name is found.

use super::text::{self, Numbered, Reduced, name, unquoted, without_comment, without_remark};
use super::texture;
use crate::{SceneError, source::Source};
use std::collections::{HashMap, HashSet};

/// Statements with a colour that the renderer reads.
const COLOURS: [&str; 4] = ["Kd", "Ks", "Ke", "Tf"];

/// Statements with one number.
const NUMBERS: [&str; 9] = ["Ns", "Ni", "d", "Tr", "Pr", "Pm", "Ps", "Pc", "Pcr"];

/// Materials in the order of their libraries, and where each name in use is found.
#[derive(Clone, Default)]
pub(super) struct Library {
    pub materials: Vec<tobj::Material>,
    /// Of each material: the folder of its library below the scene's, empty or with a slash at its end.
    pub folders: Vec<String>,
    pub places: HashMap<String, usize>,
}

/// All material libraries that a file names; one that cannot be read is a warning.
pub(super) fn read(source: &Source, reduced: &Reduced, warnings: &mut Vec<String>) -> Result<Library, SceneError> {
    let (mut materials, mut folders) = (Vec::new(), Vec::new());
    let (mut seen, mut complete) = (HashSet::new(), true);
    for name in reduced.libraries.iter().flat_map(|rest| files(source, rest)) {
        if !seen.insert(name.clone()) {
            continue;
        }
        match source.read_beside(&name) {
            Ok(bytes) => {
                materials.extend(parse(source, &name, bytes, warnings)?);
                let path = name.replace('\\', "/");
                let folder = path.rsplit_once('/').map_or_else(String::new, |(folder, _)| format!("{folder}/"));
                folders.resize(materials.len(), folder);
            }
            Err(error) => {
                complete = false;
                warnings.push(format!("{error}; until then grey stands in for its materials"));
            }
        }
    }
    let places = places(&materials, reduced);
    let unknown: Vec<_> = reduced.used.iter().filter(|name| !places.contains_key(*name)).cloned().collect();
    if complete && !unknown.is_empty() {
        let names = unknown.join("`, `");
        warnings.push(format!("no material library defines `{names}`; grey stands in"));
    }
    Ok(Library { materials, folders, places })
}

/// The files that an `mtllib` statement names: one with all its blanks, or several, each up to `.mtl` or in quotes, or one a
/// word. The first of these readings is taken of which any file can be read.
fn files(source: &Source, rest: &str) -> Vec<String> {
    let listed = without_comment(rest);
    let words = || listed.split_whitespace().map(str::to_owned).collect();
    let readable = |names: &Vec<String>| names.iter().any(|name| source.read_beside(name).is_ok());
    let readings = [vec![unquoted(rest).to_owned()], listed_files(listed), words()];
    let likely = readings[1].clone();
    readings.into_iter().find(readable).unwrap_or(likely)
}

/// Names in quotes, and others up to each `.mtl`.
fn listed_files(rest: &str) -> Vec<String> {
    let mut names = Vec::new();
    for (i, part) in rest.split('"').enumerate() {
        if i % 2 == 1 {
            names.push(part.trim().to_owned());
            continue;
        }
        let mut open = String::new();
        for word in part.split_whitespace() {
            open += if open.is_empty() { "" } else { " " };
            open += word;
            if word.to_ascii_lowercase().ends_with(".mtl") {
                names.push(std::mem::take(&mut open));
            }
        }
        names.extend((!open.is_empty()).then_some(open));
    }
    names
}

fn parse(
    source: &Source,
    name: &str,
    bytes: Vec<u8>,
    warnings: &mut Vec<String>,
) -> Result<Vec<tobj::Material>, SceneError> {
    let text = readable(&text::decode(bytes), warnings);
    let path = source.path.with_file_name(name);
    let parse = |numbered: &mut Numbered| tobj::load_mtl_buf(numbered).map_err(|e| e.to_string());
    Ok(text::parse(&path, "MTL", &text, parse)?.0)
}

/// Where the names in use are found: as they stand, or without comments.
fn places(materials: &[tobj::Material], reduced: &Reduced) -> HashMap<String, usize> {
    let mut known: HashMap<_, _> = materials.iter().enumerate().map(|(i, m)| (m.name.as_str(), i)).collect();
    for (i, material) in materials.iter().enumerate() {
        known.entry(without_comment(&material.name)).or_insert(i);
    }
    let find = |name: &str| known.get(name).or_else(|| known.get(without_comment(name))).copied();
    reduced.used.iter().filter_map(|name| Some((name.clone(), find(name)?))).collect()
}

/// An MTL text that the parser can read; a statement that says nothing is left out, with a warning.
fn readable(text: &str, warnings: &mut Vec<String>) -> String {
    let (mut readable, mut material) = (String::with_capacity(text.len()), String::new());
    for line in text.lines().map(str::trim) {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if key.eq_ignore_ascii_case("newmtl") {
            material = name(rest);
        }
        match statement(key, rest) {
            Some(statement) => readable += &statement,
            None => warnings.push(format!(
                "material `{material}`: `{}` cannot be read; the default stands in",
                without_remark(line).trim_end()
            )),
        }
        readable.push('\n');
    }
    readable
}

/// A statement with its keyword as the parser spells it and its numbers in full; `None`: it says nothing that can be read.
///
/// One component stands for all three of a colour: MTL's own rule.
fn statement(key: &str, rest: &str) -> Option<String> {
    let spelled = |keys: &[&'static str]| keys.iter().copied().find(|k| k.eq_ignore_ascii_case(key));
    let words: Vec<_> = without_remark(rest).split_whitespace().collect();
    let number = |word: &&str| word.parse::<f64>().ok();
    if let Some(key) = spelled(&COLOURS) {
        return match words.iter().take(3).map(number).collect::<Option<Vec<_>>>()?[..] {
            [grey] => Some(format!("{key} {grey} {grey} {grey}")),
            [r, g, b] => Some(format!("{key} {r} {g} {b}")),
            _ => None,
        };
    }
    if let Some(key) = spelled(&NUMBERS) {
        return Some(format!("{key} {}", words.first().and_then(number)?));
    }
    if let Some(map) = spelled(&texture::READ) {
        return (!rest.trim().is_empty()).then(|| format!("{}{map} {rest}", texture::PREFIX));
    }
    match spelled(&["illum", "newmtl", "Ka", "map_Ka"]) {
        Some("illum") => words.first().and_then(number).map(|model| format!("illum {}", model as u8)),
        Some("newmtl") => Some(format!("newmtl {}", name(rest))),
        // Ambient light is not rendered.
        Some(_) => Some(String::new()),
        None if key.is_empty() || key.starts_with('#') => Some(String::new()),
        None => (!rest.trim().is_empty()).then(|| format!("{key} {rest}")),
    }
}
