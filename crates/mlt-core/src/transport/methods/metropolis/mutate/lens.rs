//! The lens perturbation: move the path on the image, keep what lies behind its first diffuse surface.
//!
//! Paths of the form (L|D) D S* E or L S* E: the camera ray is moved by a distance with density ∝ 1/r² per area of the
//! image, the chain of specular surfaces is followed through the same events, and its end x_m is connected to
//! x_{m−1}. The move on the image is symmetric, so
//!
//! T(y→x) / T(x→y) = Π_{m ≤ i < k} q_i(x) / q_i(y),  q_{k−1} = reverse_{k−1},  q_i = reverse_i / P(event at x_{i+1}),
//!
//! q_i being the density of x_i when the film point is uniform and the events are given.
//!
//! Source: [VeachGuibas97], section 5.3.3.

use super::event::is_followed;
use super::follow::ByAngle;
use super::from_eye::{EyePerturbation, FromEye};
use crate::transport::paths::LightPath;
use crate::transport::scene::View;
use rand_pcg::rand_core::Rng;

/// Moves the camera ray.
pub type LensPerturbation<'a> = EyePerturbation<'a, Lens>;

/// Keeps what lies behind the first diffuse vertex.
#[derive(Clone, Copy, Debug)]
pub struct Lens;

impl FromEye for Lens {
    const NAME: &'static str = "lens";
    type Turn = ByAngle;

    /// To paths whose first diffuse vertex can be connected to the one before it, or is a light.
    fn applies(view: &View, current: &LightPath) -> bool {
        let m = first_diffuse(view, current, current.edges());
        m == 0 || !is_followed(view, current, m - 1)
    }

    fn draw_end(view: &View, current: &LightPath, _: &mut impl Rng) -> usize {
        first_diffuse(view, current, current.edges())
    }
}

/// Index of the first vertex below `i` whose event is not followed; 0 at the latest.
pub(super) fn first_diffuse(view: &View, path: &LightPath, i: usize) -> usize {
    let mut m = i - 1;
    while m > 0 && is_followed(view, path, m) {
        m -= 1;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Mutation;
    use crate::transport::colour::Rgb;
    use crate::transport::lights::Stratification;
    use crate::transport::scene::Resolved;
    use crate::transport::tests::balance::{imbalance, imbalance_in_tiles};
    use crate::transport::tests::worlds::{
        World, blurred, glass, glossy, lambert, mirror, parallel, pond, room, two_lights,
    };

    /// Moves of paths of the form that the perturbation applies to.
    fn suited<'a>(world: &'a World, x: &LightPath) -> Option<LensPerturbation<'a>> {
        let lens = LensPerturbation::new(world.view());
        (lens.suitability(x) > 0.0).then_some(lens)
    }

    #[test]
    fn flows_are_balanced() {
        for (name, world) in [
            ("diffuse", room(lambert(Rgb::splat(0.5)), true)),
            ("mirror", room(mirror(), true)),
            ("coated", room(glossy(), true)),
            ("glass", room(glass(0.0), false)),
            ("water", pond()),
            ("two lights", two_lights(glass(0.0), mirror())),
            ("thin lens", blurred()),
            ("orthographic camera", parallel()),
        ] {
            let found = imbalance(&world, Stratification::Grid(2, 1), 15_000, |x, y, within, rng| {
                suited(&world, x)?.propose(x, y, within, rng)
            });
            found.assert_balanced(name);
        }
    }

    #[test]
    fn flows_are_balanced_in_tiles() {
        let world = room(mirror(), true);
        let found =
            imbalance_in_tiles(&world, 15_000, |x, y, within, rng| suited(&world, x)?.propose(x, y, within, rng));
        found.assert_balanced("tiles");
    }

    #[test]
    fn a_ratio_without_the_densities_is_seen() {
        let world = pond();
        let found = imbalance(&world, Stratification::None, 60_000, |x, y, within, rng| {
            suited(&world, x)?.propose(x, y, within, rng).map(|_| 1.0)
        });
        found.assert_detected("without the densities");
    }

    #[test]
    fn a_ratio_without_the_probabilities_of_events_is_seen() {
        let world = pond();
        let events = |path: &LightPath| -> f64 {
            let probability = |i: usize| {
                let x = &path.vertices[i];
                world
                    .scene
                    .surface(&x.vertex, &mut Resolved::default())
                    .event_probability(x.to_eye, -path.vertices[i - 1].to_eye)
            };
            (first_diffuse(&world.view(), path, path.edges()) + 1..path.edges())
                .map(|i| f64::from(probability(i)))
                .product()
        };
        let found = imbalance(&world, Stratification::None, 60_000, |x, y, within, rng| {
            suited(&world, x)?.propose(x, y, within, rng).map(|ratio| ratio * events(x) / events(y))
        });
        found.assert_detected("without the probabilities of events");
    }
}
