//! Names that are asked for and not there.

use crate::text::shown;

/// Names that a message lists at most.
const LISTED: usize = 8;
/// Similarity (1 − edits over letters) from which one name may have been meant for another.
const SIMILAR: f64 = 0.6;

/// The one of `names` that someone who wrote `name` may have meant.
pub fn meant<'a>(name: &str, names: &[&'a str]) -> Option<&'a str> {
    let likeness = |other: &&str| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), &other.to_lowercase());
    let nearest = names.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    nearest.filter(|other| likeness(other) >= SIMILAR).copied()
}

/// An answer to someone who asked for `name` where only `names` are: the one that was meant, and those that there are.
pub fn instead_of(name: &str, names: &[&str]) -> String {
    if names.is_empty() {
        return "it has none with a name".to_owned();
    }
    let question = meant(name, names).map_or_else(String::new, |other| format!("did you mean \"{}\"? ", shown(other)));
    let listed: Vec<_> = names.iter().take(LISTED).map(|name| format!("\"{}\"", shown(name))).collect();
    let more = if names.len() > LISTED { format!(" and {} more", names.len() - LISTED) } else { String::new() };
    format!("{question}it has {}{more}", listed.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_that_was_meant_is_offered() {
        assert_eq!(instead_of("Camra", &["Camera", "Sun"]), "did you mean \"Camera\"? it has \"Camera\", \"Sun\"");
        assert_eq!(instead_of("x", &["Camera"]), "it has \"Camera\"");
        assert_eq!(instead_of("x", &[]), "it has none with a name");
        let many: Vec<_> = (0..10).map(|i| format!("a{i}")).collect();
        let many: Vec<_> = many.iter().map(String::as_str).collect();
        assert!(instead_of("z", &many).ends_with("\"a7\" and 2 more"));
    }
}
