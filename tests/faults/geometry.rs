//! Surfaces of very different sizes, and surfaces in one place.

use super::support::{Render, render};

/// A cube under a lamp, on a ground of a kilometre, 100 and 1,000 kilometres: the same image. The control is the ground whose
/// size never mattered.
#[test]
fn a_contact_shadow_does_not_depend_on_the_size_of_the_ground() {
    for ground in ["ground-1e3", "ground-1e5", "ground-1e6"] {
        let image = |method: &str, samples: u32| {
            let options = format!("--size 64x64 --samples-per-pixel {samples} --method {method}");
            render(&format!("{ground}/scene.gltf"), &options).report["b"].as_f64().expect("b")
        };
        for b in [image("pt", 64), image("bdpt", 16)] {
            assert!((b / 0.1308 - 1.0).abs() < 0.001, "{ground}: {b}");
        }
    }
}

fn means(scene: &str) -> [Render; 2] {
    [("pt", 256), ("bdpt", 128)].map(|(method, samples)| {
        render(&format!("{scene}/scene.gltf"), &format!("--size 32x32 --samples-per-pixel {samples} --method {method}"))
    })
}

/// The lamp shines from the ceiling, whichever of the two is listed first.
#[test]
fn a_lamp_in_the_plane_of_a_ceiling_has_one_value() {
    for scene in ["coplanar-after", "coplanar-before"] {
        for image in means(scene) {
            image.expect_b(0.686, 0.001);
            assert!(image.said.contains("\"lamp\"") && image.said.contains("\"white\""), "{}", image.said);
        }
    }
}

/// The second of two lamps in one place adds nothing. Control: the lamp alone, without a warning.
#[test]
fn a_lamp_that_is_there_twice_shines_once() {
    for (scene, warned) in [("lamp-once", false), ("lamp-twice", true)] {
        for image in means(scene) {
            image.expect_b(0.849, 0.001);
            assert_eq!(image.said.contains("overlap in one plane"), warned, "{}", image.said);
        }
    }
}
