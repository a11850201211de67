//! Surfaces that emit unevenly: each triangle is cut into equal parts, and a part gets its share of the unit square by its power.
//!
//! Inside a part points are uniform by area. A tenth of a light's power is spread evenly over it, so that what shines where no sample
//! of the texture showed it can still be drawn.

use super::Piece;
use super::triangle::{interval, on_triangle, weights};
use crate::transport::colour::{Rgb, luminance};
use glam::{DVec2, Vec3};
use rayon::prelude::*;

/// Parts of a light, about.
const PARTS: f64 = 4096.0;
/// Most parts along a triangle's side.
const MOST_SIDES: f64 = 64.0;
/// Samples along a side of a part.
const SAMPLES: u32 = 4;
/// Share of the power that is spread evenly.
const EVEN: f64 = 0.1;

/// Triangles that emit unevenly.
#[derive(Clone, Debug)]
pub(crate) struct Uneven {
    triangles: Vec<(u32, [Vec3; 3])>,
    /// Parts along each side.
    sides: u32,
    /// Share of the power up to the end of each part, triangle by triangle.
    cumulative: Vec<f64>,
    /// M of each part over the light's mean, as points are drawn.
    relative: Vec<f64>,
    pub(super) brightest: Rgb,
}

/// A part of a triangle: a row of a column of cells, of which it is one half.
#[derive(Clone, Copy)]
struct Part {
    column: u32,
    row: u32,
    upper: bool,
}

impl Part {
    /// The part of a number among those of a triangle.
    fn new(number: u32, sides: u32) -> Self {
        // Before column i lie i (2 n − i) parts.
        let before = |column: u32| column * (2 * sides - column);
        let column = (0..sides).take_while(|&column| before(column) <= number).last().unwrap_or(0);
        let place = number - before(column);
        Self { column, row: place / 2, upper: place % 2 == 1 }
    }

    /// Its number.
    fn number(self, sides: u32) -> u32 {
        self.column * (2 * sides - self.column) + 2 * self.row + u32::from(self.upper)
    }

    /// The part at barycentric weights of the second and third vertex.
    fn at([b, c]: [f64; 2], sides: u32) -> Self {
        let n = f64::from(sides);
        let column = ((b * n) as u32).min(sides - 1);
        let row = ((c * n) as u32).min(sides - 1 - column);
        let upper = b * n - f64::from(column) + c * n - f64::from(row) > 1.0 && column + row + 1 < sides;
        Self { column, row, upper }
    }

    /// Barycentric weights of its corners.
    fn corners(self, sides: u32) -> [[f64; 2]; 3] {
        let at = |i: u32, j: u32| [self.column + i, self.row + j].map(|x| f64::from(x) / f64::from(sides));
        if self.upper { [at(1, 1), at(0, 1), at(1, 0)] } else { [at(0, 0), at(1, 0), at(0, 1)] }
    }
}

/// The point of these weights.
fn point([a, b, c]: [Vec3; 3], [u, v]: [f64; 2]) -> Vec3 {
    (1.0 - u - v) as f32 * a + u as f32 * b + v as f32 * c
}

/// Mean of a function over a part of a triangle, by samples at the centres of a smaller cut.
fn mean_over(corners: [[f64; 2]; 3], value: impl Fn([f32; 2]) -> Rgb) -> Rgb {
    let [a, b, c] = corners.map(DVec2::from);
    let samples = (0..SAMPLES * SAMPLES).map(|i| {
        let centre = Part::new(i, SAMPLES).corners(SAMPLES).map(DVec2::from).iter().sum::<DVec2>() / 3.0;
        let at = a + centre.x * (b - a) + centre.y * (c - a);
        value(at.as_vec2().to_array())
    });
    samples.sum::<Rgb>() / (SAMPLES * SAMPLES) as f32
}

impl Uneven {
    /// Triangles that emit `glow` at barycentric weights of one of them, at most `brightest`; their area, and their mean emission; `None`:
    /// they emit nothing.
    pub(super) fn new(
        triangles: Vec<(u32, [Vec3; 3])>,
        brightest: Rgb,
        glow: impl Fn(usize, [f32; 2]) -> Rgb + Sync,
    ) -> Option<(Self, f64, Rgb)> {
        let area = |[a, b, c]: [Vec3; 3]| 0.5 * f64::from((b - a).cross(c - a).length());
        let total: f64 = triangles.iter().map(|t| area(t.1)).sum();
        let sides = (PARTS / triangles.len().max(1) as f64).sqrt().clamp(1.0, MOST_SIDES) as u32;
        let parts = triangles.len() * (sides * sides) as usize;
        let mean = |i: usize| {
            let (triangle, part) = (i / (sides * sides) as usize, Part::new(i as u32 % (sides * sides), sides));
            mean_over(part.corners(sides), |at| glow(triangle, at))
        };
        let means: Vec<Rgb> = (0..parts).into_par_iter().map(mean).collect();
        let share = |i: usize| area(triangles[i / (sides * sides) as usize].1) / (f64::from(sides * sides) * total);
        let emission: glam::DVec3 = means.iter().enumerate().map(|(i, mean)| share(i) * mean.as_dvec3()).sum();
        let mean = f64::from(luminance(emission.as_vec3()));
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let relative = means.iter().map(|part| EVEN + (1.0 - EVEN) * f64::from(luminance(*part)) / mean);
        let relative: Vec<f64> = relative.collect();
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = (0..parts)
            .map(|i| {
                sum += share(i) * relative[i];
                sum
            })
            .collect();
        cumulative.iter_mut().for_each(|c| *c /= sum);
        Some((Self { triangles, sides, cumulative, relative, brightest }, total, emission.as_vec3()))
    }

    /// Parts of a triangle.
    fn parts(&self) -> usize {
        (self.sides * self.sides) as usize
    }

    /// The interval of u of a triangle.
    fn interval(&self, index: usize) -> (f64, f64) {
        let (begin, end) = (index * self.parts(), (index + 1) * self.parts());
        (interval(&self.cumulative, begin).0, self.cumulative[end - 1])
    }

    /// As of [`Area`](super::Area).
    pub(super) fn pieces(&self, low: DVec2, high: DVec2) -> (u32, Vec<Piece>) {
        let find = |part: usize| (part / self.parts()).min(self.triangles.len() - 1);
        let first = find(self.cumulative.partition_point(|&end| end <= low.x));
        let last = find(self.cumulative.partition_point(|&end| end < high.x));
        let piece = |i: usize| {
            let (begin, end) = self.interval(i);
            let square = [DVec2::new(begin.max(low.x), low.y), DVec2::new(end.min(high.x), high.y)];
            Piece::new(square, &self.triangles[i].1)
        };
        (first as u32, (first..=last).map(piece).collect())
    }

    /// As of [`Area`](super::Area).
    pub(super) fn centre(&self) -> Vec3 {
        let weighted = |(i, (_, [a, b, c])): (usize, &(u32, [Vec3; 3]))| {
            let (low, high) = self.interval(i);
            ((high - low) as f32 / 3.0) * (*a + *b + *c)
        };
        self.triangles.iter().enumerate().map(weighted).sum()
    }

    /// As of [`Area`](super::Area).
    pub(super) fn at(&self, u: f64, v: f64) -> (u32, Vec3) {
        let i = self.cumulative.partition_point(|&c| c <= u).min(self.cumulative.len() - 1);
        let (primitive, corners) = self.triangles[i / self.parts()];
        let part = Part::new((i % self.parts()) as u32, self.sides).corners(self.sides);
        let (low, high) = interval(&self.cumulative, i);
        let [b, c] = on_triangle((u - low) / (high - low), v).map(f64::from);
        let [p, q, r] = part.map(DVec2::from);
        (primitive, point(corners, (p + b * (q - p) + c * (r - p)).to_array()))
    }

    /// As of [`Area`](super::Area).
    pub(super) fn coordinates(&self, index: u32, position: Vec3) -> (f64, f64) {
        let (i, [p, q, r]) = self.part(index, position);
        let [a, b, c] = [p, q, r];
        let (wb, wc) = weights(position - a, b - a, c - a);
        let root = (wb + wc).min(1.0);
        let (low, high) = interval(&self.cumulative, i);
        let v = if root > 0.0 { (wc / root).min(1.0) } else { 0.0 };
        (low + root * root * (high - low), v)
    }

    /// M over its mean, as points are drawn, at a position of a triangle.
    pub(super) fn relative(&self, index: u32, position: Vec3) -> f64 {
        self.relative[self.part(index, position).0]
    }

    /// Number and corners of the part of a triangle that a position is nearest to.
    fn part(&self, index: u32, position: Vec3) -> (usize, [Vec3; 3]) {
        let (_, corners) = self.triangles[index as usize];
        let [a, b, c] = corners;
        let part = Part::at(weights(position - a, b - a, c - a).into(), self.sides);
        let number = index as usize * self.parts() + part.number(self.sides) as usize;
        (number, part.corners(self.sides).map(|at| point(corners, at)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Area, Light, Shape};
    use super::*;

    fn light() -> Light {
        let corners = [[0., 0., 0.], [2., 0., 0.], [0., 1., 0.]].map(Vec3::from_array);
        let other = [[0., 0., 1.], [1., 0., 1.], [0., 3., 1.]].map(Vec3::from_array);
        let glow = |i: usize, [b, c]: [f32; 2]| Rgb::splat(if b > 0.5 { 0.0 } else { 1.0 + i as f32 + 4.0 * c });
        Light::uneven(vec![(7, corners), (9, other)], Rgb::splat(6.0), glow).unwrap()
    }

    #[test]
    fn parts_have_numbers_of_their_own() {
        for sides in [1, 2, 5, 64] {
            for number in 0..sides * sides {
                let part = Part::new(number, sides);
                assert_eq!(part.number(sides), number);
                let centre = part.corners(sides).map(DVec2::from).iter().sum::<DVec2>() / 3.0;
                assert_eq!(Part::at(centre.to_array(), sides).number(sides), number);
            }
        }
    }

    #[test]
    fn points_lead_back_to_their_coordinates() {
        let light = light();
        let Shape::Area(area) = &light.shape else { panic!("no area") };
        let mut lit = 0.0;
        for i in 0..10_000 {
            let (u, v) = ((f64::from(i) + 0.5) / 10_000.0, f64::from(i) * 0.618_034 % 1.0);
            let (primitive, position) = area.at(u, v);
            let index = u32::from(primitive == 9);
            let (again, _) = light.coordinates(index, position);
            assert!((again - u).abs() < 2e-3, "{u} {v}: {again}");
            lit += f64::from(u8::from(position.x < if index == 0 { 1.0 } else { 0.5 })) / 10_000.0;
        }
        // A tenth of the power is spread evenly, of which a quarter falls on the dark, and some parts lie on the border.
        assert!((lit - 0.971).abs() < 5e-3, "{lit}");
    }

    /// ∫ M is the power: Σ over the points that are drawn of 1/density is the area.
    #[test]
    fn density_is_exitance_over_power() {
        let light = light();
        let Shape::Area(area) = &light.shape else { panic!("no area") };
        let count = 20_000;
        let drawn = |i: u32| {
            let (primitive, position) =
                area.at((f64::from(i) + 0.5) / f64::from(count), f64::from(i) * 0.618_034 % 1.0);
            let Area::Uneven(uneven) = area else { panic!("even") };
            1.0 / uneven.relative(u32::from(primitive == 9), position)
        };
        let mean = (0..count).map(drawn).sum::<f64>() / f64::from(count);
        assert!((mean - 1.0).abs() < 5e-3, "{mean}");
        assert!((light.measure - 2.5).abs() < 1e-6);
    }
}
