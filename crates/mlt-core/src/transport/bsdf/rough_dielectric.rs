//! Rough interface between two transparent media.

use super::albedo::{Curve, at_cosine, cosine_average};
use super::fresnel::dielectric;
use super::microfacet::{GRAZING, Ggx};
use super::rough_interface::RoughInterface;
use super::spread::Spread;
use super::{Evaluation, choose};
use crate::transport::colour::Rgb;
use glam::Vec3A;
use std::f32::consts::FRAC_1_PI;

/// f_s = f_once + c m(l) m(e) ηₑ², m = 1 - ∫ f_once cosθ dω without tint.
///
/// The second term is what meets the surface more than once. Of this light M = η² m̄ comes along all directions of a side, and X
/// goes over to the other: X = (1 - F̄) min M, F̄ the rarer side's mean reflectance. c = (1 - X/M)/(π M) for two directions on one
/// side, and tint X/(π M M') for two sides. Untinted it absorbs nothing. Derivation: docs/theory-surfaces.md.
///
/// Source: after Kulla & Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH course, 2017.
#[derive(Clone, Copy, Debug)]
pub struct RoughDielectric {
    /// Light scattered once, f_once.
    pub once: RoughInterface,
    spread: Spread,
    /// Front, back.
    sides: [Side; 2],
    /// X/(π M M'), sr⁻¹.
    transmission: f32,
}

/// Light scattered more than once, on one side.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// m.
    lacking: Curve,
    /// X/M, the share that leaves on the other side.
    transmitted: f32,
    /// (1 - X/M)/(π M), sr⁻¹.
    reflection: f32,
}

/// Light that meets an interface more than once.
#[derive(Clone, Copy, Debug)]
struct Multiple {
    /// m on the front and on the back.
    lacking: [Curve; 2],
    /// M on the front and on the back.
    flux: [f32; 2],
}

impl Multiple {
    fn new(ior: f32, ggx: Ggx) -> Self {
        let once = RoughInterface { ior, tint: Rgb::ONE, ggx };
        let lacking = [1.0, -1.0].map(|side| Curve::new(ggx, |cos| once.albedo(side * at_cosine(cos))));
        let flux = [lacking[0].average(), ior * ior * lacking[1].average()].map(|m| m.max(f32::MIN_POSITIVE));
        Self { lacking, flux }
    }

    /// Of microfacets between those of two others.
    fn between(ggx: Ggx, [a, b]: [&Self; 2], t: f32) -> Self {
        let lacking = std::array::from_fn(|side| Curve::between(ggx, [&a.lacking[side], &b.lacking[side]], t));
        Self { lacking, flux: std::array::from_fn(|side| a.flux[side] + t * (b.flux[side] - a.flux[side])) }
    }
}

/// F̄ on the rarer side.
fn mean_reflectance(ior: f32) -> f32 {
    cosine_average(|cos| [dielectric(cos, ior.max(1.0 / ior))])[0]
}

/// Rough interfaces of one index and of any roughness up to 1, for roughness that varies over a surface.
#[derive(Clone, Debug)]
pub struct RoughGlass {
    ior: f32,
    /// F̄.
    reflected: f32,
    /// At equidistant roughnesses √α between `roughness`.
    rows: Vec<Multiple>,
    roughness: [f32; 2],
}

impl RoughGlass {
    /// Steps of roughness from 0 to 1.
    const STEPS: f32 = 32.0;

    /// Of roughnesses √α between two, both above 0.
    pub fn new(ior: f32, roughness: [f32; 2]) -> Self {
        let [least, most] = roughness;
        let last = (Self::STEPS * (most - least)).ceil();
        let row = |i: usize| {
            let roughness = least + (most - least) * (i as f32 / last.max(1.0));
            Multiple::new(ior, Ggx { alpha: roughness * roughness })
        };
        Self { ior, reflected: mean_reflectance(ior), rows: (0..=last as usize).map(row).collect(), roughness }
    }

    /// The interface of this tint and these microfacets.
    pub fn at(&self, tint: Rgb, ggx: Ggx) -> RoughDielectric {
        let once = RoughInterface { ior: self.ior, tint, ggx };
        let [least, most] = self.roughness;
        let [.., last] = &self.rows[..] else { return RoughDielectric::new(self.ior, tint, ggx) };
        if self.rows.len() == 1 {
            return RoughDielectric::of(once, last, self.reflected);
        }
        let share = ((ggx.alpha.sqrt() - least) / (most - least)).clamp(0.0, 1.0);
        let position = share * (self.rows.len() - 1) as f32;
        let row = (position as usize).min(self.rows.len() - 2);
        let multiple = Multiple::between(ggx, [&self.rows[row], &self.rows[row + 1]], position - row as f32);
        RoughDielectric::of(once, &multiple, self.reflected)
    }
}

impl RoughDielectric {
    /// An interface to a medium of this index.
    pub fn new(ior: f32, tint: Rgb, ggx: Ggx) -> Self {
        Self::of(RoughInterface { ior, tint, ggx }, &Multiple::new(ior, ggx), mean_reflectance(ior))
    }

    fn of(once: RoughInterface, multiple: &Multiple, reflected: f32) -> Self {
        let Multiple { lacking: [front, back], flux } = *multiple;
        let exchanged = (1.0 - reflected) * flux[0].min(flux[1]);
        let side = |lacking, flux: f32| {
            let transmitted = exchanged / flux;
            Side { lacking, transmitted, reflection: (1.0 - transmitted) * FRAC_1_PI / flux }
        };
        let sides = [side(front, flux[0]), side(back, flux[1])];
        let transmission = (1.0 - reflected) * FRAC_1_PI / flux[0].max(flux[1]);
        Self { once, spread: Spread::new(once.ggx), sides, transmission }
    }

    /// The side on which n·direction has this sign.
    #[inline]
    fn side(&self, cos: f32) -> &Side {
        &self.sides[usize::from(cos < 0.0)]
    }

    /// f_s, and (1 - m) times the density of what is scattered once, plus m (1 - X/M) or m X/M times q of `Spread`.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let (l, e) = (n.dot(to_light), n.dot(to_eye));
        if l.abs().min(e.abs()) <= GRAZING {
            return Evaluation::NOTHING;
        }
        let once = self.once.evaluate(n, to_light, to_eye);
        let is_reflected = l * e > 0.0;
        let lacking = [l, e].map(|cos| self.side(cos).lacking.at(cos.abs()));
        let factor =
            if is_reflected { Rgb::splat(self.side(l).reflection) } else { self.once.tint * self.transmission };
        let eta = self.once.eta(e);
        let pdf = |once: f32, given: f32, lacking: f32, sampled: f32| {
            let transmitted = self.side(given).transmitted;
            let share = if is_reflected { 1.0 - transmitted } else { transmitted };
            (1.0 - lacking) * once + lacking * share * self.spread.pdf(sampled.abs())
        };
        Evaluation {
            value: once.value + factor * (lacking[0] * lacking[1] * eta * eta),
            pdf_to_eye: pdf(once.pdf_to_eye, l, lacking[0], e),
            pdf_to_light: pdf(once.pdf_to_light, e, lacking[1], l),
        }
    }

    /// Draws what is scattered once, or from `Spread` on either side.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let cos = n.dot(given);
        if cos.abs() <= GRAZING {
            return None;
        }
        let side = self.side(cos);
        match choose(u[2], side.lacking.at(cos.abs())) {
            (false, rest) => self.once.sample(n, given, [u[0], u[1], rest]),
            (true, rest) => {
                let stays = if rest < side.transmitted { -1.0 } else { 1.0 };
                Some(self.spread.sample(n * (stays * 1f32.copysign(cos)), [u[0], u[1]]))
            }
        }
    }
}
