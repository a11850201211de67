//! Values and densities of scattering functions on a grid of directions, one row a pair, for comparison with other renderers.
//!
//!     cargo run --release -p mlt-core --example bsdf_table > table.tsv
//!
//! The normal is z, the tangent x. Columns: kind, α along the tangent, α across it, index of refraction, reflectance, the direction to the eye,
//! the direction to the light, value, density of the light's direction given the eye's, sr⁻¹. A value is f_s |cosθ| of the light's side, sr⁻¹; of
//! a smooth surface it is radiance towards the eye over radiance from the light, and the density is the probability of the event. Of metal and
//! glass with light that meets the surface more than once the density is left out.

use mlt_core::glam::Vec3A;
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::microfacet::{Ggx, Microfacets};
use mlt_core::transport::bsdf::{
    AnisotropicGgx, Bsdf, Conductor, Dielectric, Lambert, RoughDielectric, RoughInterface, Thin, fresnel::schlick,
};
use std::f32::consts::TAU;
use std::iter::once;

/// cosθ towards the eye.
const EYES: [f32; 5] = [0.15, 0.4, 0.7, 0.9, 0.99];
const N: Vec3A = Vec3A::Z;

/// Columns that say which surface it is.
#[derive(Clone, Copy)]
struct Case {
    kind: &'static str,
    alphas: [f32; 2],
    ior: f32,
    reflectance: f32,
}

fn main() {
    for reflectance in [0.2, 0.7] {
        let lambert = Bsdf::Lambert(Lambert { reflectance: Rgb::splat(reflectance) });
        rough(Case { kind: "lambert", alphas: [1.0; 2], ior: 1.0, reflectance }, |eye, light| {
            let met = lambert.evaluate(N, light, eye);
            [met.value.x, met.pdf_to_light]
        });
    }
    [0.05, 0.2, 0.5, 1.0].into_iter().for_each(|alpha| mirrors([alpha; 2], Ggx { alpha }));
    [0.2, 0.5, 1.0].into_iter().for_each(metals);
    [[0.5, 0.1], [0.05, 0.3]].into_iter().for_each(|alphas| {
        mirrors(alphas, AnisotropicGgx { tangent: Vec3A::X, alphas });
    });
    for (ior, alpha) in [(1.5, 0.05), (1.5, 0.3), (1.33, 0.6), (2.4, 0.1), (0.75, 0.2)] {
        let glass = RoughInterface { ior, tint: Rgb::ONE, ggx: Ggx { alpha } };
        rough(Case { kind: "rough_glass", alphas: [alpha; 2], ior, reflectance: 1.0 }, |eye, light| {
            let met = glass.evaluate(N, light, eye);
            [met.value.x, met.pdf_to_light]
        });
    }
    for (ior, alpha) in [(1.5, 0.3), (1.5, 1.0), (1.33, 0.6), (0.75, 0.5)] {
        let glass = RoughDielectric::new(ior, Rgb::ONE, Ggx { alpha });
        rough(Case { kind: "whole_glass", alphas: [alpha; 2], ior, reflectance: 1.0 }, |eye, light| {
            [glass.evaluate(N, light, eye).value.x, 0.0]
        });
    }
    for ior in [1.33, 1.5, 2.4, 0.75] {
        smooth("glass", ior, Bsdf::Dielectric(Dielectric { ior, tint: Rgb::ONE }));
    }
    [1.33, 1.5, 2.4].into_iter().for_each(|ior| smooth("wall", ior, Bsdf::Thin(Thin { ior, tint: Rgb::ONE })));
}

/// Microfacets of Schlick's reflectance, and these with light that is reflected more than once.
fn metals(alpha: f32) {
    let ggx = Ggx { alpha };
    for reflectance in [0.2, 0.8, 1.0] {
        let metal = Conductor::new(Rgb::splat(reflectance), 1.0, ggx);
        let case = |kind| Case { kind, alphas: [alpha; 2], ior: 1.0, reflectance };
        rough(case("schlick"), |eye, light| {
            ggx.reflection(N, light, eye)
                .map_or([0.0; 2], |met| [schlick(metal.f0, metal.f90, met.cos_half).x * met.value, met.pdf[0]])
        });
        rough(case("metal"), |eye, light| [metal.evaluate(N, light, eye).value.x, 0.0]);
    }
}

/// Microfacets that reflect everything.
fn mirrors(alphas: [f32; 2], facets: impl Microfacets) {
    rough(Case { kind: "facets", alphas, ior: 1.0, reflectance: 1.0 }, |eye, light| {
        facets.reflection(N, light, eye).map_or([0.0; 2], |met| [met.value, met.pdf[0]])
    });
}

/// Rows of a surface that is not smooth, from f_s and density, sr⁻¹.
fn rough(case: Case, evaluate: impl Fn(Vec3A, Vec3A) -> [f32; 2]) {
    for eye in eyes(case.ior != 1.0) {
        for light in lights(&case, eye) {
            let [value, pdf] = evaluate(eye, light);
            row(case, eye, light, [value * light.z.abs(), pdf]);
        }
    }
}

/// Rows of a smooth surface: each direction to the eye with the one that it is mirrored from, and the one that is refracted.
fn smooth(kind: &'static str, ior: f32, bsdf: Bsdf) {
    let case = Case { kind, alphas: [0.0; 2], ior, reflectance: 1.0 };
    let eta = |v: Vec3A| if kind == "wall" || v.z > 0.0 { 1.0 } else { ior };
    for eye in eyes(true) {
        for light in [false, true].into_iter().filter_map(|transmit| bsdf.delta_direction(N, eye, transmit)) {
            let value = bsdf.eval(N, light, eye).x / (eta(light) * eta(light));
            row(case, eye, light, [value, bsdf.event_probability(N, eye, light)]);
        }
    }
}

/// Directions to the eye, on the front or on either side.
fn eyes(both: bool) -> Vec<Vec3A> {
    let sides = if both { &[1.0, -1.0][..] } else { &[1.0] };
    sides.iter().flat_map(|side| EYES.map(|cos| direction(side * cos, 0.3))).collect()
}

/// Directions to the light: a grid, and what microfacets near the normal mirror or refract towards the eye.
fn lights(case: &Case, eye: Vec3A) -> Vec<Vec3A> {
    let turns = || (0..6).map(|i| TAU * i as f32 / 6.0);
    let both = case.ior != 1.0;
    let sides = if both { &[1.0, -1.0][..] } else { &[1.0] };
    let grid = sides.iter().flat_map(|side| [0.08, 0.3, 0.6, 0.85, 0.98].map(|cos| side * cos));
    let mut lights: Vec<Vec3A> = grid.flat_map(|cos| turns().map(move |turn| direction(cos, turn))).collect();
    // What is met more than once has no peak, and takes the reader of the table long.
    let slopes = if case.kind == "whole_glass" { &[][..] } else { &[0.0, 0.5, 1.0, 2.0] };
    let slopes = slopes.iter().map(|slope| slope * case.alphas[0].min(case.alphas[1]));
    for normal in slopes.flat_map(|t| turns().map(move |turn| direction(1.0 / (1.0 + t * t).sqrt(), turn))) {
        let interface = Dielectric { ior: case.ior, tint: Rgb::ONE };
        lights.extend(
            once(false).chain(sides.get(1).map(|_| true)).filter_map(|t| interface.delta_direction(normal, eye, t)),
        );
    }
    lights.retain(|light| if both { light.z.abs() > 0.02 } else { light.z > 0.02 });
    lights
}

/// The unit direction of a cosine and an azimuth.
fn direction(cos: f32, turn: f32) -> Vec3A {
    let sin = (1.0 - cos * cos).sqrt();
    Vec3A::new(sin * turn.cos(), sin * turn.sin(), cos)
}

fn row(case: Case, eye: Vec3A, light: Vec3A, [value, pdf]: [f32; 2]) {
    let Case { kind, alphas: [along, across], ior, reflectance } = case;
    let vector = |v: Vec3A| format!("{}\t{}\t{}", v.x, v.y, v.z);
    println!("{kind}\t{along}\t{across}\t{ior}\t{reflectance}\t{}\t{}\t{value}\t{pdf}", vector(eye), vector(light));
}

#[test]
fn it_runs() {
    main();
}
