//! Multiplexed primary sample space: a state is one path, and its length and technique are numbers like all others.
//!
//! Every chain visits every length and every technique: no length depends on having been met by the bootstrap.
//!
//! Source: [HachisukaKaplanyanDachsbacher14]; there, each chain keeps the length that it started with.

use super::{Part, PrimaryMetropolis, STREAMS, Tracers};
use crate::engine::{Importance, Splat, uniform, uniform_f32};
use crate::primary::{Output, Stream, Streams, Tracer};
use crate::transport::image::PixelImportance;
use crate::transport::methods::samples::Samples;
use crate::transport::paths::mis::Ends;
use crate::transport::paths::subpath::{
    light_numbers, start_at_eye, start_at_light, start_near, step_from_eye, step_from_light,
};
use crate::transport::paths::{LightPath, PathVertex, mis, set_scattering};
use glam::Vec2;

/// Scale of the law of lengths: P(K ≥ k) = (c/(k − 1 + c))².
const LENGTH_SCALE: f64 = 6.0;

/// How many edges a path has, and how many of its vertices come from the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Technique {
    /// k.
    pub edges: usize,
    /// s, 0 … k.
    pub light_vertices: usize,
    /// P(k) P(s | k).
    pub probability: f64,
}

/// The law of techniques: P(K ≥ k) = (c/(k − 1 + c))² as far as the longest length, then P(s | k) = 1/(k + 1).
///
/// The tail is a power of k: light decays exponentially with the number of edges in every scene that absorbs, so what is
/// divided by P(k) stays bounded.
#[derive(Clone, Debug)]
pub struct Techniques {
    /// P(K ≤ k) for k = 0, 1, 2 …
    cumulative: Vec<f64>,
}

impl Techniques {
    /// Lengths of 1 … `max_edges`.
    pub fn new(max_edges: usize) -> Self {
        let beyond = |k: usize| (LENGTH_SCALE / (k as f64 + LENGTH_SCALE)).powi(2);
        let all = 1.0 - beyond(max_edges);
        Self { cumulative: (0..=max_edges).map(|k| (1.0 - beyond(k)) / all).collect() }
    }

    /// From two uniform numbers in [0, 1).
    #[inline]
    pub fn choose(&self, u: f64, v: f64) -> Technique {
        // From the start: short lengths are the likely ones.
        let edges = self.cumulative[1..].iter().position(|&c| u < c).map_or(self.cumulative.len() - 1, |i| i + 1);
        let light_vertices = ((v * (edges + 1) as f64) as usize).min(edges);
        Technique { edges, light_vertices, probability: self.probability(edges) / (edges + 1) as f64 }
    }

    /// P(k).
    fn probability(&self, edges: usize) -> f64 {
        self.cumulative[edges] - self.cumulative[edges - 1]
    }
}

/// F(u) = q_j w_s f / (p_s P(k) P(s | k)) of one path of k edges, made with s vertices from the light.
#[derive(Clone, Copy, Debug)]
pub struct Multiplexed<'a, I> {
    /// Where.
    pub part: Part<'a, I>,
    /// How paths are made, up to the part's longest.
    pub techniques: &'a Techniques,
}

/// A path, and what f is multiplied by.
#[derive(Clone, Debug, Default)]
pub struct Weighted {
    path: LightPath,
    weight: f64,
    importance: f64,
}

impl Output for Weighted {
    type Splat = Splat<3>;

    #[inline]
    fn importance(&self) -> f64 {
        self.importance
    }

    fn splats(&self) -> impl Iterator<Item = Splat<3>> {
        let value = self.path.contribution * (f64::from(self.path.pixels) * self.weight);
        std::iter::once(Splat { site: self.path.pixel, value: value.to_array() })
    }
}

impl<I: Importance<LightPath>> Tracer<STREAMS> for Multiplexed<'_, I> {
    type Output = Weighted;

    fn trace(&self, [light, eye]: &mut Streams<STREAMS>, output: &mut Weighted) -> bool {
        let technique = self.techniques.choose(uniform(light), f64::from(uniform_f32(light)));
        let Some(weight) = self.make(&technique, &mut output.path, light, eye) else {
            return false;
        };
        output.weight = weight / technique.probability;
        output.importance = output.weight * self.part.importance.eval(&output.path);
        output.importance != 0.0
    }
}

impl<I> Multiplexed<'_, I> {
    /// Makes a path in place; returns q_j w_s/p_s, `None` where its contribution is zero.
    fn make(&self, technique: &Technique, path: &mut LightPath, light: &mut Stream, eye: &mut Stream) -> Option<f64> {
        let Part { view, strata, index, .. } = self.part;
        let region = &strata.regions()[index as usize];
        let (s, last) = (technique.light_vertices, technique.edges);
        let camera = PathVertex::new(view.camera.sample_lens(eye));
        path.vertices.resize(last + 1, camera);
        path.vertices[last] = camera;
        let first = if s > 0 { light_numbers(light) } else { [0.0; 2] };
        self.trace_light(s, path, first, light)?;
        for i in (s + 1..=last).rev() {
            if i == last {
                let film = Vec2::new(uniform_f32(eye), uniform_f32(eye));
                path.cross(&view, film);
                start_at_eye(&mut path.vertices, i, film, &view, eye)?;
            } else {
                step_from_eye(&mut path.vertices, i, &view, eye)?;
            }
            set_scattering(&mut path.vertices, i, &view)?;
        }
        let (mut near, mut share) = (None, 1.0);
        if s == 0 {
            let x = &path.vertices[0].vertex;
            path.light = view.scene.lights().point(x.primitive, x.position)?;
            share = self.part.share(path);
            (share > 0.0).then_some(())?;
            path.update(&view, 0..=0)?;
        } else {
            if s == 1 {
                let (x_0, point, preference) = start_near(&view, region, &path.vertices[1], first);
                (path.vertices[0], path.light, near) = (x_0, point, Some(preference));
            }
            path.connect(&view, s, s - 1..=s)?;
        }
        let ends = match near {
            Some(preference) => Ends { power: region.power(), preference, area: 1.0 },
            None => Ends::new(path, &view, region, 1.0),
        };
        Some(share * mis::weight(&path.vertices, s, ends) / mis::density(&path.vertices, s, ends))
    }

    /// The first s vertices, the very first from two numbers, unless it has to wait for the second; `None` where nothing can be
    /// connected to the last of them.
    fn trace_light(&self, s: usize, path: &mut LightPath, first: [f64; 2], numbers: &mut Stream) -> Option<()> {
        let Part { view, strata, index, .. } = self.part;
        if s < 2 {
            return Some(());
        }
        (path.vertices[0], path.light) = start_at_light(&view, &strata.regions()[index as usize], first);
        for i in 1..s {
            step_from_light(&mut path.vertices, i - 1, &view, numbers)?;
            set_scattering(&mut path.vertices, i - 1, &view)?;
        }
        (!path.vertices[s - 1].vertex.delta).then_some(())
    }
}

/// Probability of a large step times the image's side in pixels: a fresh path is seldom worth as much as a sample of all techniques, but
/// small steps are up to a 64th of the image, which on a small one is within the pixel.
const LARGE_STEPS: f64 = 25.0;

/// Single paths of all strata.
#[derive(Clone, Debug)]
pub(in crate::transport) struct Multiplexing {
    techniques: Techniques,
}

impl Tracers for Multiplexing {
    type Output = Weighted;
    type Of<'s> = Multiplexed<'s, PixelImportance>;

    const SAMPLES: Samples = Samples::MULTIPLEXED;

    fn new(max_edges: usize) -> Self {
        Self { techniques: Techniques::new(max_edges) }
    }

    fn of<'s>(&'s self, part: Part<'s, PixelImportance>) -> Self::Of<'s> {
        Multiplexed { part, techniques: &self.techniques }
    }

    fn large_steps(pixels: u32) -> f64 {
        (LARGE_STEPS / f64::from(pixels).sqrt()).clamp(0.1, 0.3)
    }
}

/// Stratified Metropolis over the random numbers of single paths.
pub(in crate::transport) type Mmlt<'a> = PrimaryMetropolis<'a, Multiplexing>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_technique_is_chosen_as_often_as_it_says() {
        for max_edges in [1, 2, 6] {
            let techniques = Techniques::new(max_edges);
            let mut counts = vec![vec![0.0; max_edges + 1]; max_edges + 1];
            let (n, m) = (1000, 840);
            for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
                let at = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
                let t = techniques.choose(at(i, n), at(j, m));
                counts[t.edges][t.light_vertices] += 1.0 / f64::from(n * m) / t.probability;
            }
            for (k, s) in (1..=max_edges).flat_map(|k| (0..=k).map(move |s| (k, s))) {
                assert!((counts[k][s] - 1.0).abs() < 0.02, "k = {k} of {max_edges}, s = {s}: {}", counts[k][s]);
            }
        }
    }

    #[test]
    fn lengths_sum_to_one_and_fall_off_as_a_power() {
        for max_edges in [1, 6, 1000] {
            let techniques = Techniques::new(max_edges);
            let sum: f64 = (1..=max_edges).map(|k| techniques.probability(k)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{max_edges}: {sum}");
        }
        let techniques = Techniques::new(1000);
        assert!(techniques.probability(100) > 0.1 * techniques.probability(50));
        assert_eq!(techniques.choose(1.0, 1.0).edges, 1000);
    }
}
