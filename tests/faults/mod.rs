//! Scenes that once gave a wrong image, a wrong error bar or a refusal, each with its right value.
//!
//! `data/` holds the scenes, a folder each; its README says what each is and where its value comes from.

mod choice;
mod controls;
mod energy;
mod environment;
mod errors;
mod geometry;
mod gltf;
mod obj;
mod opacity;
mod paths;
mod sampler;
mod strata;
mod support;
mod textures;
