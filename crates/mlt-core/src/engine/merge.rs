//! Why two parts of a render cannot be added.

use super::Rounds;
use std::error::Error;
use std::fmt;

/// Why two films cannot be added.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MergeError {
    /// They differ in width and height.
    Sizes([[u32; 2]; 2]),
    /// They differ in the unit of their sums.
    Unit,
    /// They were made of other scenes or with other settings.
    Key {
        /// The property that differs.
        name: String,
        /// Its values.
        values: [String; 2],
    },
    /// Both hold these rounds, which would count twice.
    Rounds(Rounds),
}

impl Error for MergeError {}

impl fmt::Display for MergeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sizes([[w, h], [v, g]]) => {
                write!(f, "one film has {w}x{h} sites and the other {v}x{g}; they are not of one image")
            }
            Self::Unit => write!(f, "the films have different units; they are not of one scene and view"),
            Self::Key { name, values: [a, b] } => {
                write!(f, "{name} is {a} in one and {b} in the other; they are not of one render")
            }
            Self::Rounds(rounds) => write!(f, "both films hold the rounds {rounds}, which would count twice"),
        }
    }
}
