//! OBJ and MTL as programs write them.

use super::support::{Render, render};

/// A view of the floor under its lamp.
pub(crate) fn seen(name: &str, size: u32, samples: u32) -> Render {
    let view = "--camera-from 0,3.5,4 --camera-to 0,0,0 --fov 50 --method pt";
    render(name, &format!("{view} --size {size}x{size} --samples-per-pixel {samples}"))
}

/// The floor of reflectance 0.7, as `obj-base` has it in plain words.
const FLOOR: f64 = 0.1147;

#[test]
fn statements_mean_the_same_however_they_are_written() {
    for (case, word) in [
        ("obj-base", ""),
        ("obj-continuation", ""),
        ("obj-continuation-v", ""),
        ("obj-tab-spaced-name", ""),
        ("obj-mtl-two", "other.mtl: cannot be read"),
        ("obj-comment-after", ""),
        ("obj-d-halo", "material `lamp`: `d -halo 0.5` cannot be read; the default stands in"),
        ("obj-illum-bad", ""),
        ("obj-cr", ""),
    ] {
        let found = seen(&format!("{case}/scene.obj"), 64, 4);
        found.expect_b(FLOOR, 2e-4);
        assert!(found.said.contains(word), "{}", found.said);
    }
}

#[test]
fn what_cannot_be_read_is_the_default_and_named() {
    let found = seen("obj-kd-xyz/scene.obj", 64, 4);
    found.expect_b(FLOOR * 0.5 / 0.7, 2e-4);
    assert!(found.said.contains("material `white`: `Kd xyz .7 .7 .7` cannot be read"), "{}", found.said);
    let found = seen("files/bare-usemtl.obj", 64, 4);
    found.expect_b(0.2062, 4e-4);
    assert!(found.said.contains("grey stands in"), "{}", found.said);
    let found = seen("files/two-libraries.obj", 64, 4);
    found.expect_b(0.1026, 2e-4);
    assert!(!found.said.contains("grey"), "{}", found.said);
}

#[test]
fn concave_polygons_are_filled() {
    for case in ["obj-concave-arrow", "obj-concave-arrow-truth"] {
        seen(&format!("{case}/scene.obj"), 96, 4).expect_b(0.1038, 3e-4);
    }
}

/// The control: what once stood for the arrow, a fan about its first corner, is told apart.
#[test]
fn a_fan_in_place_of_an_arrow_is_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = super::support::data("obj-concave-arrow-truth");
    let read = |name: &str| std::fs::read_to_string(truth.join(name)).expect("a file");
    let fan = read("scene.obj").replace("f -2 -1 -4\nf -2 -4 -3", "f -1 -4 -3\nf -1 -3 -2");
    std::fs::write(folder.path().join("scene.obj"), fan).expect("written");
    std::fs::write(folder.path().join("scene.mtl"), read("scene.mtl")).expect("written");
    let (b, stderr) = seen(&folder.path().join("scene.obj").to_string_lossy(), 96, 4).b();
    assert!(b < 0.1038 - 3e-4 - 9.0 * stderr, "{b} ± {stderr}");
}
