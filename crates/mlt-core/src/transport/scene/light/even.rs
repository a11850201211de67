//! A surface of triangles that emit alike, with an area-preserving map from the unit square.

use super::Piece;
use super::triangle::{interval, on_triangle, weights};
use glam::{DVec2, Vec3};

/// u runs through the triangles in proportion to their areas.
#[derive(Clone, Debug)]
pub(crate) struct Even {
    /// Their numbers in the scene.
    pub(crate) primitives: Vec<u32>,
    pub(crate) vertices: Vec<[Vec3; 3]>,
    /// Share of the area up to and with each.
    cumulative: Vec<f64>,
}

impl Even {
    /// Those of a list that have an area, and its sum; `None` if that is zero.
    pub(super) fn new(list: impl Iterator<Item = (u32, [Vec3; 3])>) -> Option<(Self, f64)> {
        let (mut primitives, mut vertices, mut cumulative, mut area) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
        for (primitive, [a, b, c]) in list {
            let part = 0.5 * f64::from((b - a).cross(c - a).length());
            if part > 0.0 && part.is_finite() {
                area += part;
                primitives.push(primitive);
                vertices.push([a, b, c]);
                cumulative.push(area);
            }
        }
        cumulative.iter_mut().for_each(|c| *c /= area);
        (area > 0.0).then_some((Self { primitives, vertices, cumulative }, area))
    }

    /// The triangles between two corners of the unit square, in the order of their numbers, and the first one's number.
    pub(super) fn pieces(&self, low: DVec2, high: DVec2) -> (u32, Vec<Piece>) {
        let Self { vertices, cumulative, .. } = self;
        let first = cumulative.partition_point(|&end| end <= low.x).min(vertices.len() - 1);
        let last = cumulative.partition_point(|&end| end < high.x).min(vertices.len() - 1);
        let piece = |i: usize| {
            let (begin, end) = interval(cumulative, i);
            let square = [DVec2::new(begin.max(low.x), low.y), DVec2::new(end.min(high.x), high.y)];
            Piece::new(square, &vertices[i])
        };
        (first as u32, (first..=last).map(piece).collect())
    }

    /// The centre of mass.
    pub(super) fn centre(&self) -> Vec3 {
        let weighted = |(i, [a, b, c]): (usize, &[Vec3; 3])| {
            let (low, high) = interval(&self.cumulative, i);
            ((high - low) as f32 / 3.0) * (*a + *b + *c)
        };
        self.vertices.iter().enumerate().map(weighted).sum()
    }

    /// Triangle and position at coordinates (u, v).
    #[inline(always)]
    pub(super) fn at(&self, u: f64, v: f64) -> (u32, Vec3) {
        let i = self.cumulative.partition_point(|&c| c <= u).min(self.primitives.len() - 1);
        let (low, high) = interval(&self.cumulative, i);
        let [a, b, c] = self.vertices[i];
        let [wb, wc] = on_triangle((u - low) / (high - low), v);
        (self.primitives[i], (1.0 - wb - wc) * a + wb * b + wc * c)
    }

    /// Coordinates of the point of triangle number `index` (in the order given) that is nearest to `position`.
    pub(super) fn coordinates(&self, index: u32, position: Vec3) -> (f64, f64) {
        let [a, b, c] = self.vertices[index as usize];
        let (wb, wc) = weights(position - a, b - a, c - a);
        let root = (wb + wc).min(1.0);
        let (low, high) = interval(&self.cumulative, index as usize);
        let v = if root > 0.0 { (wc / root).min(1.0) } else { 0.0 };
        (low + root * root * (high - low), v)
    }
}
