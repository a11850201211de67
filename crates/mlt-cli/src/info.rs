//! `mlt info`: what a file of a render holds.

use std::path::Path;

use anyhow::Context;
use mlt_core::engine::Key;
use mlt_scene::printable;

use crate::{
    Failure,
    args::{merge::InfoOptions, written::shell_word},
    kept::{Kept, pilot::Pilot, read, words},
    output::{self, Format},
    print,
};

/// Bytes of the checksum that sums end with.
const SUM: usize = 32;

/// Names and values of what a file holds.
type Facts = Vec<(String, String)>;

/// Prints what the file holds.
pub fn run(options: &InfoOptions) -> Result<(), Failure> {
    let path = &options.file;
    let format = Format::of_file(path).with_context(|| path.display().to_string()).map_err(Failure::Usage)?;
    let facts = match format {
        Format::Sums => of_sums(&read(path)?),
        Format::Pilot => of_pilot(&Pilot::read(path).map_err(Failure::Usage)?),
        _ => of_image(path, format).map_err(Failure::Usage)?,
    };
    let text = if options.json {
        let object: serde_json::Map<_, _> = facts.into_iter().map(|(name, value)| (name, value.into())).collect();
        serde_json::to_string_pretty(&object).context("cannot encode the answer")? + "\n"
    } else {
        facts.iter().map(|(name, value)| printable(&format!("{name:<20}  {value}"), usize::MAX) + "\n").collect()
    };
    Ok(print(&text)?)
}

fn of_sums(kept: &Kept) -> Facts {
    let (about, held) = (&kept.about, kept.sums.rounds());
    let command = about.arguments.iter().map(|word| shell_word(word)).collect::<Vec<_>>().join(" ");
    let [width, height] = kept.sums.film().size();
    let facts = [
        ("kind", "exact sums of rounds, for 'mlt merge' and 'mlt render --resume'".to_owned()),
        ("image", format!("{width}x{height}")),
        ("scene", about.provenance.scene.clone()),
        ("command", format!("mlt render {command}")),
        ("rounds", held.to_string()),
        ("rounds_of_render", about.whole.as_ref().map_or_else(|| "as many as time or error allow".into(), words)),
        ("seconds", about.spent.clock.as_secs_f64().to_string()),
        ("checksum", checksum(kept)),
    ];
    let facts = facts.map(|(name, value)| (name.to_owned(), value));
    facts.into_iter().chain(of_key(kept.sums.key())).collect()
}

/// BLAKE3 of the sums: the same for the same bits, whatever the time that they took.
fn checksum(kept: &Kept) -> String {
    let bytes = kept.sums.to_bytes();
    bytes[bytes.len() - SUM..].iter().map(|byte| format!("{byte:02x}")).collect()
}

fn of_pilot(pilot: &Pilot) -> Facts {
    let kind = ("kind".to_owned(), "what a pilot found, for 'mlt render --pilot'".to_owned());
    std::iter::once(kind).chain(of_key(&pilot.key)).collect()
}

/// The scene and options that a render's rounds depend on.
fn of_key(key: &Key) -> impl Iterator<Item = (String, String)> {
    key.iter().map(|(name, value)| (format!("key.{name}"), value.clone()))
}

fn of_image(path: &Path, format: Format) -> anyhow::Result<Facts> {
    let ([width, height], attributes) = output::read_attributes(path, format)?;
    let of_ours = |(name, value): &(String, String)| Some((name.strip_prefix("mlt.")?.to_owned(), value.clone()));
    let facts = [
        ("kind".to_owned(), format!("{} image", format.in_words())),
        ("image".to_owned(), format!("{width}x{height}")),
    ];
    Ok(facts.into_iter().chain(attributes.iter().filter_map(of_ours)).collect())
}
