//! Commands that describe the program itself.

pub mod completions;
pub mod man;
pub mod scenes;
