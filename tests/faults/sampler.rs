//! Lights of which power tells little: a lamp of a millionth of the room beside a sky, a tube of many triangles and a spark, two
//! hundred lamps. Whatever starts paths at lights draws the light for the vertex that it lights.

use super::support::render;

/// All methods that trace from lights, whole and in strata.
const METHODS: [&str; 7] =
    ["bdpt", "mlt", "mlt --strata 4x4", "mlt --strata auto", "pssmlt --strata 8", "mmlt", "mmlt --strata 8"];

/// Fails unless b is `truth`, within four standard errors of both, by all methods, and unless every method tells it from a value
/// that is `control` times as large.
fn expect_b(scene: &str, samples: u32, (truth, error): (f64, f64), control: f64) {
    for method in METHODS {
        let (b, stderr) =
            render(scene, &format!("--size 16x16 --samples-per-pixel {samples} --rounds 32 --method {method}")).b();
        let deviation = |value: f64| (b - value).abs() / stderr.hypot(error);
        println!("{scene}, {method}: {b} ± {stderr}");
        assert!(deviation(truth) < 4.0, "{scene}, {method}: b = {b} ± {stderr}, not {truth}");
        assert!(
            deviation(control * truth) > 4.0,
            "{scene}, {method}: b = {b} ± {stderr} could be {control} times {truth}"
        );
    }
}

/// The truth is the sum of the lamp's light, .2133, and the sky's, .0951, each alone. By power, the lamp's is never met.
#[test]
fn a_tiny_lamp_beside_a_sky_has_its_light() {
    expect_b("../../../scenes/stability/tiny-and-huge/scene.gltf", 1024, (0.3084, 2e-4), 0.66);
}

#[test]
fn a_light_of_many_triangles_has_its_light() {
    expect_b("tube-lamp/scene.gltf", 128, (0.07312, 9e-5), 1.2);
}

#[test]
fn many_lamps_have_their_light() {
    expect_b("../../../scenes/lights-200/lights-200.gltf", 128, (0.4040, 4e-4), 1.2);
}
