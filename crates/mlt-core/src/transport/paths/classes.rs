//! Strata of path space that have nothing to do with lights: path lengths and tiles of the image.

use super::kind::{Kind, Kinds};
use super::path::LightPath;
use glam::Vec2;

/// Which classes path space is cut into, besides the lights' parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Classes {
    /// By the number of edges: 1, 2 and more; images of lights, of any length, apart.
    pub lengths: bool,
    /// Columns and rows of tiles.
    pub tiles: [u32; 2],
}

impl Default for Classes {
    /// One class.
    fn default() -> Self {
        Self { lengths: false, tiles: [1, 1] }
    }
}

/// Paths of some kinds that cross a rectangle of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathClass {
    /// The kinds.
    pub kinds: Kinds,
    /// Corner of the rectangle with the smallest coordinates, in [0, 1]².
    pub low: Vec2,
    /// The opposite corner, which belongs to the next rectangle.
    pub high: Vec2,
}

impl Classes {
    /// All classes: a partition of the paths of at most `max_edges` edges. `specular`: whether any surface is.
    pub fn all(&self, max_edges: usize, specular: bool) -> Vec<PathClass> {
        let [columns, rows] = self.tiles.map(|n| n.max(1));
        let size = Vec2::new(columns as f32, rows as f32);
        let corners = (0..rows).flat_map(|y| (0..columns).map(move |x| Vec2::new(x as f32, y as f32)));
        let tiles: Vec<_> = corners.map(|corner| (corner / size, (corner + Vec2::ONE) / size)).collect();
        let with = |kinds| tiles.iter().map(move |&(low, high)| PathClass { kinds, low, high });
        self.kinds(max_edges, specular).into_iter().flat_map(with).collect()
    }

    fn kinds(&self, max_edges: usize, specular: bool) -> Vec<Kinds> {
        if !self.lengths {
            return vec![Kinds::ALL];
        }
        let images = (specular && max_edges > 1).then(|| Kinds::NONE.with(Kind::IMAGE));
        Kinds::by_length(max_edges).chain(images).collect()
    }
}

impl PathClass {
    /// Paths of some kinds, wherever they cross the image.
    pub fn of_kinds(kinds: Kinds) -> Self {
        Self { kinds, low: Vec2::ZERO, high: Vec2::ONE }
    }

    /// Whether the path belongs to it.
    #[inline]
    pub fn contains(&self, path: &LightPath) -> bool {
        let inside = path.film.cmpge(self.low).all() && path.film.cmplt(self.high).all();
        inside && self.kinds.contains(Kind::of(path))
    }

    /// Its part of the image.
    pub fn area(&self) -> f64 {
        let size = self.high - self.low;
        f64::from(size.x) * f64::from(size.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_a_partition() {
        for (lengths, max_edges) in [(true, 1), (true, 2), (true, 3), (true, 7), (true, 1000), (false, 5)] {
            let classes = Classes { lengths, tiles: [3, 2] };
            let all = classes.all(max_edges, true);
            let images = (max_edges > 1).then_some(Kind::IMAGE);
            for kind in (1..=max_edges).map(|edges| Kind::new(edges, edges % 2 == 1)).chain(images) {
                let area: f64 = all.iter().filter(|c| c.kinds.contains(kind)).map(PathClass::area).sum();
                assert!((area - 1.0).abs() < 1e-6, "{kind:?} of {max_edges}: {area}");
            }
            let rectangles: Vec<_> = all.iter().take(6).map(|c| (c.low, c.high)).collect();
            for [x, y] in [[0.0, 0.0], [0.34, 0.49], [0.5, 0.5], [0.999, 0.999]] {
                let p = Vec2::new(x, y);
                assert_eq!(rectangles.iter().filter(|(l, h)| p.cmpge(*l).all() && p.cmplt(*h).all()).count(), 1);
            }
        }
    }
}
