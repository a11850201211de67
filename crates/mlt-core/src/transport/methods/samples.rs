//! How many independent samples chains get for b̂_j and their starts.
//!
//! A pixel of P gets n/P of a round's n mutations, while an error of b̂ is the same in all of them. With V the squared
//! relative error that one mutation a pixel leaves, m samples, each of the work of c mutations, and V_b the relative
//! variance of one, a round has the squared error V P/n · (1 + V_b/m) + V_b/m, since E[b̂²] = b² (1 + V_b/m). With V = 1 it
//! is least for its work at m/n = √(V_b (1 + P/n)/(c P)). V_b differs by scenes, from 0.1 to 10⁴, and is measured before the
//! first round.

use crate::engine::{LEAST_SAMPLES, MUTATIONS_PER_SAMPLE, Share, Stratum, shares_by_power, with_shares};
use crate::transport::scene::View;

/// The independent samples of a method.
#[derive(Clone, Copy)]
pub(crate) struct Samples {
    /// Mutations for one of them on a small image of an unknown scene.
    pub(super) usual: u64,
    /// c, the work of one in mutations.
    cost: f64,
}

impl Samples {
    /// Bidirectional samples for chains of paths.
    pub(crate) const OF_PATHS: Self = Self { usual: MUTATIONS_PER_SAMPLE, cost: 9.0 };
    /// Bidirectional samples for chains of their numbers.
    pub(crate) const BIDIRECTIONAL: Self = Self { usual: 8, cost: 1.0 };
    /// Paths for chains of their numbers. Most random paths are dark, so b̂_j takes many.
    pub(crate) const MULTIPLEXED: Self = Self { usual: 4, cost: 1.0 };

    /// Mutations for one of them where a round has `n` mutations and the image so many pixels, within limits. Without a V_b, the
    /// fewest.
    fn fitted(self, n: f64, pixels: f64, spread: Option<f64>) -> f64 {
        let least = LIMITS[0].max(WORK[0] * self.cost);
        let most = LIMITS[1].min(WORK[1] * self.cost);
        let ideal = |spread: f64| (self.cost * pixels / (spread * (1.0 + pixels / n))).sqrt();
        spread.map_or(least, |spread| ideal(spread).clamp(least, most))
    }
}

/// Pixels of images that the usual numbers are made for; larger ones need fewer samples.
const PIXELS: f64 = 16_384.0;
/// Fewest and most mutations for one independent sample, however its weight varies.
const LIMITS: [f64; 2] = [4.0, 256.0];
/// Most and least work of mutations over that of independent samples, within [`LIMITS`]: samples take no more than half of the
/// work, and a 64th in any case, as an error of b̂ is small in squares but the same everywhere.
const WORK: [f64; 2] = [1.0, 64.0];

/// Mutations for one independent sample in a scene of which no more is known, from the number that suits a small image.
///
/// Where specular surfaces make paths that a million samples hardly meet, no sample is spared.
pub(crate) fn mutations_per_sample(view: View, usual: u64) -> u64 {
    if view.scene.needs().specular {
        return usual;
    }
    let growth = (f64::from(view.camera.pixels()) / PIXELS).sqrt();
    (usual as f64 * growth.max(1.0)) as u64
}

/// Shares of so many mutations by power, with as many independent samples as the spread of their weights asks for, and the work that
/// it took to measure the spread; `None` if that was stopped.
///
/// `spread` measures it, as [`Metropolis::spread`](crate::engine::Metropolis::spread) does. It is not measured where a scene has specular
/// surfaces: it would lie in paths that such a measurement does not meet.
pub(crate) fn fitted_shares<P, S: Stratum<P>>(
    view: View,
    samples: Samples,
    strata: Vec<S>,
    mutations: f64,
    spread: impl FnOnce(&[(S, Share)]) -> Option<(Option<f64>, u64)>,
) -> Option<(Vec<Share>, u64)> {
    let unknown = shares_by_power(&strata, mutations, mutations_per_sample(view, samples.usual));
    if view.scene.needs().specular {
        return Some((unknown, 0));
    }
    let (spread, work) = spread(&paired(strata, &unknown))?;
    let fitted = |Share { mutations, .. }: Share| {
        let n = mutations as f64;
        let samples = (n / samples.fitted(n, f64::from(view.camera.pixels()), spread)) as u64;
        Share { mutations, samples: samples.max(LEAST_SAMPLES) }
    };
    Some((unknown.into_iter().map(fitted).collect(), work))
}

/// Strata with the shares that were made for them.
pub(crate) fn paired<S>(strata: Vec<S>, shares: &[Share]) -> Vec<(S, Share)> {
    with_shares(strata, shares).expect("a plan has a share for each of its strata")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::colour::Rgb;
    use crate::transport::methods::settings::{Method, Settings};
    use crate::transport::render::Renderer;
    use crate::transport::tests::worlds::{World, lambert, mirror, room};
    use std::ops::ControlFlow;

    /// Mutations for one sample of the render of a world.
    fn mutations_per_sample_of(world: &World, method: Method, side: u32) -> f64 {
        let camera = world.camera.with_size([side, side]);
        let view = View { camera: &camera, ..world.view() };
        let renderer = Renderer::new(view, Settings::new(method, 4.0));
        let mut sums = renderer.sums();
        renderer.render(0..1, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let counts = sums.tally();
        assert_eq!(counts.pilot.rays > 0, !view.scene.needs().specular);
        counts.steps() as f64 / counts.chains().strata[0].samples as f64
    }

    #[test]
    fn samples_are_spared_where_their_weights_hardly_vary_and_surfaces_are_not_specular() {
        let (diffuse, shiny) = (room(lambert(Rgb::ONE), false), room(mirror(), false));
        assert_eq!(mutations_per_sample_of(&diffuse, Method::Metropolis, 128), 256.0);
        assert!((32.0..=64.0).contains(&mutations_per_sample_of(&diffuse, Method::Multiplexed, 128)));
        assert_eq!(mutations_per_sample_of(&shiny, Method::Metropolis, 128), 32.0);
        assert_eq!(mutations_per_sample_of(&shiny, Method::Multiplexed, 128), 4.0);
    }

    #[test]
    fn the_number_of_samples_is_the_best_for_its_work() {
        let samples = Samples { usual: 32, cost: 9.0 };
        let (pixels, spread, n) = (65536.0, 146.0, 32768.0);
        // Squared error of a round times its work, with one sample for each `of` mutations.
        let error = |of: f64| pixels / n * (1.0 + spread * of / n) + spread * of / n;
        let loss = |of: f64| error(of) * (n + 9.0 * n / of);
        let fitted = samples.fitted(n, pixels, Some(spread));
        assert!(loss(fitted) < loss(0.9 * fitted) && loss(fitted) < loss(1.1 * fitted), "{fitted}");
        assert_eq!([Some(0.0), Some(1e9), None].map(|spread| samples.fitted(n, pixels, spread)), [256.0, 9.0, 9.0]);
    }

    #[test]
    fn larger_images_of_unknown_scenes_take_fewer_samples_unless_surfaces_are_specular() {
        let usual = |world: &World, side| {
            let camera = world.camera.with_size([side, side]);
            mutations_per_sample(View { camera: &camera, ..world.view() }, 32)
        };
        let (diffuse, shiny) = (room(lambert(Rgb::ONE), false), room(mirror(), false));
        assert_eq!([64, 128, 256].map(|side| usual(&diffuse, side)), [32, 32, 64]);
        assert_eq!(usual(&shiny, 256), 32);
    }
}
