//! Primary sample space agrees with bidirectional path tracing, in any strata and however short its renders.

use crate::support::*;
use mlt_core::transport::lights::Stratification::{Grid, None as Whole};
use mlt_core::transport::render::Method;

const SIZE: [u32; 2] = [4, 4];
/// Mutations a pixel and replica, and a relative error that is seen with them.
const METHODS: [(Method, f64, f64); 2] =
    [(Method::PrimaryBidirectional, 600.0, 0.03), (Method::Multiplexed, 4000.0, 0.05)];

fn agrees(name: &str) {
    let world = World::builtin(name);
    let limited = |method, cut, per_pixel| settings(method, cut, per_pixel).with(|s| s.max_edges = Some(8));
    let reference = replicas(&world, SIZE, &limited(Method::Bidirectional, Whole, 1024.0), 100..116);
    for (method, mutations, error) in METHODS {
        for cut in [Whole, Grid(2, 2)] {
            let ours = replicas(&world, SIZE, &limited(method, cut, mutations), 0..32);
            println!("± {:.1e}, ours ± {:.1e}", reference.relative_error(), ours.relative_error());
            assert_same(ours.p_value(&reference), &format!("{name}, {method:?}, {cut:?}"));
            let wrong = ours.plus(error, &ours);
            assert_different(wrong.p_value(&reference), &format!("{name}, {method:?}, {cut:?}, {error} too bright"));
        }
    }
}

#[test]
fn cornell_agrees_with_bidirectional_path_tracing() {
    agrees("cornell");
}

#[test]
fn ring_agrees_with_bidirectional_path_tracing() {
    agrees("ring");
}

#[test]
fn suzanne_agrees_with_bidirectional_path_tracing() {
    agrees("suzanne");
}

#[test]
fn unlimited_paths_agree_with_path_tracing() {
    let world = World::builtin("cornell");
    let reference = replicas(&world, SIZE, &settings(Method::Path, Whole, 4096.0), 0..16);
    for (method, mutations, _) in METHODS {
        let ours = replicas(&world, SIZE, &settings(method, Whole, mutations), 0..32);
        assert_same(ours.p_value(&reference), &format!("{method:?}"));
    }
    let cut = settings(Method::Multiplexed, Whole, 4000.0).with(|s| s.max_edges = Some(6));
    assert_different(replicas(&world, SIZE, &cut, 0..32).p_value(&reference), "without the longer paths");
}

#[test]
fn the_mean_of_very_short_renders_is_the_long_render() {
    let world = World::builtin("cornell");
    let long = replicas(&world, SIZE, &settings(Method::Bidirectional, Whole, 4096.0), 0..16);
    for method in [Method::PrimaryBidirectional, Method::Multiplexed] {
        let short = replicas(&world, SIZE, &settings(method, Grid(2, 2), 2.0), 0..2000);
        println!("long ± {:.1e}, short ± {:.1e}", long.relative_error(), short.relative_error());
        assert_same(short.p_value(&long), &format!("{method:?}, short renders"));
        let wrong = short.plus(0.1, &short);
        assert_different(wrong.p_value(&long), &format!("{method:?}, short renders 10 % too bright"));
    }
}
