//! Polygons cut into triangles.
//!
//! A polygon is seen along the normal that its corners have on average (Newell's: the sum of p_i × p_{i+1}). A fan of
//! triangles about one corner is taken where it fills the polygon: about the first corner, as for convex ones, or about the
//! first reflex one. All others go through a constrained Delaunay triangulation of which the triangles with a
//! winding number other than zero are kept; so a hole that a bridge joins to the outline stays open.

use glam::{DVec2, DVec3};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation,
    handles::{FixedDirectedEdgeHandle, FixedVertexHandle},
};
use std::collections::HashMap;

/// Triangles of a polygon, as numbers of its corners.
pub(super) struct Cut {
    /// Wound as the polygon is.
    pub triangles: Vec<[usize; 3]>,
    /// Whether the outline crosses itself, so that no triangles are right; then they are a fan.
    pub crosses: bool,
}

/// Cuts a polygon, which needs not be flat, into triangles.
pub(super) fn cut(corners: &[DVec3]) -> Cut {
    if corners.len() < 4 {
        return Cut { triangles: fan(corners.len(), 0).collect(), crosses: false };
    }
    let outline = flattened(corners);
    let reflex = || (0..outline.len()).find(|&i| !is_left(&outline, [before(i, outline.len()), i, i + 1]));
    let about = |apex: usize| fan(outline.len(), apex).all(|t| is_left(&outline, t)).then_some(apex);
    if let Some(apex) = about(0).or_else(|| about(reflex()?)) {
        return Cut { triangles: fan(corners.len(), apex).collect(), crosses: false };
    }
    match constrained(&outline) {
        Some(triangles) => Cut { triangles, crosses: false },
        None => Cut { triangles: fan(corners.len(), 0).collect(), crosses: true },
    }
}

/// The triangles between a corner and all edges that it is no end of.
fn fan(corners: usize, apex: usize) -> impl Iterator<Item = [usize; 3]> {
    (1..corners.saturating_sub(1)).map(move |i| [apex, (apex + i) % corners, (apex + i + 1) % corners])
}

fn before(i: usize, corners: usize) -> usize {
    (i + corners - 1) % corners
}

/// The corners seen along their mean normal, from the side on which they run counter-clockwise.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let relative = |i: usize| corners[i % corners.len()] - corners[0];
    let normal: DVec3 = (0..corners.len()).map(|i| relative(i).cross(relative(i + 1))).sum();
    let axis = normal.abs().max_position();
    let [mut s, mut t] = [(axis + 1) % 3, (axis + 2) % 3];
    if normal[axis] < 0.0 {
        std::mem::swap(&mut s, &mut t);
    }
    (0..corners.len()).map(|i| DVec2::new(relative(i)[s], relative(i)[t])).collect()
}

/// Whether a triangle runs counter-clockwise or has no area.
fn is_left(outline: &[DVec2], triangle: [usize; 3]) -> bool {
    let [a, b, c] = triangle.map(|i| outline[i % outline.len()]);
    (b - a).perp_dot(c - a) >= 0.0
}

/// A corner with its number.
struct Corner {
    position: DVec2,
    number: usize,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.position.x, self.position.y)
    }
}

type Plane = ConstrainedDelaunayTriangulation<Corner>;

/// Triangles from a constrained Delaunay triangulation; `None` where edges cross or a coordinate is no number.
fn constrained(outline: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let (mut corners, mut places) = (Vec::new(), HashMap::new());
    let mut place = |(number, &position): (usize, &DVec2)| {
        // Zero has one sign.
        let key = (position + DVec2::ZERO).to_array().map(f64::to_bits);
        *places.entry(key).or_insert_with(|| {
            corners.push(Corner { position, number });
            FixedVertexHandle::from_index(corners.len() - 1)
        })
    };
    let path: Vec<_> = outline.iter().enumerate().map(&mut place).collect();
    let mut plane = Plane::bulk_load_cdt(corners, Vec::new()).ok()?;
    let mut sides = Vec::new();
    for (i, &from) in path.iter().enumerate() {
        let to = path[(i + 1) % path.len()];
        if from != to {
            let added = plane.try_add_constraint(from, to);
            sides.extend((!added.is_empty()).then_some(added)?);
        }
    }
    Some(inside(&plane, &sides))
}

/// The triangles that the outline, made of directed edges, runs around.
fn inside(plane: &Plane, outline: &[FixedDirectedEdgeHandle]) -> Vec<[usize; 3]> {
    let mut passes = vec![0i32; plane.num_directed_edges()];
    outline.iter().for_each(|edge| passes[edge.index()] += 1);
    let mut seen = vec![false; plane.num_all_faces()];
    let mut triangles = Vec::new();
    // Edges into faces, with the winding number of where they are entered from.
    let hull = plane.directed_edges().filter(|edge| edge.face().is_outer());
    let mut entries: Vec<_> = hull.map(|edge| (edge.rev(), 0)).collect();
    while let Some((edge, outside)) = entries.pop() {
        let Some(face) = edge.face().as_inner() else { continue };
        if std::mem::replace(&mut seen[face.index()], true) {
            continue;
        }
        let winding = outside + passes[edge.fix().index()] - passes[edge.rev().fix().index()];
        if winding != 0 {
            triangles.push(face.vertices().map(|corner| corner.data().number));
        }
        entries.extend(face.adjacent_edges().map(|edge| (edge.rev(), winding)));
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Sum of the triangles' areas with the sign of their winding, seen along z; and without.
    fn areas(corners: &[DVec3], triangles: &[[usize; 3]]) -> [f64; 2] {
        let area = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i].truncate());
            0.5 * (b - a).perp_dot(c - a)
        };
        [triangles.iter().map(area).sum(), triangles.iter().map(|t| area(t).abs()).sum()]
    }

    fn outline_area(corners: &[DVec3]) -> f64 {
        let next = |i: usize| corners[(i + 1) % corners.len()];
        corners.iter().enumerate().map(|(i, a)| 0.5 * a.truncate().perp_dot(next(i).truncate())).sum()
    }

    fn polygon(points: &[[f64; 2]]) -> Vec<DVec3> {
        points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
    }

    /// Whether the triangles fill the outline once, with its winding.
    fn fills(corners: &[DVec3], triangles: &[[usize; 3]]) -> bool {
        let (whole, found) = (outline_area(corners), areas(corners, triangles));
        (found[0] - whole).abs() < 1e-9 * whole.abs() && (found[1] - whole.abs()).abs() < 1e-9 * whole.abs()
    }

    fn expect_filled(name: &str, corners: &[DVec3]) {
        for start in [0, 1, corners.len() / 2] {
            let mut turned = corners.to_vec();
            turned.rotate_left(start);
            for corners in [turned.clone(), turned.into_iter().rev().collect()] {
                let Cut { triangles, crosses } = cut(&corners);
                assert!(!crosses && fills(&corners, &triangles), "{name} from {start}: {triangles:?}");
            }
        }
    }

    /// A comb whose teeth are n high and one wide.
    fn comb(corners: usize) -> Vec<DVec3> {
        let tooth = |i: usize| [(corners - i) as f64, if i.is_multiple_of(2) { 1.0 } else { corners as f64 }];
        let mut points = vec![[1.0, 0.0], [corners as f64, 0.0]];
        points.extend((0..corners - 2).map(tooth));
        polygon(&points)
    }

    fn star(corners: usize) -> Vec<DVec3> {
        let point = |i: usize| {
            let (angle, radius) = (TAU * i as f64 / corners as f64, if i.is_multiple_of(2) { 1.0 } else { 0.3 });
            [radius * angle.cos(), radius * angle.sin()]
        };
        polygon(&(0..corners).map(point).collect::<Vec<_>>())
    }

    #[test]
    fn polygons_are_filled_once() {
        expect_filled("square", &polygon(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]));
        expect_filled("arrow", &polygon(&[[0., 2.], [-1., 0.], [0., 0.5], [1., 0.]]));
        expect_filled("on a line", &polygon(&[[0., 0.], [1., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 1.], [0., 1.]]));
        expect_filled("twice the same corner", &polygon(&[[0., 2.], [-1., 0.], [0., 0.5], [0., 0.5], [1., 0.]]));
        let u = [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
        expect_filled("U", &polygon(&u));
        let [inner, outer] =
            [[[1., 1.], [1., 2.], [2., 2.], [2., 1.], [1., 1.]], [[0., 0.], [3., 0.], [3., 3.], [0., 3.], [0., 0.]]];
        expect_filled("a frame with a bridge", &polygon(&[outer, inner].concat()));
        expect_filled("star", &star(10));
        expect_filled("comb", &comb(42));
        let tilted: Vec<_> =
            star(12).into_iter().map(|p| DVec3::new(p.x, p.y, 5.0 * p.x - 3.0 * p.y + p.x * p.y)).collect();
        assert!(fills(&tilted, &cut(&tilted).triangles));
    }

    /// The control of the test above: the fan about the first corner does not fill a concave polygon.
    #[test]
    fn a_fan_does_not_fill_an_arrow() {
        let arrow = polygon(&[[1., 0.], [0., 2.], [-1., 0.], [0., 0.5]]);
        assert!(!fills(&arrow, &fan(4, 0).collect::<Vec<_>>()));
    }

    #[test]
    fn crossing_outlines_are_said() {
        let bow = polygon(&[[0., 0.], [3., 2.], [3., 0.], [0., 1.]]);
        assert!(cut(&bow).crosses);
        assert_eq!(cut(&bow).triangles.len(), 2);
        for nothing in [vec![], polygon(&[[0., 0.]]), vec![DVec3::ONE; 5], vec![DVec3::NAN; 5]] {
            assert!(cut(&nothing).triangles.len() <= 3);
        }
    }

    #[test]
    fn many_corners_take_little_time() {
        let begin = std::time::Instant::now();
        for large in [star(100_000), comb(10_000)] {
            assert!(fills(&large, &cut(&large).triangles));
        }
        assert!(begin.elapsed().as_secs() < 60, "{:?}", begin.elapsed());
    }
}
