//! Options of a render from a TOML file.

use std::{fs, path::Path};

use anyhow::{Context, anyhow, bail};
use toml::Value;

use super::Setting;

/// The settings of a TOML file.
pub(super) fn settings(path: &Path) -> anyhow::Result<Vec<Setting>> {
    let text = fs::read_to_string(path).context("cannot be read")?;
    let table: toml::Table = toml::from_str(&text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        anyhow!("line {}: {}", before.matches('\n').count() + 1, error.message().replace('\n', ", "))
    })?;
    let setting = |(name, value): (String, Value)| match value {
        Value::Boolean(false) => Ok(None),
        Value::Boolean(true) => Ok(Some((name, Vec::new()))),
        Value::Array(values) => {
            let values = values.iter().map(|value| scalar(&name, value)).collect::<anyhow::Result<_>>()?;
            Ok(Some((name, values)))
        }
        value => scalar(&name, &value).map(|value| Some((name, vec![value]))),
    };
    table.into_iter().map(setting).filter_map(Result::transpose).collect()
}

fn scalar(name: &str, value: &Value) -> anyhow::Result<String> {
    match value {
        Value::String(text) => Ok(text.clone()),
        Value::Integer(number) => Ok(number.to_string()),
        Value::Float(number) => Ok(number.to_string()),
        _ => bail!("{name}: give a text, a number, or a list of them"),
    }
}
