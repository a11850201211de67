//! A reason not to trust a method.

use serde::{Deserialize, Serialize};

/// Something wrong.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Fault {
    /// In a word: wrong, rounds, b, seeds, unsteady, bars.
    pub word: String,
    /// In a sentence without a full stop.
    pub sentence: String,
}

impl Fault {
    /// From a word and a sentence.
    pub fn new(word: &str, sentence: String) -> Self {
        Self { word: word.to_owned(), sentence }
    }
}
