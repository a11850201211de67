//! From what a pilot measured to errors and costs of each part.

use super::candidates::Candidate;
use super::constants::{MET, NOTABLE, SMOOTH, WIDEST};
use super::decide::Costs;
use super::doubt::upper;
use super::measure::Measured;
use super::parts::Parts;
use super::per_method::PerMethod;
use super::share::side;
use super::tails::Tail;
use crate::engine::Measure;
use crate::transport::image::{blurred, weights_of_smooth};
use crate::transport::paths::Kinds;

/// Weights of squared errors on the pilot's image. Where a sampler met something bright, the image is taken to be so.
///
/// The image is smoothed until little noise is left in it. Weights of a noisy image are small where a rare bright sample
/// happened to fall, which is where the measured variance is, and large wherever none did: they hide the noise of
/// samples, and exaggerate that of chains.
pub(super) fn weights(measured: &PerMethod<Measured>, size: [u32; 2]) -> Vec<f64> {
    let images = measured.as_ref().map(Measured::image);
    let noise = |weights: &[f64], radius: usize| {
        let of_images: f64 = measured.iter().map(|m| m.whole_error(weights) / m.samples).sum();
        0.25 * of_images / (2 * radius + 1).pow(2) as f64
    };
    let widest = WIDEST * f64::from(size[0].max(size[1]));
    let mut radius = 1;
    loop {
        let weights = smoothed_weights(&images, size, radius);
        if noise(&weights, radius) < SMOOTH || 2.0 * radius as f64 > widest {
            return weights;
        }
        radius *= 2;
    }
}

fn smoothed_weights(images: &PerMethod<Vec<f64>>, size: [u32; 2], radius: usize) -> Vec<f64> {
    let smooth = images.as_ref().map(|image| blurred(image, size, radius));
    let darker = |i: usize| images.path[i].min(images.bidirectional[i]);
    let level = |i: usize| darker(i).max(0.5 * (smooth.path[i] + smooth.bidirectional[i]));
    weights_of_smooth(&(0..images.path.len()).map(level).collect::<Vec<_>>())
}

/// Error that chains leave in an image of `to` pixels, as a mean over pixels and for each mutation and sample a pixel, from the
/// sum over a pilot's image of `from` pixels and for each mutation and sample.
///
/// A pixel of the larger image gets fewer visits, but an error of b_j is the same in all of them.
pub(super) fn per_pixel(measure: Measure, from: u32, to: u32) -> Measure {
    let [from, to] = [from, to].map(f64::from);
    Measure {
        chain_error: measure.chain_error.map(|error| error / (from * from)),
        sample_error: measure.sample_error / (from * to),
        ..measure
    }
}

/// Figures of the chains in a part.
#[derive(Clone, Copy, Default)]
pub(super) struct Chained {
    /// See [`per_pixel`].
    pub(super) measure: Measure,
    /// Mean over pixels, and its standard error.
    pub(super) energy: [f64; 2],
}

/// Findings of the independent methods.
pub(super) struct Findings<'a> {
    pub(super) parts: &'a Parts<'a>,
    pub(super) candidates: &'a [Candidate],
    pub(super) measured: &'a PerMethod<Measured>,
    /// Of squared errors, pixel by pixel.
    pub(super) weights: &'a [f64],
    /// Second moments that both have not met, part by part: see [`Tails`](super::tails::Tails). None of lamps in view: none is rarer
    /// than it is small, and the rays that meet it are well spread.
    pub(super) tails: Vec<PerMethod<Tail>>,
}

impl Findings<'_> {
    /// Cost of each part by each estimator.
    pub(super) fn costs(&self, chains: &[Chained]) -> Vec<Costs> {
        let most = self.candidates.iter().map(|c| c.max_edges).max().unwrap_or(0);
        let rarely = self.rarely_met(chains);
        let of_part = |(part, chained): (usize, &Chained)| {
            let of_chains = |bound: f64| self.of_chains(part, chained, bound);
            let (chains, at_most) = (of_chains(1.0), of_chains(upper(chained.measure.chain_events)));
            // How noisy a method is where it meets light rarely, nobody knows: chains have it, if they are of any use.
            let unknown = rarely[part].map(|rarely| rarely && chains.is_finite());
            let errors = self.errors(part, chained).zip(unknown);
            let errors = errors.map(|(error, unknown)| if unknown { f64::INFINITY } else { error });
            let kinds = self.parts.group(part);
            let of = |c: &Candidate| match c.scale(kinds, most) {
                scale if scale.is_finite() => scale * errors.of(c.sampler),
                scale => scale,
            };
            let rare = unknown.path || unknown.bidirectional;
            Costs { independent: self.candidates.iter().map(of).collect(), chains, at_most, rare }
        };
        chains.iter().enumerate().map(of_part).collect()
    }

    /// Whether each part has light that matters and that path tracing, and bidirectional path tracing, were to meet fewer than
    /// ten times. Longer paths come the same way.
    fn rarely_met(&self, chains: &[Chained]) -> Vec<PerMethod<bool>> {
        let light: Vec<_> = chains.iter().enumerate().map(|(part, chained)| self.light(part, chained)).collect();
        let image: f64 = light.iter().sum();
        let is_rare =
            |part: usize| self.unmet(part).map(|unmet| unmet > 1.0 - MET && unmet * light[part] > NOTABLE * image);
        let either = |a: PerMethod<bool>, b| a.zip(b).map(|(a, b)| a || b);
        let of_part = |part: usize| self.parts.no_longer_than(part).map(is_rare).fold(PerMethod::default(), either);
        (0..chains.len()).map(of_part).collect()
    }

    /// The part's light, as far as anyone found it.
    fn light(&self, part: usize, chained: &Chained) -> f64 {
        self.measured.iter().map(|m| m.energy(part)[0]).fold(chained.energy[0], f64::max)
    }

    /// Share of the part's light that each method was to meet fewer than ten times.
    fn unmet(&self, part: usize) -> PerMethod<f64> {
        let both = self.measured.as_ref().zip(self.tails[part]);
        both.map(|(m, tail)| if m.largest[part] > 0.0 { tail.light } else { 1.0 })
    }

    /// Error × work of chains, their noise being so many times what was measured.
    fn of_chains(&self, part: usize, chained: &Chained, bound: f64) -> f64 {
        match chained.measure.chain_error {
            // A few rounds do not tell which of the lamps in view, or of their images, chains have not found, and camera
            // rays find them all.
            _ if self.parts.group(part).is_within(Kinds::SEEN) => f64::INFINITY,
            Some(error) => side(&Measure { chain_error: Some(bound * error), ..chained.measure }).powi(2),
            // Chains that found no light where samples did are no use.
            None if self.measured.iter().any(|m| m.energy(part)[0] > 0.0) => f64::INFINITY,
            None => 0.0,
        }
    }

    /// Error that each method leaves in a part, for one sample a pixel.
    fn errors(&self, part: usize, chained: &Chained) -> PerMethod<f64> {
        let (measured, weights) = (self.measured.as_ref(), self.weights);
        let (pixels, weight) = (weights.len() as f64, weights.iter().sum::<f64>() / weights.len() as f64);
        let found = measured.map(|m| m.energy(part));
        let all = found.iter().chain([&chained.energy]);
        let certain = all.map(|[energy, error]| energy - 2.0 * error).fold(0.0, f64::max);
        let met = measured.zip(self.tails[part]).map(|(m, tail)| m.error(part, weights) + tail.moment);
        measured.zip(found).zip(met.zip(met.swapped())).map(|((m, [energy, _]), (met, of_other))| {
            // What N samples missed is carried by events rarer than 3/N, whose second moment is at least so large.
            let missed = weight * (0.5 * certain - energy).max(0.0).powi(2) * m.samples * pixels / 3.0;
            // If it found no light, the other one's noise is the best that is known.
            let unknown = if energy > 0.0 { 0.0 } else { of_other };
            met.max(missed).max(unknown)
        })
    }

    /// Error that chains may leave in parts where they have hardly found light, but samples have: nothing better is known than the most
    /// that they leave of any other part, as light goes.
    pub(super) fn fill_in(&self, chains: &mut [Chained]) {
        let noise = |c: &Chained| c.measure.chain_error.map(|error| error / (c.energy[0] * c.energy[0]));
        let worst = chains.iter().filter_map(noise).filter(|q| q.is_finite()).fold(0.0, f64::max);
        let cost = chains.iter().map(|c| c.measure.mutation_cost).fold(0.0, f64::max);
        for (part, Chained { measure, .. }) in chains.iter_mut().enumerate() {
            let found = self.measured.iter().map(|m| m.energy(part)[0]).fold(0.0, f64::max);
            if measure.chain_error.is_none() && worst > 0.0 && found > 0.0 {
                measure.chain_error = Some(worst * found.powi(2));
                (measure.chain_events, measure.mutation_cost) = (f64::INFINITY, cost);
            }
        }
    }

    /// Light that chains lack in a part's image; `image`: the pixels that they lit.
    pub(super) fn missed_by_chains(&self, part: usize, image: &[(u32, f64)]) -> f64 {
        let both = self.measured.as_ref().map(|m| (m, m.error(part, self.weights) / m.samples));
        missed_by_chains(both, part, image, self.weights)
    }
}

/// Light that chains lack in a part's image, as a sum over pixels of weight × squared difference: a light or a highlight that none of
/// them has met shows no noise. `measured`: independent methods and their errors.
///
/// With c the chains' pixel, m that of the independent method with less error, and v the variance of m, E[(m − c)² − v] is the
/// squared error of c, and varies by about 4 (m − c)² v + 2 v². Only pixels that chains leave darker count, and what stands
/// three standard deviations above nothing.
fn missed_by_chains(measured: PerMethod<(&Measured, f64)>, part: usize, image: &[(u32, f64)], weights: &[f64]) -> f64 {
    let PerMethod { path, bidirectional } = measured;
    let (sampler, _) = if bidirectional.1 < path.1 { bidirectional } else { path };
    let mut chains = vec![0.0; weights.len()];
    image.iter().for_each(|&(site, value)| chains[site as usize] = value);
    let (mut sum, mut variance) = (0.0, 0.0);
    for (pixel, (c, w)) in chains.into_iter().zip(weights).enumerate() {
        let (m, v) = sampler.pixel(part, pixel);
        let square = (m - c).max(0.0).powi(2);
        if square > 0.0 {
            sum += w * (square - v);
            variance += w * w * (4.0 * square * v + 2.0 * v * v);
        }
    }
    (sum - 3.0 * variance.sqrt()).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, uniform};

    const SIZE: [u32; 2] = [64, 64];

    /// Two sequences of 16 samples a pixel of a flat image of level 1, whose light comes as events of probability `p`.
    fn measured(p: f64, seed: u64) -> Measured {
        let mut rng = generator(seed, Purpose::Image, 0, 0, 0);
        let mut sequence = || (0..16).filter(|_| uniform(&mut rng) < p).count() as f64 / (16.0 * p);
        let pixels = (0..SIZE[0] * SIZE[1]).map(|_| [sequence(), sequence()]);
        let (mean, variance) = pixels.map(|[a, b]| (0.5 * (a + b), 8.0 * (a - b).powi(2))).unzip();
        Measured::of_image(mean, variance, 32.0)
    }

    fn both(p: f64) -> PerMethod<Measured> {
        PerMethod { path: 1, bidirectional: 2 }.map(|seed| measured(p, seed))
    }

    #[test]
    fn rare_events_do_not_hide_their_noise() {
        for p in [0.5, 0.05, 0.0005] {
            let both = both(p);
            let exact = (1.0 / p - 1.0) / 1.01;
            let found = both.path.whole_error(&weights(&both, SIZE)) / exact;
            assert!((0.6..1.4).contains(&found), "{p}: {found}");
        }
        // The negative control: an image that is still noisy.
        let both = both(0.0005);
        let noisy = smoothed_weights(&both.as_ref().map(Measured::image), SIZE, 1);
        assert!(both.path.whole_error(&noisy) < 0.3 * 2000.0);
    }

    /// An image of level 1, by samples that are quiet or come as rare events, and by chains that lit all of it, or all but a
    /// sixteenth.
    #[test]
    fn a_highlight_that_chains_have_not_met_is_told_from_noise() {
        let weights = vec![1.0; 4096];
        let missed = |p: f64, unlit: u32| {
            let measured = both(p);
            let image: Vec<_> = (unlit..4096).map(|site| (site, 1.0)).collect();
            missed_by_chains(measured.as_ref().map(|m| (m, m.error(0, &weights))), 0, &image, &weights)
        };
        let found = missed(0.5, 256);
        assert!((180.0..270.0).contains(&found), "{found}");
        assert_eq!(missed(0.5, 0), 0.0);
        assert_eq!(missed(0.0005, 256), 0.0);
    }

    #[test]
    fn errors_of_b_do_not_grow_with_the_image() {
        let pilot = Measure { chain_error: Some(100.0), sample_error: 100.0, ..Measure::default() };
        let [small, large] = [100, 1600].map(|to| per_pixel(pilot, 10, to));
        assert_eq!((small.chain_error, small.sample_error), (Some(1.0), 0.1));
        assert_eq!((large.chain_error, large.sample_error), (Some(1.0), 0.1 / 16.0));
    }
}
