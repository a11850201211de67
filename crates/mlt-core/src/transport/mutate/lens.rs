//! The lens perturbation: move the path on the image, keep what lies behind its first diffuse surface.
//!
//! Paths of the form (L|D) D S* E or L S* E: the camera ray is moved by a distance with density ∝ 1/r² per area of the
//! image, the chain of specular surfaces is followed through the same events, and its end x_m is connected to
//! x_{m−1}. The move on the image is symmetric, so
//!
//! T(y→x) / T(x→y) = Π_{m ≤ i < k} r_i(x) / r_i(y),  r_i = reverse_i / P(event at x_{i+1}),
//!
//! r_i being the density of x_i when the image point is uniform and the events are given.
//!
//! Source: [VeachGuibas97], section 5.3.3.

use super::super::path::{LightPath, View};
use super::super::subpath::{follow_from_eye, start_at_eye};
use crate::engine::uniform_f32;
use glam::Vec2;
use rand_pcg::rand_core::Rng;
use std::f32::consts::{PI, TAU};

/// Smallest distance, pixels.
const LEAST_PIXELS: f32 = 0.1;
/// Area of the largest move, as a share of the image.
const LARGEST_SHARE: f32 = 0.05;

/// Moves the camera ray.
#[derive(Clone, Copy)]
pub struct LensPerturbation<'a> {
    /// Scene and camera.
    pub view: View<'a>,
}

impl LensPerturbation<'_> {
    /// 1 for paths of its form, else 0.
    pub fn suitability(&self, current: &LightPath) -> f64 {
        let m = first_diffuse(current);
        let connects = m == 0 || !current.vertices[m - 1].vertex.delta;
        if connects { 1.0 } else { 0.0 }
    }

    /// Writes a path over `proposal` and returns T(y→x)/T(x→y).
    pub fn propose(&self, current: &LightPath, proposal: &mut LightPath, rng: &mut impl Rng) -> Option<f64> {
        let image = self.perturb(current.image, rng)?;
        let m = first_diffuse(current);
        let last = current.edges();
        proposal.clone_from(current);
        start_at_eye(&mut proposal.vertices, last, image, &self.view)?;
        for i in (m + 1..last).rev() {
            self.follow_event(current, proposal, i)?;
        }
        if proposal.vertices[m].vertex.delta {
            return None;
        }
        let changed = m.saturating_sub(1)..=last;
        if m == 0 {
            let x = &proposal.vertices[0].vertex;
            proposal.light = self.view.scene.lights().point(x.primitive, x.position)?;
            proposal.update(&self.view, changed)?;
        } else {
            proposal.connect(&self.view, m, changed)?;
        }
        Some(self.density(current, m) / self.density(proposal, m))
    }

    /// Π_{m ≤ i < k} r_i.
    fn density(&self, path: &LightPath, m: usize) -> f64 {
        (m..path.edges()).map(|i| path.vertices[i].reverse / self.event_probability(path, i + 1)).product()
    }

    /// Follows, at the delta vertex x_i of `proposal`, the event that x_i of `current` has.
    fn follow_event(&self, current: &LightPath, proposal: &mut LightPath, i: usize) -> Option<()> {
        let (old, new) = (&current.vertices[i], &proposal.vertices[i]);
        if !new.vertex.delta {
            return None;
        }
        let n = old.vertex.shading_normal;
        let transmits = n.dot(old.to_eye) * n.dot(-current.vertices[i - 1].to_eye) < 0.0;
        let direction = self.view.scene.delta_direction(&new.vertex, new.to_eye, transmits)?;
        follow_from_eye(&mut proposal.vertices, i, direction, &self.view)
    }

    /// Probability with which the event at x_i is drawn; 1 at the camera.
    fn event_probability(&self, path: &LightPath, i: usize) -> f64 {
        let x = &path.vertices[i];
        if x.vertex.is_camera() {
            return 1.0;
        }
        f64::from(self.view.scene.event_probability(&x.vertex, x.to_eye, -path.vertices[i - 1].to_eye))
    }

    /// A point of the image at distance r₂ exp(−u ln(r₂/r₁)) in a uniform direction; `None` outside the image.
    fn perturb(&self, image: Vec2, rng: &mut impl Rng) -> Option<Vec2> {
        let [w, h] = self.view.camera.size().map(|n| n as f32);
        let largest = (LARGEST_SHARE * w * h / PI).sqrt().max(2.0 * LEAST_PIXELS);
        let distance = largest * (-(largest / LEAST_PIXELS).ln() * uniform_f32(rng)).exp();
        let (sin, cos) = (TAU * uniform_f32(rng)).sin_cos();
        let moved = image + distance * Vec2::new(cos / w, sin / h);
        (moved.cmpge(Vec2::ZERO).all() && moved.cmplt(Vec2::ONE).all()).then_some(moved)
    }
}

/// Index of the first vertex from the camera that is not a delta one; 0 at the latest.
fn first_diffuse(path: &LightPath) -> usize {
    let mut m = path.edges() - 1;
    while m > 0 && path.vertices[m].vertex.delta {
        m -= 1;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::super::super::strata::Stratification;
    use super::super::super::testing::{World, glass, glossy, lambert, mirror, pond, room, two_lights};
    use super::super::super::tests::balance::imbalance;
    use super::*;
    use crate::transport::Rgb;

    /// Moves of paths of the form that the perturbation applies to.
    fn suited<'a>(world: &'a World, x: &LightPath) -> Option<LensPerturbation<'a>> {
        let lens = LensPerturbation { view: world.view() };
        (lens.suitability(x) > 0.0).then_some(lens)
    }

    #[test]
    fn flows_are_balanced() {
        for (name, world) in [
            ("diffuse", room(lambert(Rgb::splat(0.5)), true)),
            ("mirror", room(mirror(), true)),
            ("coated", room(glossy(), true)),
            ("glass", room(glass(0.0), false)),
            ("water", pond()),
            ("two lights", two_lights(glass(0.0), mirror())),
        ] {
            let found = imbalance(&world, Stratification::Grid(2, 1), 15_000, |x, y, _, rng| {
                suited(&world, x)?.propose(x, y, rng)
            });
            println!("{name}: z = {:.2}", found.z);
            found.assert_balanced(name);
        }
    }

    #[test]
    fn errors_in_the_ratio_are_seen() {
        let world = pond();
        let with_ratio = |ratio: &(dyn Fn(&LensPerturbation, &LightPath, &LightPath) -> f64 + Sync)| {
            imbalance(&world, Stratification::None, 60_000, |x, y, _, rng| {
                let lens = suited(&world, x)?;
                lens.propose(x, y, rng)?;
                Some(ratio(&lens, x, y))
            })
        };
        let right = |lens: &LensPerturbation, x: &LightPath, y: &LightPath| {
            lens.density(x, first_diffuse(x)) / lens.density(y, first_diffuse(y))
        };
        with_ratio(&right).assert_balanced("none");
        let found = with_ratio(&|_, _, _| 1.0);
        println!("z = {:.2}", found.z);
        found.assert_detected("without the densities");
        let found = with_ratio(&|lens, x, y| {
            let event = |path| -> f64 {
                (first_diffuse(path) + 1..path.edges()).map(|i| lens.event_probability(path, i)).product()
            };
            right(lens, x, y) * event(x) / event(y)
        });
        println!("z = {:.2}", found.z);
        found.assert_detected("without the probabilities of events");
    }
}
