//! The range of values that an image's film has to hold.

use super::bidirectional::Bidirectional;
use super::independent::ImageSampler;
use super::settings::MOST_EDGES;
use super::sobol::OwenSobol;
use crate::engine::{Film, uniform_f32};
use crate::transport::colour::luminance;
use crate::transport::lights::LightRegion;
use crate::transport::scene::View;
use glam::Vec2;
use rayon::prelude::*;

/// Independent samples of the image that are taken at first, and most of them.
const SAMPLES: [u64; 2] = [1 << 8, 1 << 14];
/// Samples with light that are enough to know the image's mean to within a factor of ten, say.
const ENOUGH: usize = 16;
/// Unit of a film over the mean of its image.
const OF_MEAN: f64 = 1e-2;
/// The same over the brightest light, where samples find none: what they miss is fainter than that by their number.
const OF_LIGHT: f64 = 1e-10;

/// A black film for the image of a view.
pub fn film_of(view: View) -> Film<3> {
    Film::of_image(view.camera.size(), film_unit(view))
}

/// The unit of a [`Film`] for the image of a view, from a few bidirectional samples of it.
///
/// A film tells errors of pixels from 10⁻⁵ units to 10¹³ units over the root of the samples. With a unit of a hundredth of the image's
/// mean these are pixels of 10⁻⁷ of it, as where a lamp is in view and little of its light beside it, and there is room for 10⁵ of it in
/// any number of samples, as where one visit of a chain stands for many. What is drawn here
/// does not depend on a render's seed, method and rounds, so that their films can be added.
pub fn film_unit(view: View) -> f64 {
    let region = &LightRegion::whole(view.scene.lights());
    let sampler = Bidirectional { view, region, max_edges: MOST_EDGES };
    let (mut found, mut samples) = (Vec::new(), SAMPLES[0]);
    loop {
        let next = found.len() as u64..samples;
        found.par_extend(next.into_par_iter().map(|index| sampled(&sampler, index)));
        if samples == SAMPLES[1] || found.iter().filter(|&&x| x > 0.0).count() >= ENOUGH {
            break;
        }
        samples *= 2;
    }
    let mean = found.iter().sum::<f64>() / samples as f64;
    if mean > 0.0 { OF_MEAN * mean } else { OF_LIGHT * brightest(view) }
}

/// Contribution of one sample to the image, all pixels together.
fn sampled(sampler: &impl ImageSampler, index: u64) -> f64 {
    let mut rng = OwenSobol::new(0);
    rng.go_to(index);
    let (film, mut sum) = (Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng)), 0.0);
    sampler.sample(film, &mut rng, &mut |_, radiance, _| sum += f64::from(luminance(radiance.as_vec3())));
    if sum.is_finite() { sum } else { 0.0 }
}

/// Luminance of the brightest light.
fn brightest(view: View) -> f64 {
    let lights = &view.scene.lights().lights;
    f64::from(lights.iter().map(|light| luminance(light.brightest())).fold(0.0, f32::max))
}
