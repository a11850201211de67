//! One small render of the Cornell box, the same every time: what the check of instruction counts runs.
//!
//! `fixed_render METHOD`, METHOD one of pt, bdpt, mlt, mmlt, pssmlt; `fixed_render none` stops before the render.

use mlt_benches::Loaded;
use mlt_core::transport::render::{Method, Renderer};
use std::ops::ControlFlow;

fn main() {
    let name = std::env::args().nth(1).unwrap_or_default();
    let (method, per_pixel) = match name.as_str() {
        "pt" => (Method::Path, 4.0),
        "bdpt" => (Method::Bidirectional, 1.0),
        "mlt" => (Method::Metropolis, 8.0),
        "mmlt" => (Method::Multiplexed, 4.0),
        "pssmlt" => (Method::PrimaryBidirectional, 1.0),
        _ => (Method::Path, 0.0),
    };
    let loaded = Loaded::builtin("cornell", [64, 64]);
    let settings = loaded.settings(method, per_pixel).with(|s| s.max_edges = Some(6));
    let renderer = Renderer::new(loaded.view(), settings);
    let mut sums = renderer.sums();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let rounds = if per_pixel > 0.0 { 0..4 } else { 0..0 };
    one.install(|| renderer.render(rounds, &mut sums, &mut |_, _: &_| ControlFlow::Continue(())));
    println!("{name}: {} rays", sums.tally().rays());
}
