//! Surfaces that are not opaque.

use super::balance::{Imbalance, imbalance};
use super::worlds::{curtain, lambert, veil, veils, walls};
use crate::engine::{Importance, Mutation, Purpose, Stratum, generator, uniform_f32};
use crate::transport::colour::Rgb;
use crate::transport::lights::{LightStrata, Stratification};
use crate::transport::methods::metropolis::{LightStratum, PathMutation};
use crate::transport::paths::{Classes, LightPath, Luminance, PathVertex};
use glam::DVec3;

/// τ of an edge, from what the path carries.
fn passed(edge: &[PathVertex]) -> f64 {
    f64::from(edge[0].inverse_square * edge[0].vertex.position.distance_squared(edge[1].vertex.position))
}

/// The imbalance of a mutation whose ratio is changed by `error`.
fn imbalance_of(name: &str, batches: u64, error: impl Fn(&LightPath, &LightPath) -> f64 + Sync) -> Imbalance {
    let world = veils();
    let mutations = PathMutation::all(world.view());
    let of_name = |m: &&PathMutation| Mutation::<LightPath, LightStratum>::name(*m) == name;
    let mutation = mutations.iter().find(of_name).expect("it applies");
    imbalance(&world, Stratification::Grid(2, 1), batches, |x, y, within, rng| {
        let suits = Mutation::<LightPath, LightStratum>::suitability(mutation, x) > 0.0;
        let ratio = suits.then(|| mutation.propose(x, y, within, rng))??;
        Some(ratio * error(x, y))
    })
}

#[test]
fn flows_are_balanced_among_veils() {
    for name in ["bidirectional", "lens", "multi-chain"] {
        imbalance_of(name, 15_000, |_, _| 1.0).assert_balanced(name);
    }
}

/// The control of the test above.
#[test]
fn densities_without_veils_are_seen() {
    let all = |path: &LightPath| -> f64 { path.vertices().windows(2).map(passed).product() };
    imbalance_of("bidirectional", 15_000, |x, y| all(y) / all(x)).assert_detected("without τ");
}

/// A path that is connected carries on each edge what passes along it, and each edge is as long as it is.
#[test]
fn edges_carry_what_passes() {
    let world = veils();
    let strata = LightStrata::new(world.scene.lights(), Stratification::None);
    let whole = &LightStratum::product(&strata, world.view(), 12, Classes::default())[0];
    let mut counts = [0; 2];
    for sample in 0..2000 {
        whole.sample(&mut generator(3, Purpose::Sample, 0, 0, sample), &mut |path: &LightPath, _| {
            assert!(Luminance.eval(path) > 0.0);
            for edge in path.vertices().windows(2) {
                let expected = world.scene.transmittance(&edge[0].vertex, &edge[1].vertex).unwrap_or(0.0);
                let found = passed(edge);
                assert!((found - f64::from(expected)).abs() < 1e-3 * found, "{found} and {expected}");
                counts[usize::from(expected < 1.0)] += 1;
            }
        });
    }
    assert!(counts.iter().all(|&n| n > 1000), "{counts:?}");
}

/// Rays stop at each veil as often as it is opaque, and 1 − α of each is what passes.
#[test]
fn rays_stop_as_often_as_surfaces_are_opaque() {
    let world = walls()
        .mesh(curtain(0.5), veil(lambert(Rgb::ONE), 0.25))
        .mesh(curtain(0.0), veil(lambert(Rgb::ONE), 0.5))
        .mesh(curtain(-0.5), veil(lambert(Rgb::ONE), 0.0))
        .seen(DVec3::new(0.2, 0.1, 3.4), DVec3::ZERO, 38.0, [16, 16]);
    let (scene, camera) = (&world.scene, world.camera.vertex());
    let mut rng = generator(5, Purpose::Sample, 0, 0, 0);
    let mut stops = std::collections::BTreeMap::<_, (u32, f32)>::new();
    let rays = 100_000;
    for _ in 0..rays {
        let image = (glam::Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng)) - 0.5) * 0.1 + 0.5;
        let (end, passed) = scene
            .follow(&camera, world.camera.sample(image, &world.camera.vertex()).direction(), &mut rng)
            .expect("a wall");
        assert_eq!(Some(passed), scene.transmittance(&camera, &end));
        stops.entry(end.material).or_insert((0, passed)).0 += 1;
    }
    // Of the back wall, the curtains in front and in the middle.
    let found: Vec<_> = stops.into_values().collect();
    assert_eq!(found.len(), 3);
    for ((count, passed), (share, expected)) in found.into_iter().zip([(0.375, 0.375), (0.25, 1.0), (0.375, 0.75)]) {
        assert_eq!(passed, expected);
        assert!((f64::from(count) / f64::from(rays) - share).abs() < 0.006, "{count}");
    }
}
