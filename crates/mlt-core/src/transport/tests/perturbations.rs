//! Balance of the perturbations, each alone.

use super::super::path::{LightPath, View};
use super::super::strata::Stratification;
use super::super::stratum::LightStratum;
use super::super::testing::{World, glass, glossy, lambert, mirror, pond, room, two_lights};
use super::balance::{Imbalance, imbalance};
use crate::engine::Mutation;
use crate::transport::Rgb;
use crate::transport::mutate::PathMutation;

/// The imbalance of the mutation of that name, its ratios wrong by the factor error(x)/error(y); `None`: not set up here.
fn imbalance_of(
    name: &str,
    world: &World,
    (cut, batches): (Stratification, u64),
    error: impl Fn(&View, &LightPath) -> f64 + Sync,
) -> Option<Imbalance> {
    let view = world.view();
    let named = |m: &PathMutation| Mutation::<LightPath, LightStratum>::name(m) == name;
    let mutation = PathMutation::all(view).into_iter().find(named)?;
    Some(imbalance(world, cut, batches, |x, y, within, rng| {
        if Mutation::<LightPath, LightStratum>::suitability(&mutation, x) == 0.0 {
            return None;
        }
        let ratio = mutation.propose(x, y, within, rng)?;
        Some(ratio * error(&view, x) / error(&view, y))
    }))
}

#[test]
fn flows_are_balanced() {
    let worlds = [
        ("diffuse", room(lambert(Rgb::splat(0.5)), true)),
        ("mirror", room(mirror(), true)),
        ("coated", room(glossy(), true)),
        ("glass", room(glass(0.0), false)),
        ("water", pond()),
        ("two lights", two_lights(glass(0.0), mirror())),
    ];
    for mutation in ["lens", "caustic", "multi-chain"] {
        let mut tested = 0;
        for (name, world) in &worlds {
            let found = imbalance_of(mutation, world, (Stratification::Grid(2, 1), 10_000), |_, _| 1.0);
            // Where a mutation hardly ever applies there is nothing to test.
            if let Some(found) = found.filter(|found| found.tests > 10) {
                println!("{mutation}, {name}: z = {:.2} of {}", found.z, found.tests);
                found.assert_balanced(&format!("{mutation}, {name}"));
                tested += 1;
            }
        }
        assert!(tested >= 3, "{mutation}: {tested}");
    }
}

/// Π P(event) over the specular vertices.
fn events(view: &View, path: &LightPath) -> f64 {
    let probability = |i: usize| {
        let x = &path.vertices[i];
        f64::from(view.scene.event_probability(&x.vertex, x.to_eye, -path.vertices[i - 1].to_eye))
    };
    (1..path.edges()).filter(|&i| path.vertices[i].vertex.delta).map(probability).product()
}

#[test]
fn errors_in_the_ratio_are_seen() {
    let (cut, world) = ((Stratification::None, 60_000), pond());
    let found = imbalance_of("lens", &world, cut, events).unwrap();
    println!("events: z = {:.2}", found.z);
    found.assert_detected("without the probabilities of events");
    let found = imbalance_of("lens", &world, cut, |_, path| path.vertices[path.edges() - 1].reverse).unwrap();
    println!("density: z = {:.2}", found.z);
    found.assert_detected("without the density on the first surface");
}
