//! How each path is shared out between independent samples and chains: by what it is worth to the samples.

use super::constants::HALF_OF_LEVEL;
use super::levels::Levels;
use crate::engine::Importance;
use crate::transport::colour::LUMINANCE;
use crate::transport::image::PixelImportance;
use crate::transport::lights::LightRegion;
use crate::transport::methods::independent::Selection;
use crate::transport::methods::path_tracing::survival;
use crate::transport::paths::mis::{self, Ends, square};
use crate::transport::paths::{Kind, Kinds, LightPath, Luminance, PathEnd};
use crate::transport::scene::View;
use glam::DVec3;

/// Lamps in view: camera rays meet them as often as they are large, so chains get nothing of them.
pub(super) const IN_VIEW: Kinds = Kinds::SEEN.without(Kind::IMAGE);

/// W(x) = u⁴/(u⁴ + c⁴), the share of path x that is left to chains, where
///
/// u(x) = I(x) / (R(x) √(p_0² + p_1²))
///
/// is what path tracing makes of x: p_0 and p_1 are the densities with which it meets x_0 or draws it, and R is the probability that roulette
/// lets a walk come to x_1. c is in proportion to the [level](Levels) of the pixel.
#[derive(Clone, Debug)]
pub(super) struct Split {
    /// c of each level; `places` says which level a pixel has.
    half: Vec<f32>,
    places: [Vec<u32>; 2],
    /// Most edges of a path that samples make; all of what is longer is left to chains.
    max_edges: usize,
}

impl Split {
    /// For an image of this size.
    pub(super) fn new(levels: &Levels, size: [u32; 2], max_edges: usize) -> Self {
        let half = levels.values().iter().map(|level| (HALF_OF_LEVEL * level) as f32).collect();
        Self { half, places: levels.places(size), max_edges }
    }

    /// W where u is the `value` and the path crosses the image at a pixel.
    #[inline]
    pub(super) fn share(&self, value: f64, pixel: u32) -> f64 {
        let ratio = square(square(value / f64::from(self.half_at(pixel))));
        1.0 - 1.0 / (1.0 + ratio)
    }

    /// c of a pixel.
    #[inline]
    fn half_at(&self, pixel: u32) -> f32 {
        let [columns, rows] = &self.places;
        let width = columns.len() as u32;
        self.half[(columns[(pixel % width) as usize] + rows[(pixel / width) as usize]) as usize]
    }

    /// u.
    pub(super) fn value(&self, path: &LightPath, view: &View, lights: &LightRegion) -> f64 {
        if path.edges() > self.max_edges {
            return f64::INFINITY;
        }
        let (x, ends) = (path.vertices(), Ends::new(path, view, lights, 1.0));
        let met = if x[0].vertex.can_be_met() { mis::density(x, 0, ends) } else { 0.0 };
        let drawn = if x[1].vertex.delta { 0.0 } else { mis::density(x, 1, ends) };
        Luminance.eval(path) / (met.hypot(drawn) * survival(path, view))
    }
}

/// Independent samples' share of each path, 1 − W.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest<'a>(pub(super) &'a Split);

impl Selection for Rest<'_> {
    #[inline]
    fn part(&self, value: DVec3, pixel: u32, end: &PathEnd) -> DVec3 {
        // Where a technique's weight is too small for f32, nothing is left of the value, and `scale` is infinite.
        if IN_VIEW.contains(end.kind) || value == DVec3::ZERO {
            return value;
        }
        let u = value.dot(DVec3::from_array(LUMINANCE)) * end.scale;
        value * (1.0 - self.0.share(u, pixel))
    }
}

/// I W, the importance of chains.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taken<'a> {
    pub(super) importance: &'a PixelImportance,
    pub(super) view: View<'a>,
    /// All lights.
    pub(super) lights: &'a LightRegion,
    pub(super) split: &'a Split,
}

impl Importance<LightPath> for Taken<'_> {
    fn eval(&self, path: &LightPath) -> f64 {
        let value = self.split.value(path, &self.view, self.lights);
        self.importance.eval(path) * self.split.share(value, path.pixel)
    }

    #[inline]
    fn divisor(&self, path: &LightPath, _: f64) -> f64 {
        self.importance.eval(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform_f32};
    use crate::transport::methods::MOST_EDGES;
    use crate::transport::methods::bidirectional::Bidirectional;
    use crate::transport::methods::independent::ImageSampler;
    use crate::transport::methods::path_tracing::PathTracer;
    use crate::transport::methods::sobol::OwenSobol;
    use crate::transport::paths::LightEnd;
    use crate::transport::scene::LightPoint;
    use crate::transport::tests::worlds::{World, worlds};
    use glam::Vec2;

    const SAMPLES: u64 = 32_000;

    /// Of an image of one pixel.
    fn even(half: f32, max_edges: usize) -> Split {
        Split { half: vec![half], places: [vec![0], vec![0]], max_edges }
    }

    /// Mean and standard error over samples.
    fn moments(sample: impl Fn(u64) -> f64) -> [f64; 2] {
        let n = SAMPLES as f64;
        let [sum, squares] = (0..SAMPLES).map(sample).fold([0.0; 2], |[s, q], x| [s + x, q + x * x]);
        let mean = sum / n;
        [mean, ((squares / n - mean * mean) / n).sqrt()]
    }

    /// The light that samples of path tracing leave to chains.
    fn left(world: &World, split: &Split, (branches, max_edges): (u32, usize)) -> [f64; 2] {
        let (view, lights) = (world.view(), &LightRegion::whole(world.scene.lights()));
        let light_sampler = lights.light_sampler();
        let tracer = PathTracer { view, light_sampler, max_edges, max_image_edges: max_edges, branches };
        moments(|i| {
            let (rng, mut sum) = (&mut OwenSobol::new(i), DVec3::ZERO);
            let film = Vec2::new(uniform_f32(rng), uniform_f32(rng));
            tracer.sample(film, rng, &mut |_, value, end| sum += value - Rest(split).part(value, 0, &end));
            sum.dot(DVec3::from_array(LUMINANCE))
        })
    }

    /// The light that chains take of what path tracing can make, `value` being u.
    fn taken(world: &World, split: &Split, max_edges: usize, value: &dyn Fn(&LightPath) -> f64) -> [f64; 2] {
        let (view, region) = (world.view(), &LightRegion::whole(world.scene.lights()));
        let sampler = Bidirectional { view, region, max_edges };
        moments(|i| {
            let (rng, mut sum) = (&mut generator(2, Purpose::Sample, 0, 0, i), 0.0);
            sampler.sample_paths(rng, &mut |path, weight| {
                let value = value(path);
                // What path tracing cannot make is not among what it leaves.
                if !IN_VIEW.contains(Kind::of(path)) && value.is_finite() {
                    sum += weight * Luminance.eval(path) * split.share(value, 0);
                }
            });
            sum
        })
    }

    fn z([a, a_error]: [f64; 2], [b, b_error]: [f64; 2]) -> f64 {
        (a - b) / a_error.hypot(b_error).max(1e-12)
    }

    /// Both sides tell the same share of a path: what one leaves is what the other takes.
    #[test]
    fn what_samples_leave_is_what_chains_take() {
        let (mut right, mut by_power, mut certain, worlds) = (0.0, 0.0_f64, 0.0, worlds());
        for (name, world) in &worlds {
            let (view, lights) = (world.view(), &LightRegion::whole(world.scene.lights()));
            let split = even(0.03, MOST_EDGES);
            let value = |path: &LightPath| split.value(path, &view, lights);
            let found = taken(world, &split, MOST_EDGES, &value);
            let [one, four] = [1, 4].map(|branches| left(world, &split, (branches, MOST_EDGES)));
            for left in [one, four] {
                assert!(z(left, found).abs() < 4.0, "{name}: {left:?} {found:?}");
            }
            // The negative controls: x_0 as if by power, and walks as if without roulette.
            let as_if_by_power = |path: &LightPath| {
                let (x, ends) = (path.vertices(), Ends::new(path, &view, lights, 1.0));
                let of = |ends| [0, 1].map(|s| if mis::connectible(x, s) { mis::density(x, s, ends) } else { 0.0 });
                let [right, wrong] = [ends, Ends { preference: 1.0, ..ends }].map(of);
                value(path) * right[0].hypot(right[1]) / wrong[0].hypot(wrong[1])
            };
            let as_if_certain = |path: &LightPath| value(path) * survival(path, &view);
            let of_control = |value: &dyn Fn(&LightPath) -> f64| z(one, taken(world, &split, MOST_EDGES, value));
            right += z(one, found);
            by_power = by_power.max(of_control(&as_if_by_power).abs());
            certain += of_control(&as_if_certain);
        }
        let all = (worlds.len() as f64).sqrt();
        assert!(
            (right / all).abs() < 4.0 && by_power > 5.0 && certain / all > 5.0,
            "{right} {by_power} {certain}, {all}"
        );
    }

    /// A technique whose weight is beyond f32 brings nothing, and nothing that is no number.
    #[test]
    fn nothing_is_left_of_nothing() {
        let split = even(0.03, MOST_EDGES);
        let light = LightPoint { light: 0, u: 0.5, v: 0.5 };
        let end = PathEnd { kind: Kind::new(3, false), light: LightEnd::Drawn(&light), scale: f64::INFINITY };
        assert_eq!(Rest(&split).part(DVec3::ZERO, 0, &end), DVec3::ZERO);
        assert_eq!(Rest(&split).part(DVec3::ONE, 0, &end), DVec3::ZERO);
    }

    /// Where samples make short paths only, all others are for chains.
    #[test]
    fn longer_paths_are_left_to_chains() {
        for (_, world) in worlds() {
            let lights = &LightRegion::whole(world.scene.lights());
            let split = even(f32::MAX, 2);
            let sampler = Bidirectional { view: world.view(), region: lights, max_edges: 3 };
            for i in 0..100 {
                sampler.sample_paths(&mut generator(2, Purpose::Sample, 0, 0, i), &mut |path, _| {
                    let share = split.share(split.value(path, &world.view(), lights), 0);
                    assert!(path.edges() <= 2 || share == 1.0);
                });
            }
        }
    }
}
