//! Methods that render the same room.

use super::dice::Dice;
use super::rooms::Room;
use mlt_core::engine::WarningKind;
use mlt_core::transport::image::Target;
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::methods::metropolis::{Perturbations, Variant};
use mlt_core::transport::paths::Classes;
use mlt_core::transport::render::{Method, Renderer, Settings, Sums};
use mlt_core::transport::scene::{Scene, View};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::{fmt, ops::ControlFlow};

/// Width and height of the images.
const SIZE: [u32; 2] = [8, 8];
/// Rounds of a render: enough to know its error from their scatter.
const ROUNDS: u64 = 16;
/// How many times the samples there are at each step, and after all of them. A few samples of a heavy tail lie about their error; these tell a
/// tail, which gives way, from a fault, which stands out the more.
const MORE: f64 = 8.0;
const STEPS: usize = 5;
const MOST: f64 = (1 << (3 * STEPS)) as f64;
/// Standard errors by which two methods may differ before they are rendered anew, and in the end.
const FAULT: f64 = 5.0;
/// Difference that rounding may make, relative to the whole image: a part that is darker than this is black to whoever looks at it.
const ROUNDING: f64 = 1e-5;
/// Means that are compared: three channels of the whole image and of its quarters.
const MEANS: usize = 15;
/// The method that all others are compared with, in [`METHODS`].
const REFERENCE: usize = 0;
/// The methods; what each is besides is random.
const METHODS: [(Method, f64); 6] = [
    (Method::Bidirectional, 1.0),
    (Method::Path, 1.0),
    (Method::Metropolis, 2.0),
    (Method::PrimaryBidirectional, 1.0),
    (Method::Multiplexed, 2.0),
    (Method::Auto, 1.0),
];

/// End of a contest in a room.
pub(crate) enum Outcome {
    Agreement,
    /// There is no scene, or no light in it.
    Refused,
    Faults(Vec<String>),
}

/// Sums of relative differences from the reference, over rooms.
#[derive(Clone, Copy, Default)]
struct Differences {
    rooms: u64,
    sum: f64,
    squares: f64,
}

/// Contests in many rooms.
pub(crate) struct Contest {
    pools: [ThreadPool; 2],
    differences: [Differences; METHODS.len()],
    /// Rooms that had a pair of methods in doubt, by how often it was rendered anew.
    doubts: [u64; STEPS],
    /// Of all sums, in the order of the rooms: the same on every machine.
    bits: blake3::Hasher,
}

impl Contest {
    pub(crate) fn new() -> Self {
        let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        Self {
            pools: [pool(1), pool(2)],
            differences: Default::default(),
            doubts: [0; STEPS],
            bits: blake3::Hasher::new(),
        }
    }

    /// Renders the room of this number by all methods.
    pub(crate) fn hold(&mut self, number: u64) -> Outcome {
        let Room { description, pose, max_edges } = Room::new(number);
        if !description.is_lit() {
            return Outcome::Refused;
        }
        let Ok(scene) = Scene::new(description) else { return Outcome::Refused };
        let camera = scene.camera(&pose, SIZE);
        let view = View { scene: &scene, camera: &camera };
        let settings = settings(number, max_edges);
        let mut faults = Vec::new();
        let renders: Vec<_> = settings.iter().map(|settings| self.render(view, settings)).collect();
        for (settings, render) in settings.iter().zip(&renders) {
            faults.extend(signs(render).into_iter().map(|sign| format!("{sign}: {settings:?}")));
        }
        for sums in &renders {
            self.bits.update(&sums.to_bytes());
        }
        let twice = number as usize % METHODS.len();
        if self.rendered(1, view, &settings[twice]).to_bytes() != renders[twice].to_bytes() {
            faults.push(format!("other bits on two threads: {:?}", settings[twice]));
        }
        let estimates: Vec<_> = renders.iter().map(Estimate::of).collect();
        self.count(&estimates);
        let mut reference = Vec::new();
        for (method, estimate) in estimates.iter().enumerate() {
            if estimates[REFERENCE].distance(estimate).0 > FAULT {
                faults.extend(self.settle(view, [&settings[REFERENCE], &settings[method]], &mut reference));
            }
        }
        if faults.is_empty() { Outcome::Agreement } else { Outcome::Faults(faults) }
    }

    /// Prints a room, and what each method sees with this many times the samples.
    pub(crate) fn show(&self, number: u64, samples: f64) {
        let room = Room::new(number);
        println!("{room:#?}");
        let scene = Scene::new(room.description).expect("a scene");
        let camera = scene.camera(&room.pose, SIZE);
        for settings in settings(number, room.max_edges) {
            let settings = settings.with(|settings| settings.per_pixel *= samples);
            let Estimate(means) = Estimate::of(&self.render(View { scene: &scene, camera: &camera }, &settings));
            let means = means.map(|(mean, error)| format!("{mean:.5} ± {error:.5}"));
            println!("{:?} {:?}: {}", settings.method, settings.stratification, means.join("  "));
        }
    }

    /// Renders a method and the reference anew, with more and more samples, until they agree; the disagreement that is left. `references`:
    /// what other methods have had made of the reference in this room, step by step.
    fn settle(&mut self, view: View, pair: [&Settings; 2], references: &mut Vec<Estimate>) -> Option<String> {
        let (mut samples, mut disagreement) = (MORE, None);
        for step in 0..STEPS {
            self.doubts[step] += 1;
            let more = |settings: &mut Settings| {
                settings.seed += samples as u64;
                settings.per_pixel *= samples;
            };
            let render = |settings: &Settings| Estimate::of(&self.render(view, &settings.clone().with(more)));
            if references.len() == step {
                references.push(render(pair[0]));
            }
            let (a, b) = (&references[step], render(pair[1]));
            let (distance, mean) = a.distance(&b);
            if distance <= FAULT {
                return None;
            }
            let [a, b] = [a, &b].map(|estimate| estimate.0[mean]);
            disagreement = Some(format!(
                "{distance:.1} standard errors apart in mean {mean}: {:.6} ± {:.6} and {:.6} ± {:.6}: {:?}",
                a.0, a.1, b.0, b.1, pair[1]
            ));
            samples *= MORE;
        }
        disagreement
    }

    fn render(&self, view: View, settings: &Settings) -> Sums {
        self.rendered(0, view, settings)
    }

    fn rendered(&self, pool: usize, view: View, settings: &Settings) -> Sums {
        self.pools[pool].install(|| {
            let renderer = Renderer::new(view, settings.clone());
            let mut sums = renderer.sums();
            renderer.render(0..ROUNDS, &mut sums, &mut |_, _| ControlFlow::Continue(()));
            sums
        })
    }

    /// Adds the methods' differences from the reference, relative to what the methods besides the two see.
    fn count(&mut self, estimates: &[Estimate]) {
        let whole: Vec<f64> =
            estimates.iter().map(|estimate| estimate.0[..3].iter().map(|mean| mean.0).sum()).collect();
        for (method, sums) in self.differences.iter_mut().enumerate().filter(|(method, _)| *method != REFERENCE) {
            let others = whole.iter().enumerate().filter(|(other, _)| ![REFERENCE, method].contains(other));
            let scale = others.map(|(_, mean)| mean).sum::<f64>() / (METHODS.len() - 2) as f64;
            let difference = (whole[method] - whole[REFERENCE]) / scale;
            if difference.is_finite() {
                *sums = Differences {
                    rooms: sums.rooms + 1,
                    sum: sums.sum + difference,
                    squares: sums.squares + difference * difference,
                };
            }
        }
    }
}

impl fmt::Display for Contest {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "pairs rendered anew with 8, 64, … {MOST} times the samples: {:?}", self.doubts)?;
        for ((method, _), Differences { rooms, sum, squares }) in
            METHODS.iter().zip(self.differences).skip(REFERENCE + 1)
        {
            let (n, mean) = (rooms as f64, sum / rooms as f64);
            let error = ((squares / n - mean * mean) / (n - 1.0)).sqrt();
            writeln!(
                f,
                "{method:?} - Bidirectional: {:+.3} % ± {:.3} %, mean of {rooms} rooms",
                100.0 * mean,
                100.0 * error
            )?;
        }
        writeln!(f, "bits of all sums: {}", self.bits.finalize())
    }
}

/// Settings of all methods in a room.
fn settings(number: u64, max_edges: Option<usize>) -> [Settings; METHODS.len()] {
    let mut dice = Dice::of(!number);
    METHODS.map(|(method, per_pixel)| {
        let grid = Stratification::Grid(1 + dice.up_to(2) as u32, 1 + dice.up_to(1) as u32);
        Settings::new(method, per_pixel).with(|settings| {
            settings.max_edges = max_edges;
            settings.seed = number << 16;
            settings.stratification =
                dice.pick(&[Stratification::None, grid, grid, Stratification::Count(5), Stratification::Auto]);
            settings.classes = dice.pick(&[
                Classes::default(),
                Classes { lengths: true, tiles: [1, 1] },
                Classes { lengths: true, tiles: [2, 2] },
            ]);
            settings.variant = dice.pick(&[Variant::Stratified, Variant::Stratified, Variant::MutationOnly]);
            settings.target = dice.pick(&[Target::Luminance, Target::Luminance, Target::Relative]);
            settings.perturbations = dice.pick(&[Perturbations::ALL, Perturbations::ALL, Perturbations::NONE]);
        })
    })
}

/// Signs in a render that something is wrong, whatever the others show.
fn signs(sums: &Sums) -> Vec<String> {
    let means = sums.film().means();
    let not_light = means.iter().flatten().any(|&value| !value.is_finite() || value < 0.0);
    let wrong = |kind| !matches!(kind, WarningKind::DarkRounds | WarningKind::Black | WarningKind::Disagreement);
    let warnings = sums.tally().chains().warnings().into_iter().filter(|warning| wrong(warning.kind));
    let lost = (sums.film().lost().count > 0).then(|| format!("{:?}", sums.film().lost()));
    let not_light = not_light.then(|| "pixels that are negative or not finite".to_owned());
    not_light.into_iter().chain(lost).chain(warnings.map(|warning| warning.to_string())).collect()
}

/// Means and their standard errors, from the scatter of rounds.
struct Estimate([(f64, f64); MEANS]);

impl Estimate {
    fn of(sums: &Sums) -> Self {
        let blocks = sums.film().blocks();
        let channels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|weights| blocks.rounds(weights));
        let [columns, rows] = blocks.grid().cut;
        let part = |block: usize| {
            1 + 2 * usize::from(block / columns >= rows / 2) + usize::from(block % columns >= columns / 2)
        };
        Self(std::array::from_fn(|i| {
            let (area, channel) = (i / 3, &channels[i % 3]);
            let of = |round: &Vec<f64>| {
                round
                    .iter()
                    .enumerate()
                    .filter(|(block, _)| area == 0 || part(*block) == area)
                    .map(|(_, x)| x)
                    .sum::<f64>()
            };
            let rounds: Vec<f64> = channel.iter().map(of).collect();
            let n = rounds.len() as f64;
            let mean = rounds.iter().sum::<f64>() / n;
            let variance = rounds.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0));
            (mean, variance.sqrt())
        }))
    }

    /// Largest difference of a mean in standard errors, and which mean it is.
    fn distance(&self, other: &Self) -> (f64, usize) {
        let distance = |mean: usize| {
            let (a, b) = (self.0[mean], other.0[mean]);
            let whole = self.0[mean % 3].0.abs().max(other.0[mean % 3].0.abs());
            let rounding = ROUNDING * whole;
            match (a.0 - b.0).abs() {
                difference if difference <= rounding => 0.0,
                difference => difference / (a.1 * a.1 + b.1 * b.1 + rounding * rounding).sqrt(),
            }
        };
        (0..MEANS).map(|mean| (distance(mean), mean)).max_by(|a, b| a.0.total_cmp(&b.0)).expect("means")
    }
}
