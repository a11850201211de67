//! Strata of lights where light comes through glass.

use super::support::render;

/// A lamp above a pane of glass, a mirror and surfaces that are not opaque: a part of the light passes the pane on its way to a
/// surface that is seen in the mirror or through the glass, and nothing but camera subpaths that meet the lamp makes such paths.
///
/// The truth is that of `bdpt` and `pt`. The control is the value without that light, which strata gave that each had to meet their
/// own part of it.
#[test]
fn a_caustic_that_is_seen_through_glass_is_in_every_cut() {
    const VIEW: &str = "--camera-from 0.2,0.1,3.4 --camera-to 0,0,0 --fov 38 --size 24x24 --rounds 32";
    let (truth, error) = (0.04548, 8e-5);
    for (method, strata) in [("mlt", "4x4"), ("mlt", "16"), ("pssmlt", "4x4")] {
        let found = render(
            "lamp-above-glass/scene.obj",
            &format!("{VIEW} --method {method} --strata {strata} --samples-per-pixel 4096"),
        );
        let (b, stderr) = found.b();
        let deviation = |value: f64| (b - value).abs() / stderr.hypot(error);
        println!("{method} {strata}: {b} ± {stderr}");
        assert!(deviation(truth) < 4.0, "{method} {strata}: b = {b} ± {stderr}, not {truth}");
        assert!(deviation(0.0430) > 4.0, "{method} {strata}: b = {b} ± {stderr} could be what lacks it");
    }
}
