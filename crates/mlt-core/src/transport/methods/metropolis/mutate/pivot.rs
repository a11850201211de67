//! The pivot perturbation: the multi-chain perturbation with each edge behind a diffuse vertex turned about a point on it.
//!
//! Light that comes through a narrow gap is lost by the lens perturbation, which keeps the far end of the edge through the gap, and by
//! the multi-chain perturbation, which keeps its direction. Here a point of the edge is kept, and that may lie in the gap. With x_i diffuse
//! and replaced by y_i,
//!
//! α ~ U(0, 1),   p = x_i + α (x_{i−1} − x_i),   y_{i−1}: first hit of the ray y_i → p, which has to lie beyond p.
//!
//! Given x_i, (x_{i−1}, α) ↔ p is one to one, dp = α² L cosθ dA dα with L = |x_{i−1} − x_i| and θ at x_{i−1}; p is kept, and from y it is
//! drawn by α′ = |p − y_i| / |y_{i−1} − y_i|. So x_{i−1} has the density
//!
//! q_{i−1} = α² L cosθ = |p − x_i|² L · cosθ / L²,
//!
//! that of a turn by an angle times |p − x_i|² L.

use super::event::is_followed;
use super::follow::{ByAngle, Turn};
use super::from_eye::{EyePerturbation, FromEye};
use super::multi_chain::{choose_end, goes_on};
use crate::engine::uniform_f32;
use crate::transport::paths::LightPath;
use crate::transport::paths::subpath::follow_from_eye;
use crate::transport::scene::View;
use rand_pcg::rand_core::Rng;

/// Moves the camera ray and turns the edges behind it about points on them.
pub type PivotPerturbation<'a> = EyePerturbation<'a, Pivot>;

/// Turns edges about points on them.
#[derive(Clone, Copy, Debug)]
pub struct Pivot;

impl FromEye for Pivot {
    const NAME: &'static str = "pivot";
    /// A quarter of the lens perturbation's.
    const SUITABILITY: f64 = 1.0;
    type Turn = Self;

    fn applies(view: &View, current: &LightPath) -> bool {
        goes_on(view, current)
    }

    fn draw_end(view: &View, current: &LightPath, rng: &mut impl Rng) -> usize {
        choose_end(view, current, rng)
    }
}

impl Turn for Pivot {
    fn follow(view: &View, current: &LightPath, proposal: &mut LightPath, i: usize, rng: &mut impl Rng) -> Option<f64> {
        if is_followed(view, current, i) {
            return ByAngle::follow(view, current, proposal, i, rng);
        }
        let volume = |edge: PivotedEdge| edge.to_pivot.powi(2) * edge.length;
        follow_through_pivot(view, current, proposal, i, rng).map(|[x, y]| volume(x) / volume(y))
    }
}

/// Lengths on an edge from x_i.
#[derive(Clone, Copy)]
struct PivotedEdge {
    /// |p − x_i|.
    to_pivot: f64,
    /// |x_{i−1} − x_i|.
    length: f64,
}

/// Replaces x_{i−1} by what is met from y_i through a point drawn on the edge x_i x_{i−1}; the edges of both paths.
fn follow_through_pivot(
    view: &View,
    current: &LightPath,
    proposal: &mut LightPath,
    i: usize,
    rng: &mut impl Rng,
) -> Option<[PivotedEdge; 2]> {
    let [far, near] = [i - 1, i].map(|i| &current.vertices[i].vertex);
    if far.is_distant() || proposal.vertices[i].vertex.delta {
        return None;
    }
    let pivot = near.position + uniform_f32(rng) * (far.position - near.position);
    let to_pivot = pivot - proposal.vertices[i].vertex.position;
    follow_from_eye(&mut proposal.vertices, i, to_pivot.try_normalize()?, view, rng)?;
    let edge = |path: &LightPath| {
        let [far, near] = [i - 1, i].map(|i| path.vertices[i].vertex.position);
        PivotedEdge { to_pivot: near.distance(pivot).into(), length: near.distance(far).into() }
    };
    let met = edge(proposal);
    let beyond = !proposal.vertices[i - 1].vertex.is_distant() && met.to_pivot < met.length;
    beyond.then(|| [edge(current), met])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Generator;
    use crate::transport::colour::Rgb;
    use crate::transport::lights::Stratification;
    use crate::transport::methods::metropolis::stratum::LightStratum;
    use crate::transport::tests::balance::imbalance;
    use crate::transport::tests::worlds::{World, door, glass, glossy, lambert, mirror, room, two_lights};

    /// A turn about a pivot with another density, relative to that of a turn by an angle.
    trait Density {
        fn of(edge: PivotedEdge, cosine: f64) -> f64;
    }

    struct Wrong<D>(D);

    impl<D: Density> Turn for Wrong<D> {
        fn follow(
            view: &View,
            current: &LightPath,
            proposal: &mut LightPath,
            i: usize,
            rng: &mut impl Rng,
        ) -> Option<f64> {
            if is_followed(view, current, i) {
                return ByAngle::follow(view, current, proposal, i, rng);
            }
            let [x, y] = follow_through_pivot(view, current, proposal, i, rng)?;
            let cosine =
                |path: &LightPath, edge: PivotedEdge| path.vertices[i - 1].per_area_here(1.0) * edge.length.powi(2);
            Some(D::of(x, cosine(current, x)) / D::of(y, cosine(proposal, y)))
        }
    }

    /// L cosθ without α².
    struct WithoutShare;

    impl Density for WithoutShare {
        fn of(edge: PivotedEdge, _: f64) -> f64 {
            edge.length.powi(3)
        }
    }

    /// α² without L cosθ.
    struct WithoutLength;

    impl Density for WithoutLength {
        fn of(edge: PivotedEdge, cosine: f64) -> f64 {
            edge.to_pivot.powi(2) / cosine
        }
    }

    fn propose<T: Turn>(
        world: &World,
        x: &LightPath,
        y: &mut LightPath,
        within: &LightStratum,
        rng: &mut Generator,
    ) -> Option<f64> {
        let pivot = PivotPerturbation::new(world.view());
        let view = &world.view();
        Pivot::applies(view, x).then(|| pivot.perturb::<T>(x, y, choose_end(view, x, rng), within, rng))?
    }

    #[test]
    fn flows_are_balanced() {
        for (name, world) in [
            ("door", door()),
            ("diffuse", room(lambert(Rgb::splat(0.5)), true)),
            ("mirror", room(mirror(), true)),
            ("coated", room(glossy(), true)),
            ("two lights", two_lights(glass(0.0), mirror())),
        ] {
            let found = imbalance(&world, Stratification::Grid(2, 1), 40_000, |x, y, within, rng| {
                propose::<Pivot>(&world, x, y, within, rng)
            });
            found.assert_balanced(name);
        }
    }

    #[test]
    fn a_density_without_a_factor_is_seen() {
        for (name, world, batches) in
            [("door", door(), 200_000), ("room", room(lambert(Rgb::splat(0.5)), true), 300_000)]
        {
            let found = imbalance(&world, Stratification::None, batches, |x, y, within, rng| {
                propose::<Wrong<WithoutShare>>(&world, x, y, within, rng)
            });
            found.assert_detected(&format!("{name} without α²"));
            let found = imbalance(&world, Stratification::None, batches, |x, y, within, rng| {
                propose::<Wrong<WithoutLength>>(&world, x, y, within, rng)
            });
            found.assert_detected(&format!("{name} without L cosθ"));
        }
    }
}
