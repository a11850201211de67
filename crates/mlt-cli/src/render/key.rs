//! The key of a render: everything that decides the bits of its rounds, and the options that give them again.

use mlt_core::engine::Key;

use super::Setup;
use crate::args::{
    render::RenderOptions,
    written::{words, written},
};

/// Names and values of scene and settings: rounds with the same key are of one render and add up.
pub(super) fn key(options: &RenderOptions, setup: &Setup, per_pixel: f64) -> anyhow::Result<Key> {
    let of_render = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("scene file", setup.digest.clone()),
        ("method", options.method().to_string()),
        ("per_pixel_per_round", per_pixel.to_string()),
    ];
    let of_render = of_render.map(|(name, value)| (name.to_owned(), value));
    Ok([of_render.to_vec(), written(&options.reading)?, written(&options.view)?, written(&options.transport)?].concat())
}

/// The words of `mlt render` that stand for the same image, whatever its budget.
pub(super) fn arguments(options: &RenderOptions) -> anyhow::Result<Vec<String>> {
    let of_render = [("method", options.method().to_string()), ("exposure", options.exposure.to_string())]
        .map(|(name, value)| (name.to_owned(), value));
    let pairs = [of_render.to_vec(), written(&options.reading)?, written(&options.view)?, written(&options.transport)?]
        .concat();
    let scene = ["--".to_owned(), options.scene.display().to_string()];
    Ok([words(&pairs), scene.to_vec()].concat())
}
