//! The parts of path space that are measured one by one.

use super::constants::LENGTHS;
use crate::transport::lights::LightStrata;
use crate::transport::methods::independent::Selection;
use crate::transport::paths::{KINDS, Kind, Kinds, LightEnd, PathEnd};
use crate::transport::scene::Lights;

/// A part: the paths of some kinds that start in one part of the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PartIndex {
    /// Number of the lights' part.
    pub(super) light: usize,
    /// Number of the group of kinds.
    pub(super) group: usize,
}

/// Products of the lights' parts and of groups of kinds, in this order.
pub(super) struct Parts<'a> {
    pub(super) lights: &'a Lights,
    pub(super) strata: &'a LightStrata,
    /// Whether the lights' parts were asked for, and chains have to keep to them.
    pub(super) asked_for: bool,
    /// Disjoint sets that together hold all kinds that the scene has.
    pub(super) groups: Vec<Kinds>,
    /// The group of each kind.
    group_of: [u8; KINDS],
}

impl<'a> Parts<'a> {
    /// `specular`: whether anything in the scene is; kinds that it lacks are not told apart.
    pub(super) fn new(lights: &'a Lights, strata: &'a LightStrata, max_edges: usize, specular: bool) -> Self {
        let of_length = |[least, most]: [usize; 2], special: bool| {
            let ends = [least, most].map(|edges| Kind::new(edges, special).index());
            let inside = |kind: &Kind| kind.index() % 2 == ends[0] % 2 && (ends[0]..=ends[1]).contains(&kind.index());
            Kinds::ALL.iter().filter(inside).fold(Kinds::NONE, Kinds::with)
        };
        let mut groups = Vec::new();
        for length in LENGTHS.into_iter().filter(|[least, _]| *least <= max_edges) {
            let [plain, special] = [false, true].map(|special| of_length(length, special));
            match length {
                [1, _] if specular => groups.extend([plain, Kinds::NONE.with(Kind::IMAGE)]),
                [least, _] if specular && least > 2 => groups.extend([plain, special]),
                // The one surface of a path of two edges is specular in images only.
                _ => groups.push(special.iter().fold(plain, Kinds::with)),
            }
        }
        let group_of = std::array::from_fn(|kind| {
            let holds = |group: &Kinds| group.contains(Kind::from_index(kind));
            groups.iter().position(holds).unwrap_or(groups.len() - 1) as u8
        });
        Self { lights, strata, asked_for: false, groups, group_of }
    }

    /// Number of parts.
    pub(super) fn len(&self) -> usize {
        self.strata.regions().len() * self.groups.len()
    }

    /// Which part has a number.
    pub(super) fn at(&self, number: usize) -> PartIndex {
        PartIndex { light: number / self.groups.len(), group: number % self.groups.len() }
    }

    /// The number of a part.
    fn number(&self, PartIndex { light, group }: PartIndex) -> usize {
        light * self.groups.len() + group
    }

    /// The kinds of paths in a part.
    pub(super) fn group(&self, part: usize) -> Kinds {
        self.groups[self.at(part).group]
    }

    /// Knowledge of each part, in one slice for each of the lights' parts.
    pub(super) fn by_light<'v, T>(&self, of_parts: &'v [T]) -> impl Iterator<Item = &'v [T]> {
        of_parts.chunks(self.groups.len())
    }

    /// A part and those of the same light's parts that may be left to chains, have shorter paths, and meet a specular surface first
    /// if its paths do.
    pub(super) fn no_longer_than(&self, part: usize) -> impl Iterator<Item = usize> {
        let specular = |part: usize| self.group(part).iter().all(|kind| kind.index() % 2 == 1);
        let open = move |&other: &usize| !self.group(other).is_within(Kinds::SEEN) && specular(other) == specular(part);
        let first = self.number(PartIndex { group: 0, ..self.at(part) });
        (first..part).filter(open).chain([part])
    }

    /// The parts that may be left to chains: all but what camera rays meet by themselves.
    pub(super) fn open_to_chains(&self) -> Vec<usize> {
        (0..self.len()).filter(|&part| !self.group(part).is_within(Kinds::SEEN)).collect()
    }

    /// One value for each part: what was found of those that may be left to chains, in their order, and nothing of the others.
    pub(super) fn of_all<T: Clone + Default>(&self, found: Vec<T>) -> Vec<T> {
        let mut all = vec![T::default(); self.len()];
        self.open_to_chains().into_iter().zip(found).for_each(|(part, value)| all[part] = value);
        all
    }

    /// Which part a path belongs to.
    pub(super) fn index(&self, end: &PathEnd) -> usize {
        let light = stratum(self.lights, self.strata, end);
        self.number(PartIndex { light, group: usize::from(self.group_of[end.kind.index()]) })
    }
}

/// The light's part that a path starts in.
fn stratum(lights: &Lights, strata: &LightStrata, end: &PathEnd) -> usize {
    if strata.regions().len() == 1 {
        return 0;
    }
    match end.light {
        LightEnd::Drawn(point) => strata.index(point) as usize,
        LightEnd::Met(x) => lights.point(x.primitive, x.position).map_or(0, |point| strata.index(&point) as usize),
    }
}

/// The paths of some kinds in each part of the lights.
#[derive(Debug)]
pub struct SomePaths<'a> {
    /// The lights.
    pub lights: &'a Lights,
    /// Their parts.
    pub strata: &'a LightStrata,
    /// One set for each part.
    pub kinds: &'a [Kinds],
}

impl Selection for SomePaths<'_> {
    #[inline]
    fn contains(&self, end: &PathEnd) -> bool {
        self.kinds[stratum(self.lights, self.strata, end)].contains(end.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::lights::Stratification;
    use crate::transport::tests::worlds::pond;

    #[test]
    fn longer_paths_follow_those_that_meet_light_alike() {
        let world = pond();
        let lights = world.scene.lights();
        let strata = LightStrata::new(lights, Stratification::None);
        let names = |specular: bool, part: usize| -> Vec<String> {
            let parts = Parts::new(lights, &strata, 100, specular);
            parts.no_longer_than(part).map(|part| parts.group(part).to_string()).collect()
        };
        assert_eq!(names(false, 2), ["2 edges", "3-4 edges"]);
        assert_eq!(
            names(true, 5),
            ["2 edges", "3-4 edges, first not specular", "5-8, 9-16, 17+ edges, first not specular"]
        );
        assert_eq!(names(true, 6), ["3-4 edges, first specular", "5-8, 9-16, 17+ edges, first specular"]);
        assert_eq!(names(true, 0), ["1 edges"]);
    }
}
