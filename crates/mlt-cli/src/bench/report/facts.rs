//! Where the report comes from.

use super::super::study::Study;
use crate::{
    args::{bench::BenchOptions, written::shell_word},
    system,
};

/// Names and values.
pub(super) fn facts(study: &Study, options: &BenchOptions) -> Vec<(&'static str, String)> {
    let budgets: Vec<String> = study.budgets.iter().map(ToString::to_string).collect();
    let mut facts = vec![
        ("Command", command()),
        ("Machine", system::machine()),
        ("Threads", rayon::current_num_threads().to_string()),
        ("Budgets", budgets.join(", ")),
        ("Seeds", format!("1 to {}", study.seeds)),
    ];
    facts.extend(options.max_length.map(|edges| ("Longest path", format!("{edges} edges"))));
    facts
}

/// This process's command, as one would type it again.
fn command() -> String {
    let words = std::env::args_os().skip(1).map(|word| shell_word(&word.to_string_lossy()));
    std::iter::once("mlt".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
