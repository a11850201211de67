//! The program as its users run it.

mod bench;
mod bench_browser;
mod diff;
mod farm;
mod formats;
mod frames;
mod inspect;
#[cfg(unix)]
mod interrupt;
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
