//! The strata of path space, as the engine sees them.

use crate::engine::{Share, Stratum, uniform_f32};
use crate::transport::lights::{LightRegion, LightStrata};
use crate::transport::methods::bidirectional::{Bidirectional, ByChance, Guide};
use crate::transport::paths::mis::{self, Ends, met_by_chance};
use crate::transport::paths::{Classes, Kinds, LightPath, PathClass};
use crate::transport::scene::{LightPoint, View};
use glam::Vec2;
use rand_pcg::rand_core::Rng;

/// Ω_j: the paths of one class that start in part j of the lights; with [`Variant::MutationOnly`](super::Variant::MutationOnly) all of them.
///
/// Paths that nothing but a camera subpath meets (L S S E, L S D S E) are strata of their own, not cut by the lights' parts: none
/// of their light ends can be drawn, and each of K parts would keep a Kth of those that its samples meet.
///
/// Source: [Jankauski15], section 4.1; what is met by chance is not cut apart there.
#[derive(Clone, Copy, Debug)]
pub struct LightStratum<'a> {
    strata: &'a LightStrata,
    held: Held,
    class: PathClass,
    /// Whether Ω_j is all of path space, so that no path has to be looked at.
    everything: bool,
    sampler: Bidirectional<'a>,
    /// For what is met by chance.
    guide: Option<&'a Guide>,
}

/// Which paths of its class a stratum holds.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
enum Held {
    /// All; the light end is drawn again within its part.
    All,
    /// Those that start in this part of the lights.
    Part(u32),
    /// Those of them that some connection makes.
    Connected(u32),
    /// Those that no connection makes, wherever they start.
    Met,
}

impl<'a> LightStratum<'a> {
    /// All strata over the lights of a view, in the order of their parts.
    pub fn all(strata: &'a LightStrata, view: View<'a>, max_edges: usize) -> Vec<Self> {
        Self::product(strata, view, max_edges, Classes::default())
    }

    /// The products of the lights' parts and of classes; after them, what is met by chance, where there are several parts and a
    /// specular surface. Its lengths are one class.
    pub(crate) fn product(strata: &'a LightStrata, view: View<'a>, max_edges: usize, classes: Classes) -> Vec<Self> {
        let apart = view.scene.needs().met_by_chance && strata.regions().len() > 1;
        let of_part = |index: usize| {
            let held = if apart { Held::Connected(index as u32) } else { Held::Part(index as u32) };
            let of_class = move |class| Self::new(strata, (held, &strata.regions()[index]), class, view, max_edges);
            Self::classes_of_part(strata.regions().len(), view, max_edges, classes).into_iter().map(of_class)
        };
        let met = apart.then(|| Classes { lengths: false, ..classes }.all(max_edges, false)).into_iter().flatten();
        let met = met.map(|class| Self::new(strata, (Held::Met, strata.whole()), class, view, max_edges));
        (0..strata.regions().len()).flat_map(of_part).chain(met).collect()
    }

    /// The classes that each of so many parts of the lights is cut into.
    pub(super) fn classes_of_part(parts: usize, view: View, max_edges: usize, classes: Classes) -> Vec<PathClass> {
        // Images of lights are met by chance.
        classes.all(max_edges, view.scene.needs().specular && parts == 1)
    }

    /// The paths of some kinds in each of the lights' parts; after them, what is met by chance.
    pub(crate) fn of_kinds(strata: &'a LightStrata, kinds: Kinds, view: View<'a>, max_edges: usize) -> Vec<Self> {
        let apart = view.scene.needs().met_by_chance;
        let held = |index| if apart { Held::Connected(index) } else { Held::Part(index) };
        let parts = (0..).zip(strata.regions()).map(|(index, region)| (held(index), region));
        let met = apart.then_some((Held::Met, strata.whole()));
        let of_part = |part| Self::new(strata, part, PathClass::of_kinds(kinds), view, max_edges);
        parts.chain(met).map(of_part).collect()
    }

    fn new(
        strata: &'a LightStrata,
        (held, region): (Held, &'a LightRegion),
        class: PathClass,
        view: View<'a>,
        max_edges: usize,
    ) -> Self {
        let sampler = Bidirectional { view, region, max_edges: class.kinds.most_edges(max_edges) };
        let everything = strata.regions().len() == 1 && class == PathClass::of_kinds(Kinds::ALL);
        Self { strata, held, class, everything, sampler, guide: None }
    }

    /// All paths in one stratum whose chains change the light end within the parts of `strata`. `whole`: all lights.
    pub(crate) fn mutation_only(
        strata: &'a LightStrata,
        whole: &'a LightRegion,
        view: View<'a>,
        max_edges: usize,
    ) -> Self {
        let class = PathClass::of_kinds(Kinds::ALL);
        let sampler = Bidirectional { view, region: whole, max_edges };
        Self { strata, held: Held::All, class, everything: true, sampler, guide: None }
    }

    /// Where x_0 is drawn.
    #[cfg(test)]
    pub(crate) fn region(&self) -> &'a LightRegion {
        self.sampler.region
    }

    /// Where the light end of a path that starts at `point` is drawn again.
    pub(crate) fn region_at(&self, point: &LightPoint) -> &'a LightRegion {
        match self.held {
            Held::All => &self.strata.regions()[self.strata.index(point) as usize],
            _ => self.sampler.region,
        }
    }

    /// Whether [`region_at`](Self::region_at) is the same for both points, for points of this stratum.
    #[inline]
    pub(crate) fn same_region(&self, a: &LightPoint, b: &LightPoint) -> bool {
        self.held != Held::All || self.strata.index(a) == self.strata.index(b)
    }

    /// Scene and camera.
    pub(crate) fn view(&self) -> &View<'a> {
        &self.sampler.view
    }

    /// A uniform point of the stratum's part of the image, where the camera's end of a path is drawn again.
    #[inline]
    pub(crate) fn image_point(&self, rng: &mut impl Rng) -> Vec2 {
        point_between(self.image_corners(), Vec2::new(uniform_f32(rng), uniform_f32(rng)))
    }

    /// The corners of that part with the smallest and the largest coordinates.
    #[inline]
    pub(crate) fn image_corners(&self) -> [Vec2; 2] {
        [self.class.low, self.class.high]
    }

    /// Area of that part, of an image of 1.
    #[inline]
    pub(crate) fn image_area(&self) -> f64 {
        self.class.area()
    }

    /// Whether it holds what is met by chance, and nothing else.
    pub(crate) fn is_met(&self) -> bool {
        self.held == Held::Met
    }

    fn by_chance(&self) -> ByChance<'a> {
        ByChance { sampler: self.sampler, guide: self.guide }
    }

    /// Most edges of a path.
    pub(crate) fn max_edges(&self) -> usize {
        self.sampler.max_edges
    }
}

impl Stratum<LightPath> for LightStratum<'_> {
    #[inline]
    fn contains(&self, path: &LightPath) -> bool {
        let met = || met_by_chance(path.vertices());
        let held = || match self.held {
            Held::All => true,
            Held::Part(index) => index == self.strata.index(path.light()),
            Held::Connected(index) => index == self.strata.index(path.light()) && !met(),
            Held::Met => met(),
        };
        self.everything || held() && self.class.contains(path)
    }

    /// The camera subpath passes the class's part of the image, which makes its density that of a uniform point over the
    /// part's area; a light subpath that is connected to the camera itself may cross the image anywhere.
    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        let (film, area) = (self.image_point(rng), self.image_area());
        let mut show = |path: &LightPath, weight: f64| {
            if self.contains(path) {
                visit(path, weight);
            }
        };
        match self.held {
            Held::Met => self.by_chance().sample(film, area, rng, &mut show),
            _ => self.sampler.sample_through(film, area, rng, &mut show),
        }
    }

    fn density(&self, path: &LightPath) -> f64 {
        let Bidirectional { view, region, .. } = &self.sampler;
        let ends = Ends::new(path, view, region, self.image_area());
        let density: f64 = mis::densities(path.vertices(), ends).sum();
        if self.is_met() { density * self.by_chance().relative_density(path, self.image_area()) } else { density }
    }

    /// The stratum of what is met by chance counts as much as an average part of the lights.
    fn power(&self) -> f64 {
        let parts = if self.is_met() { self.strata.regions().len() } else { 1 };
        self.sampler.region.power() / parts as f64 * self.image_area()
    }
}

/// The point of a rectangle between two corners at a place in [0, 1)². Rounding would put a few on the far sides, which belong to the next rectangle.
fn point_between([low, high]: [Vec2; 2], place: Vec2) -> Vec2 {
    let last = Vec2::new(high.x.next_down(), high.y.next_down());
    (low + (high - low) * place).min(last)
}

/// Strata whose samples of what is met by chance follow a guide.
pub(crate) fn guided<'a>(strata: Vec<LightStratum<'a>>, guide: &'a Guide) -> Vec<LightStratum<'a>> {
    strata.into_iter().map(|stratum| LightStratum { guide: Some(guide), ..stratum }).collect()
}

/// Shares in which what is met by chance has as many samples as all other strata: as many as it would have if nothing were cut.
pub(super) fn with_met(strata: &[LightStratum], mut shares: Vec<Share>) -> Vec<Share> {
    let met = strata.iter().filter(|stratum| stratum.is_met()).count() as u64;
    let others = |(stratum, share): (&LightStratum, &Share)| if stratum.is_met() { 0 } else { share.samples };
    let samples = strata.iter().zip(&shares).map(others).sum::<u64>();
    for (_, share) in strata.iter().zip(&mut shares).filter(|(stratum, _)| stratum.is_met()) {
        share.samples = share.samples.max(samples / met);
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator};
    use crate::transport::lights::Stratification;
    use crate::transport::tests::worlds::{lamps, mirror, room, rough_metal};

    /// E[Σ 1] over the states that a sample shows, and by their weights and the density that a stratum tells, E[Σ w/p · q]:
    /// z of their difference. Paths of three edges are too short for roulette.
    fn z(drawn: &LightStratum, told: &LightStratum) -> f64 {
        let n = 40_000;
        let difference = |i: u64| {
            let mut difference = 0.0;
            drawn.sample(&mut generator(7, Purpose::Sample, 0, 0, i), &mut |path, weight| {
                difference += weight * told.density(path) - 1.0;
            });
            difference
        };
        let (sum, squares) = (0..n).map(difference).fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        let mean = sum / n as f64;
        mean / ((squares / n as f64 - mean * mean) / n as f64).sqrt()
    }

    #[test]
    fn a_sample_shows_states_as_often_as_their_density_says() {
        for world in [room(rough_metal(), false), lamps()] {
            let view = world.view();
            let lights = |stratification| LightStrata::new(view.scene.lights(), stratification);
            let (whole, halves) = (lights(Stratification::None), lights(Stratification::Grid(2, 1)));
            let [whole, halves] = [&whole, &halves].map(|strata| LightStratum::all(strata, view, 3));
            for stratum in [&whole[0], &halves[0]] {
                let found = z(stratum, stratum);
                assert!(found.abs() < 4.0, "{found}");
            }
            // The negative control: the density of samples on twice as large a part of the lights.
            let wrong = z(&halves[0], &whole[0]);
            assert!(wrong.abs() > 4.0, "{wrong}");
        }
    }

    #[test]
    fn a_part_of_the_image_holds_its_points() {
        let largest = 1.0 - f32::EPSILON / 2.0;
        for parts in 1..9 {
            for part in 0..parts {
                let [low, high] = [part, part + 1].map(|side| side as f32 / parts as f32);
                let corners = [Vec2::new(low, 0.0), Vec2::new(high, 1.0)];
                for x in [0.0, 0.5, largest].map(|place| point_between(corners, Vec2::splat(place))) {
                    assert!(x.cmpge(corners[0]).all() && x.cmplt(corners[1]).all(), "{x} of {corners:?}");
                }
            }
        }
        // The control: by the formula alone, the largest number lies beyond.
        assert!(0.5 + 0.5 * largest >= 1.0);
    }

    /// With one part of the lights, images of lights are a class; with more, all that is met by chance is apart.
    #[test]
    fn parts_are_cut_into_as_many_classes_as_a_pilot_counts() {
        let world = room(mirror(), true);
        let (view, classes) = (world.view(), Classes { lengths: true, tiles: [2, 1] });
        for (cut, met, each) in [(Stratification::Grid(1, 1), 0, 8), (Stratification::Grid(2, 1), 2, 6)] {
            let strata = LightStrata::new(view.scene.lights(), cut);
            let parts = strata.regions().len();
            let counted = LightStratum::classes_of_part(parts, view, 9, classes).len();
            assert_eq!((counted, LightStratum::product(&strata, view, 9, classes).len()), (each, parts * each + met));
        }
    }
}
