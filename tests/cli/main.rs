//! The program as its users run it.

mod bench;
mod bench_browser;
mod diff;
mod farm;
#[path = "../faults/mod.rs"]
mod faults;
mod formats;
mod frames;
mod inspect;
#[cfg(unix)]
mod interrupt;
mod kills;
mod many_parts;
mod progress;
mod render;
mod resume;
mod seeing;
mod settings;
mod usage;
mod verify;
mod verify_controls;
mod verify_gallery;
mod verify_pool;
