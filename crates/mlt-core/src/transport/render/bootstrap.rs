//! How many independent samples chains get for b̂_j and their starts.

use super::super::path::View;

/// Mutations for one independent sample where both are a bidirectional sample.
pub(super) const BIDIRECTIONAL_MUTATIONS_A_SAMPLE: u64 = 8;
/// The same where both are a path. Most random paths are dark, so b̂_j takes many.
pub(super) const MULTIPLEXED_MUTATIONS_A_SAMPLE: u64 = 4;
/// Pixels of images that these are made for; larger ones need fewer samples.
const PIXELS: f64 = 4096.0;

/// Mutations for one independent sample, from the number that suits a small image.
///
/// A pixel of P gets n/P of n mutations, while an error of b̂ is the same in all of them: with m samples of cost c the squared
/// error V_b/m + V P/n is least for its work at m/n = √(V_b/(c V P)). Where specular surfaces make paths that a million
/// samples hardly meet, V_b is not known, and no sample is spared.
pub(in crate::transport) fn mutations_a_sample(view: View, usual: u64) -> u64 {
    if view.scene.has_specular() {
        return usual;
    }
    let growth = (f64::from(view.camera.pixels()) / PIXELS).sqrt();
    (usual as f64 * growth.max(1.0)) as u64
}

#[cfg(test)]
mod tests {
    use super::super::super::Rgb;
    use super::super::super::testing::{World, lambert, mirror, room};
    use super::super::{Counts, Method, Renderer, Settings};
    use super::*;
    use std::ops::ControlFlow;

    fn samples(world: &World, side: u32) -> f64 {
        let camera = world.camera.with_size([side, side]);
        let view = View { camera: &camera, ..world.view() };
        let renderer =
            Renderer::new(view, Settings { method: Method::Metropolis, per_pixel: 2.0, ..Settings::default() });
        let (mut film, mut counts) = (renderer.film(), Counts::default());
        renderer.render(0..1, &mut film, &mut counts, &mut |_, _| ControlFlow::Continue(()));
        counts.strata[0].samples as f64 / counts.steps() as f64
    }

    #[test]
    fn larger_images_take_fewer_samples_a_mutation_unless_surfaces_are_specular() {
        let (matt, shiny) = (room(lambert(Rgb::ONE), false), room(mirror(), false));
        assert_eq!([32, 64, 128].map(|side| samples(&matt, side)), [1.0 / 32.0, 1.0 / 32.0, 1.0 / 64.0]);
        assert_eq!(samples(&shiny, 256), 1.0 / 32.0);
    }
}
