//! The default method in many rooms, with several seeds each.

use super::rooms::Room;
use mlt_core::measure::Measures;
use mlt_core::transport::render::{Method, Renderer, Settings};
use mlt_core::transport::scene::{Scene, View};
use std::{fmt, ops::ControlFlow};

/// Width and height of the images.
const SIZE: [u32; 2] = [32, 32];
/// Samples of a pixel in a round, and rounds: what a render has by default.
const SAMPLES: f64 = 4.0;
const ROUNDS: u64 = 16;
/// Renders of a room.
const SEEDS: u64 = 6;
/// Samples of a pixel in a round of each of the two renders whose mean is the truth.
const OF_TRUTH: f64 = 64.0;
/// Noise of the truth, as a share of the median of errors, up to which a room counts.
const KNOWN: f64 = 0.2;
/// Errors over their median from which on a seed is called bad.
const BAD: f64 = 3.0;
/// Weights of the channels in luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Errors of the seeds in a room.
pub(crate) struct Errors {
    median: f64,
    mean: f64,
    worst: f64,
}

impl Errors {
    /// In the room of this number; nothing if it has no light, or if its image is not known well enough.
    pub(crate) fn of(number: u64) -> Option<Self> {
        let Room { description, pose, max_edges } = Room::new(number);
        let scene = description.is_lit().then(|| Scene::new(description).ok())??;
        let camera = scene.camera(&pose, SIZE);
        let render = |method, samples, seed| {
            let settings = Settings::new(method, samples).with(|settings| {
                settings.max_edges = max_edges;
                settings.seed = seed;
            });
            luminance(View { scene: &scene, camera: &camera }, settings)
        };
        let [a, b] = [1, 2].map(|half| render(Method::Bidirectional, OF_TRUTH, SEEDS + half));
        let truth: Vec<_> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
        let level = mean(&truth);
        let mut errors: Vec<_> =
            (0..SEEDS).map(|seed| rel_mse(&render(Method::Auto, SAMPLES, seed), &truth, level)).collect();
        errors.sort_by(f64::total_cmp);
        let middle = errors.len() / 2;
        let median = 0.5 * (errors[(errors.len() - 1) / 2] + errors[middle]);
        // The mean of two renders has a quarter of the square of their difference.
        let known = level > 0.0 && 0.25 * rel_mse(&a, &b, level) < KNOWN * median;
        known.then(|| Self { median, mean: mean(&errors), worst: errors[errors.len() - 1] })
    }

    fn is_bad(&self) -> bool {
        self.worst > BAD * self.median
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { median, mean, worst } = self;
        write!(f, "relMSE {median:.3e} in the median, {mean:.3e} in the mean, {worst:.3e} at worst")
    }
}

/// Prints the bad rooms among these, and the geometric means over all.
pub(crate) fn study(numbers: impl Iterator<Item = u64>) {
    let rooms: Vec<_> = numbers.filter_map(|number| Some((number, Errors::of(number)?))).collect();
    let bad: Vec<_> = rooms.iter().filter(|(_, errors)| errors.is_bad()).collect();
    bad.iter().for_each(|(number, errors)| println!("room {number}: {errors}"));
    let over_rooms = |of: fn(&Errors) -> f64| {
        let logarithms: Vec<_> = rooms.iter().map(|(_, errors)| libm::log(of(errors))).collect();
        libm::exp(mean(&logarithms))
    };
    let all = Errors {
        median: over_rooms(|errors| errors.median),
        mean: over_rooms(|errors| errors.mean),
        worst: over_rooms(|errors| errors.worst),
    };
    println!("{} rooms, {} of them with a seed above {BAD} medians; geometric means: {all}", rooms.len(), bad.len());
}

fn luminance(view: View, settings: Settings) -> Vec<f64> {
    let renderer = Renderer::new(view, settings);
    let mut sums = renderer.sums();
    renderer.render(0..ROUNDS, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let of_pixel = |pixel: [f32; 3]| LUMINANCE.iter().zip(pixel).map(|(weight, x)| weight * f64::from(x)).sum();
    sums.film().means().into_iter().map(of_pixel).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// relMSE of images whose mean is made 1, so that it does not depend on the unit of light.
fn rel_mse(image: &[f64], truth: &[f64], level: f64) -> f64 {
    let [image, truth] = [image, truth].map(|pixels| pixels.iter().map(|x| x / level).collect::<Vec<_>>());
    Measures::between(&truth, &image).map_or(f64::NAN, |measures| measures.rel_mse)
}

#[test]
fn a_room_has_errors() {
    let errors = Errors::of(1).expect("a lit room");
    assert!(errors.median > 0.0 && errors.median <= errors.worst && errors.mean <= errors.worst, "{errors}");
    assert!(!errors.is_bad(), "{errors}");
}
