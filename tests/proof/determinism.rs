//! The same bits, whoever computes them.

use crate::support::*;
use mlt_core::engine::{Film, Outcome, Pixel};
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::lights::Stratification::{Grid, None as Whole};
use mlt_core::transport::render::{Counts, Method, Renderer, Settings};
use mlt_core::transport::scene::View;
use rayon::ThreadPoolBuilder;
use std::ops::{ControlFlow, Range};

const SIZE: [u32; 2] = [48, 40];

fn render(world: &World, settings: &Settings, threads: usize, rounds: Range<u64>) -> (Film<3>, Counts) {
    let camera = world.camera(SIZE);
    let renderer = Renderer::new(View { scene: &world.scene, camera: &camera }, settings.clone());
    let mut sums = renderer.sums();
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let outcome = pool.install(|| renderer.render(rounds, &mut sums, &mut |_, _| ControlFlow::Continue(())));
    assert_eq!(outcome, Outcome::Complete);
    sums.into_parts()
}

/// All means and standard errors, bit by bit.
fn bits(film: &Film<3>) -> Vec<u64> {
    let of = |p: Pixel| [p.mean.to_bits(), p.stderr.to_bits()];
    (0..film.sites() as usize).flat_map(|i| film.pixel(i)).flat_map(of).collect()
}

fn cases() -> [(Method, Stratification, f64); 7] {
    [
        (Method::Path, Whole, 4.0),
        (Method::Bidirectional, Whole, 2.0),
        (Method::Metropolis, Whole, 20.0),
        (Method::Metropolis, Grid(2, 2), 20.0),
        (Method::Metropolis, Grid(5, 3), 20.0),
        (Method::PrimaryBidirectional, Grid(2, 2), 4.0),
        (Method::Multiplexed, Grid(2, 2), 10.0),
    ]
}

#[test]
fn threads_change_no_bit() {
    let world = World::builtin("ring");
    for (method, cut, budget) in cases() {
        let settings = settings(method, cut, budget);
        let (one, counts) = render(&world, &settings, 1, 0..3);
        assert!(bits(&one).iter().any(|&b| b != 0));
        for threads in [2, 3, 8, 32] {
            let (film, others) = render(&world, &settings, threads, 0..3);
            assert_eq!(bits(&film), bits(&one), "{method:?} {cut:?}, {threads} threads");
            assert_eq!(others, counts, "{method:?} {cut:?}, {threads} threads");
        }
        let another = settings.with(|s| s.seed = 2);
        assert_ne!(bits(&render(&world, &another, 2, 0..3).0), bits(&one), "{method:?} {cut:?}, another seed");
    }
}

#[test]
fn one_stratum_is_no_stratification() {
    let world = World::builtin("cornell");
    assert_eq!(world.scene.lights().lights.len(), 1);
    let [whole, grid] =
        [Whole, Grid(1, 1)].map(|cut| render(&world, &settings(Method::Metropolis, cut, 20.0), 2, 0..3));
    assert_eq!(bits(&whole.0), bits(&grid.0));
    assert_eq!(whole.1, grid.1);
    let (other, _) = render(&world, &settings(Method::Metropolis, Grid(2, 1), 20.0), 2, 0..3);
    assert_ne!(bits(&whole.0), bits(&other));
}

#[test]
fn rounds_may_be_made_in_several_runs() {
    let world = World::builtin("cornell");
    for (method, cut, budget) in cases() {
        let settings = settings(method, cut, budget);
        let (whole, _) = render(&world, &settings, 2, 0..5);
        let (first, _) = render(&world, &settings, 3, 0..2);
        let (mut rest, _) = render(&world, &settings, 1, 2..5);
        assert_eq!(rest.merge(&first), Ok(()));
        assert_eq!(bits(&rest), bits(&whole), "{method:?} {cut:?}");
        assert_eq!(rest.rounds(), 5);
    }
}
