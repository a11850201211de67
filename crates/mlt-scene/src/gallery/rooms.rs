//! Rooms that light enters by narrow ways.

use super::document::{Document, Eye, Shape};
use super::shapes::{ball, flipped, halton, holed, lamp, quad, room, solid};
use glam::{DVec2, DVec3, dvec2, dvec3};

const WHITE: [f32; 3] = [0.7, 0.7, 0.68];
const BLUE: [f32; 3] = [0.25, 0.35, 0.55];
const ORANGE: [f32; 3] = [0.65, 0.4, 0.2];

/// Two chambers, mirror images of each other, shine into a room through a keyhole each.
pub(super) fn islands() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.0, 1.0, 1.45), to: dvec3(0.0, 1.0, 0.0), fov: 1.3 });
    let white = document.diffuse("white", WHITE);
    let light = document.light("lamp", [400.0, 360.0, 300.0]);
    let (low, high) = (dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.5));
    document.add("room", white, room(low, high, &[0, 1]));
    for (name, side) in [("left", 1.0), ("right", -1.0)] {
        let mirror = |shape: Shape| {
            let shape = shape.map(|p| p * dvec3(side, 1.0, 1.0));
            if side < 0.0 { flipped(shape) } else { shape }
        };
        let [width, height] = [2.5, 2.0];
        let hole = [dvec2(0.3, 0.45), dvec2(0.34, 0.5)];
        let wall = holed(low, DVec3::Z * width, DVec3::Y * height, hole[0], hole[1]);
        document.add(&format!("{name} wall"), white, mirror(wall));
        // The chamber shares the wall; its lamp faces away from the keyhole.
        document.add(
            &format!("{name} chamber"),
            white,
            mirror(room(dvec3(-1.8, 0.4, -0.7), dvec3(-1.0, 1.6, 0.3), &[1])),
        );
        let shade = quad(dvec3(-1.05, 1.2, -0.6), DVec3::Z * 0.3, DVec3::Y * 0.3);
        document.add(&format!("{name} lamp"), light, mirror(shade));
    }
    document
}

/// A room with a window and nothing that gives light: a sky does, through the window.
pub(super) fn window() -> Document {
    let mut document = Document::new(Eye { from: dvec3(1.4, 1.4, 3.7), to: dvec3(-0.9, 1.0, 1.2), fov: 1.0 });
    let (white, blue) = (document.diffuse("white", WHITE), document.diffuse("blue", BLUE));
    let (orange, glass) = (document.diffuse("orange", ORANGE), document.glass("glass", 1.5));
    let (low, high) = (dvec3(-2.0, 0.0, 0.0), dvec3(2.0, 2.6, 4.0));
    document.add("room", white, room(low, high, &[0]));
    let [from, to] = [dvec2(0.25, 0.35), dvec2(0.6, 0.85)];
    document.add("wall", white, holed(low, DVec3::Z * 4.0, DVec3::Y * 2.6, from, to));
    document.add("table", orange, solid(dvec3(-1.4, 0.0, 0.6), dvec3(-0.4, 0.6, 1.4)));
    document.add("pillar", blue, solid(dvec3(0.7, 0.0, 0.4), dvec3(1.1, 1.7, 0.8)));
    document.add("ball", glass, ball(dvec3(-0.9, 0.9, 1.0), 0.3, 4));
    document
}

/// A dark room beside a bright one, and a door that is not quite shut.
pub(super) fn door_ajar() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.9, 1.3, 3.8), to: dvec3(-0.3, 1.0, 0.0), fov: 0.95 });
    let white = document.diffuse("white", WHITE);
    let (blue, orange) = (document.diffuse("blue", BLUE), document.diffuse("orange", ORANGE));
    let light = document.light("lamp", [900.0, 820.0, 700.0]);
    let (low, high) = (dvec3(-2.0, 0.0, 0.0), dvec3(2.0, 2.6, 4.0));
    document.add("room", white, room(low, high, &[4]));
    document.add("next room", white, room(dvec3(-2.0, 0.0, -3.0), dvec3(2.0, 2.6, 0.0), &[5]));
    let size = high - low;
    let [from, to] = [dvec2(1.55 / 4.0, 0.0), dvec2(2.45 / 4.0, 2.0 / 2.6)];
    document.add("wall", white, holed(low, DVec3::X * size.x, DVec3::Y * size.y, from, to));
    // Hinged at the left of the doorway, opened into the dark room by an angle of sine 0.03.
    let along = dvec3((1.0f64 - 0.03 * 0.03).sqrt(), 0.0, 0.03);
    document.add("door", orange, quad(dvec3(-0.45, 0.0, 0.0), 0.9 * along, 2.0 * DVec3::Y));
    document.add("chest", blue, solid(dvec3(-1.6, 0.0, 0.7), dvec3(-0.9, 0.8, 1.6)));
    document.add("pillar", white, solid(dvec3(0.9, 0.0, 0.9), dvec3(1.3, 1.7, 1.3)));
    // The lamp lights the far wall of its room.
    let shade = quad(dvec3(-1.0, 1.2, -0.4), DVec3::Y, DVec3::X);
    document.add("lamp", light, shade);
    document
}

/// Two hundred small lights, whose powers differ by a factor of a thousand, over a room with boxes.
pub(super) fn lights_200() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.0, 1.8, 6.2), to: dvec3(0.0, 1.0, 0.0), fov: 0.75 });
    let (white, blue) = (document.diffuse("white", WHITE), document.diffuse("blue", BLUE));
    let orange = document.diffuse("orange", ORANGE);
    document.add("room", white, room(dvec3(-3.0, 0.0, -3.0), dvec3(3.0, 2.8, 3.0), &[5]));
    for i in 0..9u32 {
        let [x, z] = [i % 3, i / 3].map(|k| 1.7 * f64::from(k) - 1.7);
        let height = 0.3 + 0.25 * f64::from(i * 5 % 9);
        let paint = if i % 2 == 0 { blue } else { orange };
        document.add("box", paint, solid(dvec3(x - 0.35, 0.0, z - 0.35), dvec3(x + 0.35, height, z + 0.35)));
    }
    for class in 0..10 {
        let mut radiance = [1.0, 0.9, 0.75].map(|c: f32| c * 0.5 * 2f32.powi(class));
        if class % 3 == 0 {
            radiance.reverse();
        }
        let light = document.light(&format!("lamp {class}"), radiance);
        let lamps = (0..20u32).map(|i| {
            let p = halton(1 + i * 10 + class as u32);
            lamp(dvec3(5.8 * p.x - 2.9, 2.75, 5.8 * p.y - 2.9), DVec2::splat(0.06))
        });
        document.add(&format!("lamps {class}"), light, lamps.reduce(Shape::and).unwrap_or_default());
    }
    document
}

/// A light in a sealed box, and one of a millionth of its power that is all the camera sees.
pub(super) fn occluded() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.0, 1.1, 3.9), to: dvec3(0.0, 0.9, 0.0), fov: 0.6 });
    let (white, blue) = (document.diffuse("white", WHITE), document.diffuse("blue", BLUE));
    document.add("room", white, room(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0), &[5]));
    document.add("case", blue, solid(dvec3(-0.7, 0.0, -0.6), dvec3(0.1, 0.9, 0.2)));
    let sealed = document.light("sealed", [5e5, 4.5e5, 4e5]);
    document.add("sealed lamp", sealed, lamp(dvec3(-0.3, 0.8, -0.2), DVec2::splat(0.6)));
    let faint = document.light("faint", [4.5, 4.05, 3.6]);
    document.add("faint lamp", faint, lamp(dvec3(0.2, 1.98, 0.1), DVec2::splat(0.2)));
    document
}

/// A hundred thousand emissive triangles: fifty thousand scraps of paper in the air.
pub(super) fn confetti() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.0, 1.1, 3.9), to: dvec3(0.0, 0.9, 0.0), fov: 0.6 });
    let white = document.diffuse("white", WHITE);
    let light = document.light("scraps", [6.0, 5.0, 3.5]);
    document.add("room", white, room(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0), &[5]));
    let mut scraps = Shape::default();
    for i in 1..=50_000 {
        let (p, q) = (halton(i), halton(i + 70_000));
        let normal = (2.0 * q - DVec3::ONE).normalize_or(DVec3::Y);
        let size = 0.002 + 0.004 * f64::from(i % 7) / 6.0;
        let a = normal.any_orthonormal_vector() * size;
        let (shape, centre) =
            (quad(DVec3::ZERO, a, normal.cross(a)), p * dvec3(1.9, 0.5, 1.9) + dvec3(-0.95, 1.4, -0.95));
        scraps = merged(scraps, shape.map(|corner| corner + centre));
    }
    document.add("scraps", light, scraps);
    document
}

/// As [`Shape::and`], in time proportional to the second.
fn merged(mut all: Shape, one: Shape) -> Shape {
    let first = all.positions.len() as u32;
    all.triangles.extend(one.triangles.iter().map(|t| t.map(|i| i + first)));
    all.positions.extend(one.positions);
    all
}

/// A white room seen through a periscope of ten mirrors: no path that carries light has fewer than 12 edges.
pub(super) fn duct() -> Document {
    let mut document = Document::new(Eye { from: dvec3(-1.0, 0.0, 0.0), to: DVec3::ZERO, fov: 0.05 });
    let mirror = document.metal("mirror", [1.0; 3], 0.0);
    let white = document.diffuse("white", [0.8; 3]);
    let light = document.light("lamp", [20.0, 18.0, 15.0]);
    let mut at = DVec3::ZERO;
    for i in 0..10 {
        let (along, across) = (dvec3(0.9, 0.9, 0.0), dvec3(0.0, 0.0, 1.2));
        document.add("mirror", mirror, quad(at - 0.5 * (along + across), along, across));
        at += 2.0 * if i % 2 == 0 { DVec3::Y } else { DVec3::X };
    }
    // Ten mirrors lead back to +x: the room is open where the light leaves.
    document.add("room", white, room(at + dvec3(0.0, -1.0, -1.0), at + dvec3(2.0, 1.0, 1.0), &[0]));
    document.add("lamp", light, lamp(at + dvec3(0.5, 0.98, 0.0), DVec2::splat(0.6)));
    document
}

/// A lamp over a pool: everything on its floor is seen, and lit, through the water.
pub(super) fn pool() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.0, 2.2, 2.4), to: dvec3(0.0, -0.5, 0.0), fov: 0.6 });
    let (white, blue) = (document.diffuse("white", WHITE), document.diffuse("blue", BLUE));
    let water = document.glass("water", 1.33);
    let light = document.light("lamp", [600.0, 560.0, 480.0]);
    document.add("basin", blue, room(dvec3(-1.0, -1.0, -1.0), dvec3(1.0, 0.0, 1.0), &[3]));
    let rim = holed(dvec3(-2.0, 0.0, 2.0), DVec3::X * 4.0, DVec3::NEG_Z * 4.0, DVec2::splat(0.25), DVec2::splat(0.75));
    document.add("rim", white, rim);
    document.add("water", water, quad(dvec3(-1.0, 0.0, 1.0), DVec3::X * 2.0, DVec3::NEG_Z * 2.0));
    document.add("lamp", light, lamp(dvec3(0.0, 2.0, 0.0), DVec2::splat(0.1)));
    document
}

/// A room seen from inside a ball of glass.
pub(super) fn camera_in_glass() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.05, 1.0, 0.6), to: dvec3(0.0, 0.9, 0.0), fov: 1.2 });
    let (white, orange) = (document.diffuse("white", WHITE), document.diffuse("orange", ORANGE));
    let glass = document.glass("glass", 1.5);
    let light = document.light("lamp", [20.0, 18.0, 15.0]);
    document.add("room", white, room(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0), &[]));
    document.add("box", orange, solid(dvec3(-0.5, 0.0, -0.6), dvec3(0.1, 0.8, 0.0)));
    document.add("ball", glass, ball(dvec3(0.0, 1.0, 0.6), 0.25, 4));
    document.add("lamp", light, lamp(dvec3(0.0, 1.98, 0.0), DVec2::splat(0.5)));
    document
}
