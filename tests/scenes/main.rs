//! Scene files: what they give, and how those that are wrong are refused.

mod builtin;
mod fuzz;
mod gallery;
mod gltf;
mod gltf_moving;
mod obj;
mod packages;
mod support;
mod textures;
