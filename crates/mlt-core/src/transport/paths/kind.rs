//! Kinds of paths, which some samplers find easy and others hard.

use super::path::LightPath;
use super::path_vertex::PathVertex;
use crate::transport::geometry::Vertex;
use crate::transport::scene::LightPoint;
use std::fmt;

/// Classes of length: 1, 2, 3–4, 5–8, 9–16 edges and more.
const LENGTHS: usize = 6;
/// Number of kinds.
pub const KINDS: usize = 2 * LENGTHS;

/// A path's class of length, and whether its light meets a specular surface first; or that it shows a light's image,
/// since nothing but specular surfaces lies between its ends.
///
/// Light that meets a specular surface first is what next-event estimation cannot sample: there is nothing to connect a
/// light to. An image of a light is what only camera rays meet, and all of them that pass there do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind(u8);

/// A set of kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kinds(u16);

impl Kind {
    /// The image of a light in specular surfaces, whatever their number.
    pub const IMAGE: Self = Self(1);

    /// The kind of a path of so many edges, at least one, that is no [`IMAGE`](Self::IMAGE); `specular`: x_1 is a delta
    /// vertex.
    #[inline]
    pub fn new(edges: usize, specular: bool) -> Self {
        // ⌈log₂ edges⌉
        let length = (usize::BITS - (edges.max(1) - 1).leading_zeros()).min(LENGTHS as u32 - 1) as u8;
        Self(2 * length + u8::from(specular && edges > 1))
    }

    /// The kind of a path that is given by what lies between its ends, x_1 first.
    #[inline]
    pub fn between(surfaces: &[PathVertex]) -> Self {
        let specular = |x: &PathVertex| x.vertex.delta;
        match surfaces.first() {
            Some(first) if specular(first) && surfaces.iter().all(specular) => Self::IMAGE,
            first => Self::new(surfaces.len() + 1, first.is_some_and(specular)),
        }
    }

    /// The kind of a path.
    #[inline]
    pub fn of(path: &LightPath) -> Self {
        Self::between(&path.vertices()[1..path.edges()])
    }

    /// Its number, below [`KINDS`].
    #[inline]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }

    /// The kind of a number below [`KINDS`].
    pub fn from_index(index: usize) -> Self {
        Self(index as u8)
    }

    /// Most edges of such a path, if no path has more than `most`.
    pub fn most_edges(self, most: usize) -> usize {
        let length = usize::from(self.0 / 2);
        if self == Self::IMAGE || length + 1 == LENGTHS { most } else { most.min(1 << length) }
    }
}

impl Kinds {
    /// None.
    pub const NONE: Self = Self(0);
    /// All.
    pub const ALL: Self = Self((1 << KINDS) - 1);

    /// Paths that camera rays find by themselves: to lights, and to their images in specular surfaces.
    pub const SEEN: Self = Self(0b11);

    /// The kinds of paths of 1, of 2 and of more edges, as far as `most` edges go; images of lights left out.
    ///
    /// Longer paths are one class: where few of them are left, a chain that is held among them cannot leave the place that it
    /// started from.
    pub fn by_length(most: usize) -> impl Iterator<Item = Self> {
        let [one, two] = [0b11, 0b1100].map(Self);
        [one.without(Kind::IMAGE), two, Self(one.0 | two.0).others()].into_iter().take(most)
    }

    /// Without one.
    #[must_use]
    pub const fn without(self, kind: Kind) -> Self {
        Self(self.0 & !(1 << kind.0))
    }

    /// Whether all of them are among `others`.
    pub fn is_within(self, others: Self) -> bool {
        self.0 & !others.0 == 0
    }

    /// With one more.
    #[must_use]
    pub fn with(self, kind: Kind) -> Self {
        Self(self.0 | 1 << kind.0)
    }

    /// All others.
    #[must_use]
    pub fn others(self) -> Self {
        Self(Self::ALL.0 & !self.0)
    }

    /// Whether a kind is among them.
    #[inline]
    pub fn contains(self, kind: Kind) -> bool {
        self.0 >> kind.0 & 1 == 1
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The kinds in it.
    pub fn iter(self) -> impl Iterator<Item = Kind> {
        (0..KINDS).map(Kind::from_index).filter(move |&kind| self.contains(kind))
    }

    /// Most edges of a path of one of the kinds, if no path has more than `most`; 0 for no kind.
    pub fn most_edges(self, most: usize) -> usize {
        self.iter().map(|kind| kind.most_edges(most)).max().unwrap_or(0)
    }
}

/// `3-4 edges` or `3-4, 5-8 edges, first specular`: what the kinds have in common is said once.
impl fmt::Display for Kinds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all =
            [0, 1].map(|s| (s..LENGTHS).filter(|&l| self.contains(Kind::from_index(2 * l + s))).collect::<Vec<_>>());
        let name = |&l: &usize| ["1", "2", "3-4", "5-8", "9-16", "17+"][l];
        let list = |lengths: &[usize]| lengths.iter().map(name).collect::<Vec<_>>().join(", ") + " edges";
        let longer = |lengths: &[usize]| lengths.iter().copied().filter(|&l| l > 0).collect::<Vec<_>>();
        match all {
            [plain, specular] if plain.is_empty() && specular.is_empty() => {}
            [plain, specular] if longer(&plain) == specular => f.write_str(&list(&plain))?,
            [plain, specular] if specular.is_empty() => write!(f, "{}, first not specular", list(&plain))?,
            [plain, specular] if plain.is_empty() => write!(f, "{}, first specular", list(&specular))?,
            [plain, specular] => write!(f, "{}, and first specular {}", list(&plain), list(&specular))?,
        }
        match (self.contains(Kind::IMAGE), self.without(Kind::IMAGE).is_empty()) {
            (true, true) => f.write_str("images of lights"),
            (true, false) => f.write_str(", images of lights"),
            (false, _) => Ok(()),
        }
    }
}

/// End of a path that a sampler does not build: where and how it meets the light.
#[derive(Clone, Copy, Debug)]
pub struct PathEnd<'a> {
    /// The path's kind.
    pub kind: Kind,
    /// x_0.
    pub light: LightEnd<'a>,
    /// f/√(Σ_t p_t²) over the contribution, the densities p_t being those of all techniques with the roulette that they share: 1/√w_s, times
    /// what a technique's own last roulette, and splitting, have made of it.
    pub scale: f64,
}

/// How x_0 was found.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum LightEnd<'a> {
    /// Drawn on the lights.
    Drawn(&'a LightPoint),
    /// Met by a ray.
    Met(&'a Vertex),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_classes_of_powers_of_two() {
        let classes = [(1, 0), (2, 1), (3, 2), (4, 2), (5, 3), (8, 3), (9, 4), (16, 4), (17, 5), (1000, 5)];
        for (edges, class) in classes {
            assert_eq!(Kind::new(edges, false).index(), 2 * class);
            assert_eq!(Kind::new(edges, true).index(), 2 * class + usize::from(edges > 1));
            assert!((edges..=2 * edges).contains(&Kind::new(edges, true).most_edges(1000).min(2 * edges)));
        }
    }

    #[test]
    fn sets_hold_what_they_were_given() {
        let (a, b) = (Kind::new(2, true), Kind::new(7, false));
        let set = Kinds::NONE.with(a).with(b);
        assert_eq!(set.iter().collect::<Vec<_>>(), [a, b]);
        assert_eq!((set.most_edges(1000), set.most_edges(6), Kinds::NONE.most_edges(9)), (8, 6, 0));
        assert_eq!(set.others().iter().count(), KINDS - 2);
        assert_eq!(set.to_string(), "5-8 edges, and first specular 2 edges");
        assert_eq!(Kinds::NONE.with(a).to_string(), "2 edges, first specular");
        let lengths: Vec<_> = Kinds::by_length(6).collect();
        assert_eq!([1, 2, 3, 1000].map(|most| Kinds::by_length(most).count()), [1, 2, 3, 3]);
        assert!(lengths[2].contains(b) && lengths[1].contains(a) && !lengths[2].contains(a));
        let holding = |kind| lengths.iter().filter(|kinds| kinds.contains(kind)).count();
        assert!((0..KINDS).all(|index| holding(Kind::from_index(index)) == usize::from(index != Kind::IMAGE.index())));
    }

    #[test]
    fn images_of_lights_have_any_length() {
        let images = Kinds::NONE.with(Kind::IMAGE);
        assert_eq!((images.most_edges(7), Kinds::SEEN.without(Kind::IMAGE).most_edges(7)), (7, 1));
        assert!(images.is_within(Kinds::SEEN) && !Kinds::ALL.is_within(Kinds::SEEN));
        assert_eq!(
            [images, Kinds::SEEN].map(|kinds| kinds.to_string()),
            ["images of lights", "1 edges, images of lights"]
        );
    }
}
