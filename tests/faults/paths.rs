//! Paths of many edges, and paths through edges that are hardly longer than the rounding errors of their ends.

use super::support::render;

/// A stray triangle thousands of room sizes away changes the room's unit of length, which is not seen.
#[test]
fn long_paths_in_a_small_room_are_kept() {
    for method in ["mlt", "pssmlt", "mmlt", "mlt --strata 4x4"] {
        render("stray95-1e3/scene.gltf", &format!("--size 16x16 --mutations-per-pixel 256 --method {method}"))
            .expect_b(2.126, 0.006);
    }
    render("stray95-1e3/scene.gltf", "--size 16x16 --samples-per-pixel 256").expect_b(2.126, 0.006);
}

/// The value that one of the methods once gave.
#[test]
#[should_panic(expected = "not 2.06")]
fn a_loss_of_long_paths_would_be_seen() {
    render("stray95-1e3/scene.gltf", "--size 16x16 --samples-per-pixel 256").expect_b(2.06, 0.006);
}

#[test]
fn a_pane_lets_as_much_light_through_however_thin_it_is() {
    for pane in ["pane-1e-2", "pane-2e-5", "pane-1e-5", "pane-500-metres-away"] {
        render(&format!("{pane}/scene.gltf"), "--size 16x16 --samples-per-pixel 1024 --method bdpt")
            .expect_b(0.830, 0.003);
    }
}

/// The value that the thicker of the two thin panes once gave.
#[test]
#[should_panic(expected = "not 0.856")]
fn a_brighter_pane_would_be_seen() {
    render("pane-2e-5/scene.gltf", "--size 16x16 --samples-per-pixel 1024 --method bdpt").expect_b(0.856, 0.003);
}
