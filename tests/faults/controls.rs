//! Cases without the trouble: they have always been right, and show that the values are read as they were written.

use super::support::render;

#[test]
fn a_plain_gltf_file_has_its_value() {
    render("gl-base/scene.gltf", "--size 64x64 --samples-per-pixel 64 --method pt").expect_b(0.1148, 5e-4);
}

#[test]
fn a_room_without_a_stray_triangle_has_its_value_in_every_method() {
    for method in ["pt", "bdpt"] {
        render("stray95-1e0/scene.gltf", &format!("--size 16x16 --samples-per-pixel 256 --method {method}"))
            .expect_b(2.126, 0.006);
    }
}
