//! White plastic neither makes light nor loses it.

use super::support::render;

/// A furnace hides what absorbs nothing, but for what the smooth normals of this ball of 960 triangles lose: a diffuse white ball
/// in its place has b = 0.9984, too. A base that does not know of its coat gives 1.015.
#[test]
fn white_plastic_cannot_be_seen_in_a_furnace() {
    let furnace = render("furnace-plastic-0.0/scene.gltf", "--size 32x32 --samples-per-pixel 128 --method pt");
    furnace.expect_b(0.9985, 1e-3);
    assert!((furnace.b().0 - 1.015).abs() > 1e-3 + 4.5 * furnace.b().1);
}

/// In a closed room of white plastic only the lamp, which is black, takes light away: as much as it gives.
#[test]
fn a_room_of_white_plastic_is_finite_and_the_same_by_all_methods() {
    for (method, budget) in
        [("pt", "--samples-per-pixel 1024"), ("bdpt", "--samples-per-pixel 128"), ("mlt", "--mutations-per-pixel 1024")]
    {
        let room = render("plastic-room-1.0/scene.gltf", &format!("--size 16x16 {budget} --method {method}"));
        room.expect_b(0.70, 0.01);
        // Where white plastic makes light, path tracing says 43 ± 26.
        assert!(room.b().1 < 0.1, "{method}: {:?}", room.b());
    }
}
