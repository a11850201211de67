//! Very short renders are right on average.

use crate::support::*;
use mlt_core::engine::{Chain, Deposits, Estimator, Importance, Mixture, Purpose, Stratum, generator, uniform};
use mlt_core::transport::lights::LightStrata;
use mlt_core::transport::lights::Stratification::{Grid, None as Whole};
use mlt_core::transport::methods::MOST_EDGES;
use mlt_core::transport::methods::metropolis::{LightStratum, PathMutation};
use mlt_core::transport::paths::{LightPath, Luminance};
use mlt_core::transport::render::{Method, film_unit};
use mlt_core::transport::scene::View;

const SIZE: [u32; 2] = [4, 4];
const CUT: mlt_core::transport::lights::Stratification = Grid(2, 2);
/// Mutations of a pixel: a few in each stratum.
const MUTATIONS: f64 = 4.0;
const RENDERS: u64 = 20_000;

#[test]
fn the_mean_of_short_renders_is_the_long_render() {
    let world = World::builtin("cornell");
    let long = replicas(&world, SIZE, &settings(Method::Bidirectional, Whole, 4096.0), 0..16);
    let short = metropolis(&world, SIZE, CUT, MUTATIONS, 0..RENDERS);
    println!("long ± {:.1e}, short ± {:.1e}", long.relative_error(), short.relative_error());
    assert_same(short.p_value(&long), "short renders");
    let wrong = biased(&world, 0..RENDERS);
    println!("wrong ± {:.1e}", wrong.relative_error());
    assert_different(wrong.p_value(&long), "starts that are not paired with their b");
}

/// The same renders with b̂ from a batch that the start is not from.
fn biased(world: &World, rounds: std::ops::Range<u64>) -> Replicas {
    let camera = world.camera(SIZE);
    let view = View { scene: &world.scene, camera: &camera };
    let strata = LightStrata::new(world.scene.lights(), CUT);
    let strata = LightStratum::all(&strata, view, MOST_EDGES);
    let estimator = Unpaired { strata: &strata, mixture: &Mixture::new(PathMutation::all(view)) };
    replicas_of(&estimator, camera.pixels(), film_unit(view), rounds)
}

struct Unpaired<'a> {
    strata: &'a [LightStratum<'a>],
    mixture: &'a Mixture<LightPath, LightStratum<'a>, PathMutation<'a>>,
}

impl Unpaired<'_> {
    /// Mean weight of a batch and one of its states, in proportion to weight.
    fn batch(&self, stratum: &LightStratum, round: u64, index: u64, samples: u64) -> (f64, Option<LightPath>) {
        let mut rng = generator(9, Purpose::Sample, round, index, 0);
        let mut choice = generator(9, Purpose::Start, round, index, 0);
        let (mut sum, mut state) = (0.0, None);
        for _ in 0..samples {
            stratum.sample(&mut rng, &mut |path, weight| {
                let weight = weight * Luminance.eval(path);
                sum += weight;
                if uniform(&mut choice) * sum < weight {
                    state = Some(path.clone());
                }
            });
        }
        (sum / samples as f64, state)
    }
}

impl Estimator<3> for Unpaired<'_> {
    type Prepared = u64;
    type Task = ();
    type Tally = ();

    fn prepare(&self, round: u64) -> u64 {
        round
    }

    fn tasks(&self, _: &u64) -> usize {
        self.strata.len()
    }

    fn task_deposits(&self) -> usize {
        64
    }

    fn run(&self, &round: &u64, task: usize, deposits: &mut Deposits<3>) {
        let (stratum, index) = (&self.strata[task], task as u64);
        let pixels = f64::from(SIZE[0] * SIZE[1]);
        let mutations = (MUTATIONS * pixels / self.strata.len() as f64) as u64;
        let (b, _) = self.batch(stratum, round, 2 * index, mutations / 4);
        let (_, start) = self.batch(stratum, round, 2 * index + 1, mutations / 4);
        let Some(mut chain) = start.and_then(|x| Chain::new(self.mixture, &Luminance, stratum, x)) else { return };
        let scale = b / mutations as f64;
        let mut rng = generator(9, Purpose::Chain, round, index, 0);
        (0..mutations).for_each(|_| chain.step(deposits, scale, &mut rng));
        chain.flush(deposits, scale);
    }

    fn weight(&self, _: u64) -> u64 {
        1
    }

    fn tally(&self, _: &mut (), _: &u64, _: Vec<()>) {}
}
