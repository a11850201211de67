//! Lights and surfaces that are small, close, shiny or badly made.

use super::document::{Document, Eye, Shape};
use super::shapes::{flipped, halton, lamp, quad, room, solid};
use glam::{DVec2, DVec3, dvec3};

const WHITE: [f32; 3] = [0.7, 0.7, 0.68];
const BLUE: [f32; 3] = [0.25, 0.35, 0.55];
const ORANGE: [f32; 3] = [0.65, 0.4, 0.2];

/// The ordinary box that other scenes distort.
const EYE: Eye = Eye { from: DVec3::new(0.0, 1.1, 3.9), to: DVec3::new(0.0, 0.9, 0.0), fov: 0.6 };

/// A room with two boxes and a lamp: every method has to pass.
pub(super) fn plain() -> Document {
    let mut document = Document::new(EYE);
    let [white, blue, orange] = [WHITE, BLUE, ORANGE].map(|c| document.diffuse("paint", c));
    let light = document.light("lamp", [20.0, 18.0, 15.0]);
    document.add("room", white, room(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0), &[5]));
    let [left, right] = boxes();
    document.add("left box", blue, left);
    document.add("right box", orange, right);
    document.add("lamp", light, lamp(dvec3(0.0, 1.98, 0.0), DVec2::splat(0.5)));
    document
}

fn boxes() -> [Shape; 2] {
    [solid(dvec3(-0.7, 0.0, -0.6), dvec3(-0.1, 1.1, 0.0)), solid(dvec3(0.15, 0.0, 0.0), dvec3(0.7, 0.5, 0.55))]
}

/// [`plain`] in other units.
pub(super) fn scaled(scale: f32) -> Document {
    let mut document = plain();
    document.root = Some([scale, 0., 0., 0., 0., scale, 0., 0., 0., 0., scale, 0., 0., 0., 0., 1.]);
    document
}

/// [`plain`] far from the origin.
pub(super) fn moved(offset: f32) -> Document {
    let mut document = plain();
    document.root = Some([1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., offset, -offset, offset, 1.]);
    document
}

/// [`plain`] with its surfaces cut into slivers, doubled, turned inside out, and with triangles of no area between.
pub(super) fn broken() -> Document {
    let mut document = Document::new(EYE);
    let [white, blue, orange] = [WHITE, BLUE, ORANGE].map(|c| document.diffuse("paint", c));
    let light = document.light("lamp", [20.0, 18.0, 15.0]);
    let (low, high) = (dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0));
    document.add("floor in slivers", white, slivers(low, 2.0 * DVec3::Z, 2.0 * DVec3::X));
    document.add("walls", white, room(low, high, &[2, 5]));
    document.add("walls again", white, flipped(room(low, high, &[2, 3, 5])));
    let [left, right] = boxes();
    let mut inverted = flipped(left);
    inverted.normals = inverted.positions.iter().map(|_| DVec3::NEG_Y.as_vec3()).collect();
    document.add("box inside out", blue, Shape { normals: Vec::new(), ..inverted });
    document.add("box", orange, right.clone());
    document.add("box three times", orange, right.clone().and(right));
    let mut needles = slivers(dvec3(-1.0, 1.0, -1.0), DVec3::ZERO, 2.0 * DVec3::X);
    needles.triangles.extend([[0, 0, 1], [2, 2, 2]]);
    document.add("no area", white, needles);
    document.add("lamp", light, lamp(dvec3(0.0, 1.98, 0.0), DVec2::splat(0.5)));
    document
}

/// A parallelogram as a fan from one corner: 400 triangles, most of them a thousand times longer than wide.
fn slivers(corner: DVec3, a: DVec3, b: DVec3) -> Shape {
    const PARTS: u32 = 400;
    let share = |i: u32| f64::from(i) / f64::from(PARTS);
    let mut positions = vec![corner, corner + a + b];
    positions.extend((0..=PARTS).map(|i| corner + a * share(i)));
    let end = positions.len() as u32;
    let mut triangles: Vec<_> = (0..PARTS).map(|i| [1, 2 + i, 3 + i].map(|k: u32| k)).collect();
    positions.push(corner + b);
    triangles.push([0, 1, end]);
    triangles.iter_mut().for_each(|t| t.swap(1, 2));
    Shape { positions, normals: Vec::new(), triangles }
}

/// Four plates of metal, ever smoother, and the images of three lamps in them.
pub(super) fn gloss() -> Document {
    let mut document = Document::new(Eye { from: dvec3(0.0, 1.2, 4.0), to: dvec3(0.0, 0.5, 0.0), fov: 0.55 });
    let white = document.diffuse("white", [0.3, 0.3, 0.3]);
    document.add("floor", white, quad(dvec3(-3.0, 0.0, -2.0), 5.0 * DVec3::Z, 6.0 * DVec3::X));
    document.add("back", white, quad(dvec3(-3.0, 0.0, -2.0), 6.0 * DVec3::X, 3.0 * DVec3::Y));
    for (i, roughness) in [0.05, 0.02, 0.005, 0.001].into_iter().enumerate() {
        let metal = document.metal(&format!("roughness {roughness}"), [0.8, 0.78, 0.75], roughness);
        // Each plate is turned so that the camera sees the lamps' images near its middle.
        let centre = dvec3(0.0, 0.1 + 0.22 * i as f64, 0.9 - 0.55 * i as f64);
        let to_eye = (dvec3(0.0, 1.2, 4.0) - centre).normalize();
        let to_lamp = (dvec3(0.0, 2.2, 0.5) - centre).normalize();
        let normal = (to_eye + to_lamp).normalize();
        let across = 2.2 * DVec3::X;
        let up = 0.3 * normal.cross(DVec3::X).normalize();
        document.add("plate", metal, quad(centre - 0.5 * (across - up), across, -up));
    }
    for (i, side) in [0.3, 0.1, 0.02].into_iter().enumerate() {
        let radiance = (0.9 / (side * side)) as f32;
        let light = document.light(&format!("lamp {i}"), [radiance, 0.9 * radiance, 0.75 * radiance]);
        document.add("lamp", light, lamp(dvec3(0.7 * i as f64 - 0.7, 2.2, 0.5), DVec2::splat(side)));
    }
    document
}

/// Lights that share an edge with a surface: at a right angle, and at a sharp one.
pub(super) fn touching() -> Document {
    let mut document = Document::new(EYE);
    let (white, blue) = (document.diffuse("white", WHITE), document.diffuse("blue", BLUE));
    let light = document.light("lamp", [3.0, 2.7, 2.2]);
    document.add("room", white, room(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0), &[5]));
    document.add("box", blue, solid(dvec3(0.15, 0.0, 0.0), dvec3(0.7, 0.5, 0.55)));
    // It stands on the floor and leans on the back wall.
    document.add("standing lamp", light, quad(dvec3(-0.6, 0.0, -1.0), DVec3::Y, 0.8 * DVec3::Z));
    // It hangs from the right wall by its upper edge, an eighth of its height away from it below.
    let down = dvec3(-0.1, -0.8, 0.0);
    document.add("leaning lamp", light, quad(dvec3(1.0, 1.6, -0.5), down, 0.8 * DVec3::Z));
    document
}

/// A light of a millionth of the room's size, and a sky a thousand times as large as the room.
pub(super) fn tiny_and_huge() -> Document {
    let mut document = Document::new(EYE);
    let [white, blue, orange] = [WHITE, BLUE, ORANGE].map(|c| document.diffuse("paint", c));
    document.add("room", white, room(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0), &[5]));
    let [left, right] = boxes();
    document.add("left box", blue, left);
    document.add("right box", orange, right);
    let tiny = document.light("tiny", [8e11, 7.2e11, 6e11]);
    document.add("tiny lamp", tiny, lamp(dvec3(0.1, 1.6, 0.4), DVec2::splat(2e-6)));
    let sky = document.light("sky", [0.3, 0.4, 0.6]);
    document.add("sky", sky, room(DVec3::splat(-2000.0), DVec3::splat(2000.0), &[]));
    document
}

/// [`plain`], seen from a point of the lamp's front.
pub(super) fn camera_on_light() -> Document {
    let mut document = plain();
    document.look(Eye { from: dvec3(0.05, 1.98, 0.1), to: dvec3(0.0, 0.0, 0.0), fov: 1.6 });
    document
}

/// [`plain`], with the camera turned away from it.
pub(super) fn camera_sees_nothing() -> Document {
    let mut document = plain();
    document.look(Eye { from: dvec3(0.0, 1.1, 3.9), to: dvec3(0.0, 1.1, 9.0), fov: 0.6 });
    document
}

/// A room without any light.
pub(super) fn no_light() -> Document {
    let mut document = Document::new(EYE);
    let white = document.diffuse("white", WHITE);
    document.add("room", white, room(dvec3(-1.0, 0.0, -1.0), dvec3(1.0, 2.0, 1.0), &[5]));
    document.add(
        "stones",
        white,
        (1..5).map(halton).map(|p| solid(p - 0.1, p + 0.1)).reduce(Shape::and).unwrap_or_default(),
    );
    document
}
