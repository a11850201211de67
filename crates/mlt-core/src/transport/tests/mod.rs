//! Promises of the renderer, one file each.

pub(crate) mod balance;
mod camera;
mod features;
pub(crate) mod paths;
mod rooms;
mod sky;
mod strata;
mod textures;
mod veils;
mod visibility;
pub(crate) mod worlds;
