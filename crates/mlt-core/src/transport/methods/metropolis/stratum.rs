//! The strata of path space, as the engine sees them.

use crate::engine::{Stratum, uniform_f32};
use crate::transport::lights::{LightRegion, LightStrata};
use crate::transport::methods::bidirectional::Bidirectional;
use crate::transport::paths::{Classes, Kinds, LightPath, PathClass};
use crate::transport::scene::{LightPoint, View};
use glam::Vec2;
use rand_pcg::rand_core::Rng;

/// Ω_j: the paths of one class that start in part j of the lights; with [`Variant::MutationOnly`](super::Variant::MutationOnly) all of them.
///
/// Source: [Jankauski15], section 4.1.
#[derive(Clone, Copy)]
pub struct LightStratum<'a> {
    strata: &'a LightStrata,
    /// `None`: the stratum restricts no light.
    index: Option<u32>,
    class: PathClass,
    /// Whether Ω_j is all of path space, so that no path has to be looked at.
    everything: bool,
    sampler: Bidirectional<'a>,
}

impl<'a> LightStratum<'a> {
    /// All strata over the lights of a view, in the order of their parts.
    pub fn all(strata: &'a LightStrata, view: View<'a>, max_edges: usize) -> Vec<Self> {
        Self::product(strata, view, max_edges, Classes::default())
    }

    /// The products of the lights' parts and of classes.
    pub fn product(strata: &'a LightStrata, view: View<'a>, max_edges: usize, classes: Classes) -> Vec<Self> {
        let classes = classes.all(max_edges, view.scene.needs().specular);
        let parts = 0..strata.regions().len();
        let of = |index| classes.iter().map(move |&class| Self::new(strata, index, class, view, max_edges));
        parts.flat_map(of).collect()
    }

    /// The paths of some kinds in each of the lights' parts, where there are any kinds.
    pub fn of_kinds(strata: &'a LightStrata, kinds: &[Kinds], view: View<'a>, max_edges: usize) -> Vec<Self> {
        let lit = kinds.iter().enumerate().filter(|(_, kinds)| !kinds.is_empty());
        lit.map(|(index, &kinds)| Self::of_part(strata, index, kinds, view, max_edges)).collect()
    }

    /// The paths of some kinds in one of the lights' parts.
    pub fn of_part(strata: &'a LightStrata, index: usize, kinds: Kinds, view: View<'a>, max_edges: usize) -> Self {
        Self::new(strata, index, PathClass::of_kinds(kinds), view, max_edges)
    }

    fn new(strata: &'a LightStrata, index: usize, class: PathClass, view: View<'a>, max_edges: usize) -> Self {
        let region = &strata.regions()[index];
        let sampler = Bidirectional { view, region, max_edges: class.kinds.most_edges(max_edges) };
        let everything = strata.regions().len() == 1 && class == PathClass::of_kinds(Kinds::ALL);
        Self { strata, index: Some(index as u32), class, everything, sampler }
    }

    /// All paths in one stratum whose chains change the light end within the parts of `strata`. `whole`: all lights.
    pub fn mutation_only(strata: &'a LightStrata, whole: &'a LightRegion, view: View<'a>, max_edges: usize) -> Self {
        let class = PathClass::of_kinds(Kinds::ALL);
        let sampler = Bidirectional { view, region: whole, max_edges };
        Self { strata, index: None, class, everything: true, sampler }
    }

    /// Where x_0 is drawn.
    pub fn region(&self) -> &'a LightRegion {
        self.sampler.region
    }

    /// Where the light end of a path that starts at `point` is drawn again.
    pub fn region_at(&self, point: &LightPoint) -> &'a LightRegion {
        match self.index {
            Some(_) => self.sampler.region,
            None => &self.strata.regions()[self.strata.index(point) as usize],
        }
    }

    /// Whether [`region_at`](Self::region_at) is the same for both points, for points of this stratum.
    #[inline]
    pub fn same_region(&self, a: &LightPoint, b: &LightPoint) -> bool {
        self.index.is_some() || self.strata.index(a) == self.strata.index(b)
    }

    /// Scene and camera.
    pub fn view(&self) -> &View<'a> {
        &self.sampler.view
    }

    /// A uniform point of the stratum's part of the image, where the camera's end of a path is drawn again.
    #[inline]
    pub fn image_point(&self, rng: &mut impl Rng) -> Vec2 {
        let [low, high] = self.image_corners();
        low + (high - low) * Vec2::new(uniform_f32(rng), uniform_f32(rng))
    }

    /// The corners of that part with the smallest and the largest coordinates.
    #[inline]
    pub fn image_corners(&self) -> [Vec2; 2] {
        [self.class.low, self.class.high]
    }

    /// Area of that part, of an image of 1.
    #[inline]
    pub fn image_area(&self) -> f64 {
        self.class.area()
    }

    /// Most edges of a path.
    pub fn max_edges(&self) -> usize {
        self.sampler.max_edges
    }
}

impl Stratum<LightPath> for LightStratum<'_> {
    #[inline]
    fn contains(&self, path: &LightPath) -> bool {
        let on_lights = || self.index == Some(self.strata.index(path.light()));
        self.everything || on_lights() && self.class.contains(path)
    }

    /// The camera subpath passes the class's part of the image, which makes its density that of a uniform point over the
    /// part's area; a light subpath that is connected to the camera itself may cross the image anywhere.
    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&LightPath, f64)) {
        let (image, area) = (self.image_point(rng), self.image_area());
        self.sampler.sample_through(image, area, rng, &mut |path, weight| {
            if self.contains(path) {
                visit(path, weight);
            }
        });
    }

    fn power(&self) -> f64 {
        self.sampler.region.power() * self.image_area()
    }
}
