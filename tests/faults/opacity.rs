//! Surfaces that are not opaque: `d` and `Tr` of MTL.
//!
//! A thing behind a black sheet of opacity α is seen 1 − α times as bright, whatever the method; a floor of opacity α is
//! α times as bright over nothing.

use super::{
    obj::seen,
    support::{Render, render},
};

/// The floor of `obj-base`, opaque.
const FLOOR: f64 = 0.1147;

const METHODS: [(&str, &str); 6] = [
    ("pt", "--samples-per-pixel 64"),
    ("bdpt", "--samples-per-pixel 64"),
    ("mlt", "--mutations-per-pixel 1024"),
    ("pssmlt", "--mutations-per-pixel 256"),
    ("mmlt", "--mutations-per-pixel 1024"),
    ("auto", "--samples-per-pixel 64"),
];

/// The floor under a lamp of opacity `lamp` and a sheet of opacity `sheet` and reflectance `kd` between camera and lamp, all
/// of it between the floor and the camera.
fn under_a_sheet(lamp: f64, sheet: f64, kd: f64, (method, budget): (&str, &str)) -> Render {
    let folder = tempfile::tempdir().expect("a folder");
    let quad = |y: f64, half: f64| {
        format!("v -{half} {y} -{half}\nv -{half} {y} {half}\nv {half} {y} {half}\nv {half} {y} -{half}\n")
    };
    let (light, floor, between) = (quad(2.0, 0.5), quad(0.0, 2.0), quad(1.0, 50.0));
    let obj = format!(
        "mtllib scene.mtl\nusemtl lamp\n{light}f 4 3 2 1\nusemtl white\n{floor}f 5 6 7 8\nusemtl sheet\n{between}f 9 10 11 12\n"
    );
    let mtl = format!("newmtl white\nKd .7\nnewmtl lamp\nKd 0\nKe 10\nd {lamp}\nnewmtl sheet\nKd {kd}\nd {sheet}\n");
    std::fs::write(folder.path().join("scene.obj"), obj).expect("written");
    std::fs::write(folder.path().join("scene.mtl"), mtl).expect("written");
    let view = "--camera-from 0,3.5,4 --camera-to 0,0,0 --fov 50 --size 16x16";
    render(&folder.path().join("scene.obj").to_string_lossy(), &format!("{view} --method {method} {budget}"))
}

#[test]
fn a_floor_over_nothing_is_as_bright_as_it_is_opaque() {
    let found = seen("obj-d99/scene.obj", 64, 16);
    found.expect_b(0.99 * FLOOR, 1e-4);
    assert!(found.said.contains("material `white`: blended by its opacity of 0.99"), "{}", found.said);
    for case in ["obj-d0", "obj-tr1"] {
        let found = seen(&format!("{case}/scene.obj"), 64, 4);
        found.expect_b(0.0, 0.0);
        assert!(found.said.contains("material `white`: its opacity is 0"), "{}", found.said);
    }
}

#[test]
fn a_black_sheet_dims_what_is_behind_it_in_every_method() {
    for method in METHODS {
        under_a_sheet(1.0, 0.5, 0.0, method).expect_b(0.25 * FLOOR, 1.5e-4);
    }
}

/// The control: a sheet of another opacity is told apart by every method.
#[test]
fn another_opacity_is_seen_by_every_method() {
    for method in METHODS {
        let (b, stderr) = under_a_sheet(1.0, 0.25, 0.0, method).b();
        assert!((b - 0.25 * FLOOR).abs() > 1.5e-4 + 9.0 * stderr, "{method:?}: {b} ± {stderr}");
    }
}

/// A white sheet, which lights the floor from both sides, and a lamp that is half there.
#[test]
fn methods_agree_about_light_between_veils() {
    let (truth, stderr) = under_a_sheet(0.5, 0.5, 0.8, ("pt", "--samples-per-pixel 1024")).b();
    for method in METHODS {
        under_a_sheet(0.5, 0.5, 0.8, method).expect_b(truth, 4.5 * stderr);
    }
}
