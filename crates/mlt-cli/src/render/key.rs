//! What decides the bits of a render's rounds.

use mlt_core::engine::Key;

use super::Setup;
use crate::args::{render::RenderOptions, values::Size, view::ViewOptions, written::written};

/// Options of the view, with the size that the image has.
pub fn view(options: &RenderOptions, [width, height]: [usize; 2]) -> ViewOptions {
    ViewOptions { size: Some(Size { width, height }), ..options.view.clone() }
}

/// Names and values of scene and settings: rounds with the same key are of one render and add up.
pub fn key(options: &RenderOptions, setup: &Setup, per_pixel: f64) -> anyhow::Result<Key> {
    let view = view(options, setup.camera.size().map(|n| n as usize));
    let of_render = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("scene file", setup.digest.clone()),
        ("method", options.method().to_string()),
        ("per_pixel_per_round", per_pixel.to_string()),
    ];
    let of_render = of_render.map(|(name, value)| (name.to_owned(), value));
    Ok([of_render.to_vec(), written(&options.reading)?, written(&view)?, written(&options.transport)?].concat())
}
