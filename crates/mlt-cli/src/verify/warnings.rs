//! Warnings of many renders, each counted once for those that differ in figures alone.

use std::collections::BTreeMap;

/// Warnings, and how often each was given. Those with the same words are one, with a range where their figures differ: "16 to 24 rounds".
pub(super) fn counted<'a>(warnings: impl Iterator<Item = &'a String>) -> BTreeMap<String, usize> {
    let mut groups: BTreeMap<Vec<&str>, Vec<Vec<&str>>> = BTreeMap::new();
    for warning in warnings {
        let (words, figures) = parted(warning);
        groups.entry(words).or_default().push(figures);
    }
    let mut counts = BTreeMap::new();
    for (words, figures) in groups {
        *counts.entry(joined(&words, &figures)).or_insert(0) += figures.len();
    }
    counts
}

/// The words of a text, and the figures between them.
fn parted(text: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut words, mut figures) = (Vec::new(), Vec::new());
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let length = length_of_figure(&rest[start..]);
        words.push(&rest[..start]);
        figures.push(&rest[start..start + length]);
        rest = &rest[start + length..];
    }
    words.push(rest);
    (words, figures)
}

/// Bytes of the number that a text begins with: digits, with a part after the point, and a power of ten.
fn length_of_figure(text: &str) -> usize {
    let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let mut length = digits(0);
    for marks in [&["."][..], &["e-", "e"]] {
        let mark = marks.iter().find(|mark| text[length..].starts_with(**mark) && digits(length + mark.len()) > 0);
        if let Some(mark) = mark {
            length += mark.len() + digits(length + mark.len());
        }
    }
    length
}

/// The words with the figures between them, from the least to the largest of each.
fn joined(words: &[&str], figures: &[Vec<&str>]) -> String {
    let mut text = String::new();
    for (i, word) in words.iter().enumerate() {
        text += word;
        if i + 1 < words.len() {
            text += &range(figures.iter().map(|figures| figures[i]));
        }
    }
    text
}

fn range<'a>(figures: impl Iterator<Item = &'a str> + Clone) -> String {
    let value = |figure: &&str| figure.parse().unwrap_or(f64::INFINITY);
    let by_value = |a: &&str, b: &&str| value(a).total_cmp(&value(b));
    match (figures.clone().min_by(by_value), figures.max_by(by_value)) {
        (Some(least), Some(most)) if value(&least) < value(&most) => format!("{least} to {most}"),
        (least, _) => least.unwrap_or_default().into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(warnings: &[&str]) -> Vec<(String, usize)> {
        let warnings: Vec<String> = warnings.iter().map(|warning| (*warning).to_owned()).collect();
        counted(warnings.iter()).into_iter().collect()
    }

    #[test]
    fn figures_of_all_renders_stand_in_a_sentence() {
        let rounds = "the error is estimated from 8 rounds only; take 16 or more to trust it";
        assert_eq!(count(&[rounds, rounds]), [(rounds.to_owned(), 2)]);
        let shares = ["one round brought 9 % of the light", "one round brought 12 % of the light"];
        assert_eq!(count(&[shares[1], shares[0], shares[1]]), [("one round brought 9 to 12 % of the light".into(), 3)]);
        assert_eq!(count(&["R-hat 1.2 in 8x8", "R-hat 1.15 in 8x8."]).len(), 2);
        assert_eq!(count(&["1.5, 3.", "1.25, 3.", "1.25, 3."]), [("1.25 to 1.5, 3.".into(), 3)]);
        assert_eq!(count(&["2e-3 lost", "5e4 lost"]), [("2e-3 to 5e4 lost".into(), 2)]);
        assert_eq!(count(&["no figure", "no figure", ""]), [(String::new(), 1), ("no figure".into(), 2)]);
    }
}
