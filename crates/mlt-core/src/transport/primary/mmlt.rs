//! Multiplexed primary sample space: a state is one path, and its length and technique are numbers like all others.
//!
//! Every chain visits every length and every technique: no length depends on having been met by the bootstrap.
//!
//! Source: [HachisukaKaplanyanDachsbacher14]; there, each chain keeps the length that it started with.

use super::super::mis;
use super::super::path::{LightPath, PathVertex, set_scattering};
use super::super::subpath::{start_at_light, step_from_eye, step_from_light};
use super::Part;
use crate::engine::{Importance, Splat, uniform, uniform_f32};
use crate::primary::{Output, Stream, Streams, Tracer};

/// Numbers of length and technique, of the light's subpath, of the camera's.
const STREAMS: usize = 3;

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

impl Technique {
    /// From two uniform numbers in [0, 1): P(K ≥ k) = (c/(k − 1 + c))² up to `max_edges`, then 1/(k + 1) for each s.
    ///
    /// The tail is a power of k: where light decays with the number of edges as it does in every scene that absorbs, what
    /// divides by P(k) stays bounded.
    #[inline]
    pub fn new(u: f64, v: f64, max_edges: usize) -> Self {
        let beyond = tail(max_edges + 1);
        let edges = (LENGTH_SCALE * (1.0 / (1.0 - u * (1.0 - beyond)).sqrt() - 1.0)) as usize + 1;
        let edges = edges.clamp(1, max_edges);
        let light_vertices = ((v * (edges + 1) as f64) as usize).min(edges);
        let of_length = (tail(edges) - tail(edges + 1)) / (1.0 - beyond);
        Self { edges, light_vertices, probability: of_length / (edges + 1) as f64 }
    }
}

/// P(K ≥ k) without a limit.
#[inline]
fn tail(k: usize) -> f64 {
    let root = LENGTH_SCALE / ((k - 1) as f64 + LENGTH_SCALE);
    root * root
}

/// F(u) = w_s f / (p_s P(k) P(s | k)) of one path of k edges, made with s vertices from the light.
#[derive(Clone, Copy)]
pub struct Multiplexed<'a, I> {
    /// Where.
    pub part: Part<'a, I>,
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

    fn trace(&self, [choice, light, eye]: &mut Streams<STREAMS>, output: &mut Weighted) -> bool {
        let technique = Technique::new(uniform(choice), f64::from(uniform_f32(choice)), self.part.max_edges);
        let Some(weight) = self.make(&technique, &mut output.path, light, eye) else {
            return false;
        };
        output.weight = weight / technique.probability;
        output.importance = output.weight * self.part.importance.eval(&output.path);
        output.importance != 0.0
    }
}

impl<I> Multiplexed<'_, I> {
    /// Makes a path in place; returns w_s/p_s, `None` where its contribution is zero.
    fn make(&self, technique: &Technique, path: &mut LightPath, light: &mut Stream, eye: &mut Stream) -> Option<f64> {
        let Part { view, strata, index, .. } = self.part;
        let (s, last) = (technique.light_vertices, technique.edges);
        let power = strata.regions()[index as usize].power();
        let camera = PathVertex::new(view.camera.vertex());
        path.vertices.resize(last + 1, camera);
        path.vertices[last] = camera;
        self.trace_light(s, path, light)?;
        for i in (s + 1..=last).rev() {
            step_from_eye(&mut path.vertices, i, &view, eye)?;
            set_scattering(&mut path.vertices, i, &view)?;
        }
        if s == 0 {
            let x = &path.vertices[0].vertex;
            path.light = view.scene.lights().point(x.primitive, x.position)?;
            self.part.contains(path).then_some(())?;
            path.update(&view, 0..=0)?;
        } else {
            path.connect(&view, s, s - 1..=s)?;
        }
        Some(mis::weight(&path.vertices, s, power) / mis::density(&path.vertices, s, power))
    }

    /// The first s vertices; `None` where nothing can be connected to the last of them.
    fn trace_light(&self, s: usize, path: &mut LightPath, numbers: &mut Stream) -> Option<()> {
        let Part { view, strata, index, .. } = self.part;
        if s > 0 {
            let region = &strata.regions()[index as usize];
            (path.vertices[0], path.light) = start_at_light(&view, region, numbers);
        }
        for i in 1..s {
            step_from_light(&mut path.vertices, i - 1, &view, numbers)?;
            set_scattering(&mut path.vertices, i - 1, &view)?;
        }
        (s == 0 || !path.vertices[s - 1].vertex.delta).then_some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_techniques_follow_their_law() {
        for max_edges in [1, 2, 6, 40, 1000] {
            let mut counts = std::collections::BTreeMap::new();
            let n = 2000;
            for i in 0..n {
                for j in 0..50 {
                    let (u, v) = ((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / 50.0);
                    let t = Technique::new(u, v, max_edges);
                    assert!((1..=max_edges).contains(&t.edges) && t.light_vertices <= t.edges);
                    *counts.entry(t.edges).or_insert((0.0, 0.0)) =
                        (counts.get(&t.edges).map_or(0.0, |c: &(f64, f64)| c.0) + 1.0, t.probability);
                }
            }
            for (edges, (count, probability)) in counts {
                let of_length = probability * (edges + 1) as f64;
                assert!((count / f64::from(50 * n) - of_length).abs() <= 1.0 / f64::from(n), "{edges} of {max_edges}");
            }
        }
    }

    #[test]
    fn probabilities_of_all_techniques_sum_to_one() {
        for max_edges in [1, 2, 6, 1000] {
            let of = |k: usize| (tail(k) - tail(k + 1)) / (1.0 - tail(max_edges + 1));
            let sum: f64 = (1..=max_edges).map(of).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{max_edges}: {sum}");
        }
    }
}
