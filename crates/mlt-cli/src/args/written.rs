//! Options written out again: into image files, and as a command line.

use anyhow::Context;
use serde::Serialize;
use serde_json::Value;

/// Names and values of options, sorted by name; those that were not given and have no default are left out.
///
/// The report has lists of what came of some options, and marks the options by the ending `_option`; here they have their own names.
pub fn written(options: &impl Serialize) -> anyhow::Result<Vec<(String, String)>> {
    let value = serde_json::to_value(options).context("cannot write the options out")?;
    let fields = value.as_object().context("options have names")?;
    let pair = |(name, value): (&String, _)| Some((name.trim_end_matches("_option").to_owned(), text(value)?));
    Ok(fields.iter().filter_map(pair).collect())
}

fn text(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(text) => Some(text.clone()),
        Value::Array(parts) => Some(parts.iter().filter_map(text).collect::<Vec<_>>().join(",")),
        other => Some(other.to_string()),
    }
}

/// Such pairs as options of a command line, for a POSIX shell.
pub fn command_line(options: &[(String, String)]) -> Vec<String> {
    let option = |(name, value): &(String, String)| format!("--{}={}", name.replace('_', "-"), shell_word(value));
    options.iter().map(option).collect()
}

/// Such pairs as the words of a command line.
pub fn words(options: &[(String, String)]) -> Vec<String> {
    options.iter().map(|(name, value)| format!("--{}={value}", name.replace('_', "-"))).collect()
}

/// `text` as one word for a POSIX shell.
pub fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./:,+=@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.into() } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::render::RenderOptions;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        options: RenderOptions,
    }

    #[test]
    fn words_survive_the_shell() {
        let words = [("a/b-1.glb", "a/b-1.glb"), ("", "''"), ("my room.glb", "'my room.glb'"), ("it's", r"'it'\''s'")];
        for (text, word) in words {
            assert_eq!(shell_word(text), word);
        }
    }

    #[test]
    fn options_that_are_written_out_are_read_back() {
        let parse = |words: Vec<String>| Line::parse_from([vec!["mlt".to_owned()], words].concat()).options;
        let line = "--strata=4x4,length --weights=power --rounds-pilot=8 --variant=mutation-only --perturbations=lens,caustic \
                    --importance=relative --max-length=5 --seed=7 --size=64x48 --camera-from=-1,2.5,3 --camera-to=0,0,-1 --fov=40 --aperture=f/2.8 --focus=4";
        let options = parse(line.split_whitespace().map(str::to_owned).collect());
        let pairs = [written(&options.transport), written(&options.view)].map(|pairs| pairs.expect("written")).concat();
        assert_eq!(pairs.len(), line.split_whitespace().count());
        assert_eq!(parse(command_line(&pairs)), options);
        let names: Vec<_> =
            written(&parse(vec![]).transport).expect("written").into_iter().map(|pair| pair.0).collect();
        assert_eq!(names, ["importance", "perturbations", "rounds_pilot", "seed", "strata", "variant", "weights"]);
    }
}
