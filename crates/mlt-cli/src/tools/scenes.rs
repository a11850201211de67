//! `mlt scenes`: the scenes that are part of the program.

use anyhow::Context;
use mlt_scene::{BUILTIN, gallery};
use serde_json::json;

use crate::{Failure, args::tools::ScenesOptions, print};

/// Prints the scenes.
pub fn run(options: &ScenesOptions) -> Result<(), Failure> {
    let text = if options.json { as_json()? } else { as_text() };
    Ok(print(&text)?)
}

fn as_json() -> anyhow::Result<String> {
    let builtin = BUILTIN.iter().map(|scene| json!({ "name": scene.name, "about": scene.about, "for": "render" }));
    let gallery =
        gallery::SCENES.iter().map(|s| json!({ "name": s.name, "about": s.stresses, "for": "verify --gallery" }));
    let all: Vec<_> = builtin.chain(gallery).collect();
    Ok(serde_json::to_string_pretty(&all).context("cannot encode the list")? + "\n")
}

fn as_text() -> String {
    let line = |name: &str, about: &str| format!("  {name:<19}  {about}\n");
    let builtin: String = BUILTIN.iter().map(|scene| line(scene.name, scene.about)).collect();
    let gallery: String = gallery::SCENES.iter().map(|scene| line(scene.name, scene.stresses)).collect();
    format!("For 'mlt render NAME':\n{builtin}\nHard ones, for 'mlt verify --gallery -o FOLDER NAME':\n{gallery}")
}
