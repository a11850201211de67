//! Which part of the lights a pixel is lit by.

use crate::engine::mixed;
use crate::transport::colour::luminance;
use crate::transport::lights::{LightStrata, Stratification};
use crate::transport::methods::{OwenSobol, PathTracer, point_in_pixel};
use crate::transport::paths::LightEnd;
use crate::transport::scene::View;
use rayon::prelude::*;

/// Samples of each pixel.
const SAMPLES: u64 = 64;
/// Key of their sequences.
const KEY: u64 = 0x57a7;
/// Most edges of a path: direct light.
const EDGES: usize = 2;
/// Most edges of a path by mirrors and smooth glass alone.
const IMAGE_EDGES: usize = 8;

/// Of all pixels, row by row, the number of the stratum of the lights, as `stratification` cuts them before any are joined, that most
/// direct light comes from, by luminance, mirrored light included; `None` where none comes.
pub fn strongest_strata(view: View, stratification: Stratification) -> Vec<Option<u32>> {
    let strata = &LightStrata::new(view.scene.lights(), stratification);
    let light_sampler = strata.whole().light_sampler();
    let tracer = PathTracer { view, light_sampler, max_edges: EDGES, max_image_edges: IMAGE_EDGES, branches: 1 };
    let pixels = (0..u64::from(view.camera.pixels())).into_par_iter();
    pixels
        .map_init(|| vec![0.0; strata.regions().len()], |sums, pixel| of_pixel(&tracer, strata, pixel, sums))
        .collect()
}

/// `sums`: room for a number a stratum.
fn of_pixel(tracer: &PathTracer, strata: &LightStrata, pixel: u64, sums: &mut [f64]) -> Option<u32> {
    sums.fill(0.0);
    let (lights, mut rng) = (tracer.view.scene.lights(), OwenSobol::new(mixed(KEY ^ pixel)));
    for index in 0..SAMPLES {
        rng.go_to(index);
        let film = point_in_pixel(pixel, tracer.view.camera.size(), &mut rng);
        tracer.sample_radiance(film, &mut rng, &mut |radiance, end| {
            let point = match end.light {
                LightEnd::Drawn(point) => Some(*point),
                LightEnd::Met(vertex) => lights.point(vertex.primitive, vertex.position),
            };
            let light = f64::from(luminance(radiance.as_vec3()));
            if let Some(point) = point.filter(|_| light.is_finite()) {
                sums[strata.index(&point) as usize] += light;
            }
        });
    }
    let (stratum, &most) = (0..).zip(sums.iter()).max_by(|a, b| a.1.total_cmp(b.1))?;
    (most > 0.0).then_some(stratum)
}
