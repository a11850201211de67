//! Rectangles, boxes, walls with holes, balls. No function here rounds differently from machine to machine.

use super::document::Shape;
use glam::{DVec2, DVec3, dvec3};

/// The parallelogram at `corner` along `a` and `b`, its front towards a × b.
pub(super) fn quad(corner: DVec3, a: DVec3, b: DVec3) -> Shape {
    let positions = vec![corner, corner + a, corner + a + b, corner + b];
    Shape { positions, normals: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

/// The faces of an axis-parallel box, -x, +x, -y, +y, -z, +z, fronts outwards.
fn faces(low: DVec3, high: DVec3) -> [Shape; 6] {
    let DVec3 { x, y, z } = high - low;
    let (x, y, z) = (DVec3::X * x, DVec3::Y * y, DVec3::Z * z);
    [quad(low, z, y), quad(high, -y, -z), quad(low, x, z), quad(high, -z, -x), quad(low, y, x), quad(high, -x, -y)]
}

/// A box seen from outside.
pub(super) fn solid(low: DVec3, high: DVec3) -> Shape {
    faces(low, high).into_iter().reduce(Shape::and).unwrap_or_default()
}

/// The same seen from inside, without the faces listed (0…5: -x, +x, -y, +y, -z, +z).
pub(super) fn room(low: DVec3, high: DVec3, open: &[usize]) -> Shape {
    let closed = faces(low, high).into_iter().enumerate().filter(|(i, _)| !open.contains(i)).map(|(_, face)| face);
    flipped(closed.reduce(Shape::and).unwrap_or_default())
}

/// Front and back exchanged.
pub(super) fn flipped(mut shape: Shape) -> Shape {
    shape.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    shape.normals.iter_mut().for_each(|n| *n = -*n);
    shape
}

/// The rectangle of [`quad`] with a hole from `low` to `high`, each as shares of the two edges.
pub(super) fn holed(corner: DVec3, a: DVec3, b: DVec3, low: DVec2, high: DVec2) -> Shape {
    let part =
        |from: DVec2, to: DVec2| quad(corner + a * from.x + b * from.y, a * (to.x - from.x), b * (to.y - from.y));
    let parts = [
        (DVec2::ZERO, DVec2::new(1.0, low.y)),
        (DVec2::new(0.0, high.y), DVec2::ONE),
        (DVec2::new(0.0, low.y), DVec2::new(low.x, high.y)),
        (DVec2::new(high.x, low.y), DVec2::new(1.0, high.y)),
    ];
    let kept = parts.into_iter().filter(|(from, to)| to.cmpgt(*from).all());
    kept.map(|(from, to)| part(from, to)).reduce(Shape::and).unwrap_or_default()
}

/// A smooth ball: an octahedron whose triangles were each cut into four, `levels` times.
pub(crate) fn ball(centre: DVec3, radius: f64, levels: u32) -> Shape {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for (a, b) in [(x, z), (z, -x), (-x, -z), (-z, x)] {
        triangles.extend([[y, b, a], [-y, a, b]]);
    }
    for _ in 0..levels {
        let cut = |[a, b, c]: [DVec3; 3]| {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| (p + q).normalize());
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    let mut shape = Shape::default();
    for corner in triangles.into_iter().flatten() {
        shape.positions.push(centre + radius * corner);
        shape.normals.push(corner.as_vec3());
    }
    shape.triangles = (0..shape.positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    shape
}

/// A horizontal rectangle of this centre and size (along x and z), its front down.
pub(super) fn lamp(centre: DVec3, size: DVec2) -> Shape {
    let corner = centre - dvec3(0.5 * size.x, 0.0, 0.5 * size.y);
    quad(corner, DVec3::X * size.x, DVec3::Z * size.y)
}

/// Point `index` of a low-discrepancy sequence in the unit cube (Halton, bases 2, 3, 5).
pub(super) fn halton(index: u32) -> DVec3 {
    let inverse = |base: u32| {
        let (mut rest, mut digit, mut sum) = (index, 1.0, 0.0);
        while rest > 0 {
            digit /= f64::from(base);
            sum += digit * f64::from(rest % base);
            rest /= base;
        }
        sum
    };
    dvec3(inverse(2), inverse(3), inverse(5))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume inside, by the divergence theorem: positive if fronts face outwards.
    fn volume(shape: &Shape) -> f64 {
        let signed = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| shape.positions[i as usize]);
            a.cross(b).dot(c) / 6.0
        };
        shape.triangles.iter().map(signed).sum()
    }

    #[test]
    fn fronts_face_the_way_they_should() {
        let (low, high) = (dvec3(-1.0, 0.0, 2.0), dvec3(1.0, 3.0, 4.0));
        assert!((volume(&solid(low, high)) - 12.0).abs() < 1e-12);
        assert!((volume(&room(low, high, &[])) + 12.0).abs() < 1e-12);
        let ball = volume(&ball(DVec3::ONE, 2.0, 4));
        assert!((ball / (32.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{ball}");
        let lamp = lamp(DVec3::ZERO, DVec2::ONE);
        let [a, b, c] = lamp.triangles[0].map(|i| lamp.positions[i as usize]);
        assert!((b - a).cross(c - a).y < 0.0);
    }

    #[test]
    fn a_hole_takes_its_area() {
        let shape = holed(DVec3::ZERO, 2.0 * DVec3::X, DVec3::Y, DVec2::new(0.25, 0.0), DVec2::new(0.5, 0.5));
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| shape.positions[i as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        assert!((shape.triangles.iter().map(area).sum::<f64>() - 1.75).abs() < 1e-12);
    }
}
