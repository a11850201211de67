//! The engine as a user holds it.

#[cfg(feature = "transport")]
mod allocation;
mod toy;
