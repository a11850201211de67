//! Scattering at a surface.
//!
//! Conventions, the same for every [`Bsdf`]:
//!
//! * Directions are unit vectors in world space that point away from the surface; `n` is the unit shading normal,
//!   which stands on the outside (the front) of the surface.
//! * `eval(n, to_light, to_eye)` is the BSDF for radiance that arrives from `to_light` and leaves along `to_eye`, sr⁻¹,
//!   radiance scaling by η² at refraction included. It names the two ends of the path and not a mode of transport:
//!   light and camera subpaths evaluate the same number for the same path.
//! * `pdf(n, given, sampled)` is the density per unit solid angle, sr⁻¹, with which `sample(n, given, ·)` draws `sampled`.
//!   `given` is whichever of the two directions is known.
//! * A delta BSDF (`is_delta`) gives coefficients of δ in the measure dσ⊥ = η²|cosθ| dω, which refraction and
//!   reflection leave unchanged: eval = F·η²(eye side), pdf = P(event)·η²(sampled side)·|cosθ(sampled)|, with F the share of
//!   energy and P the probability of the event. So both subpaths' densities of one path have the same δ as factor, and
//!   it cancels in every ratio.

mod albedo;
mod albedo_table;
mod anisotropic;
mod brushed;
mod conductor;
mod conversion;
mod dielectric;
mod facets;
pub mod fresnel;
mod glossy;
mod interpolation;
mod lacking;
mod lambert;
mod layered;
mod metallic_roughness;
pub mod microfacet;
mod mirror;
mod mix;
mod narrow;
mod rough_dielectric;
mod rough_interface;
mod rough_thin;
mod sheen;
mod spread;
#[cfg(test)]
mod tests;
mod thin;
mod varying;

use crate::transport::colour::Rgb;
use glam::{Vec2, Vec3A};

pub use anisotropic::AnisotropicGgx;
pub use conductor::Conductor;
pub use conversion::{Directions, MIXED_ALPHA, SMOOTH_ALPHA};
pub use dielectric::Dielectric;
pub use facets::Facets;
pub use glossy::Glossy;
pub use lambert::Lambert;
pub use layered::{Coat, Layered};
pub use metallic_roughness::{Anisotropy, MetallicRoughness, Stretch};
pub use mirror::Mirror;
pub use mix::{Lobe, Mix};
pub use narrow::{Microfacet, NarrowLobe};
pub use rough_dielectric::{RoughDielectric, RoughGlass};
pub use rough_interface::RoughInterface;
pub use rough_thin::RoughThin;
pub use sheen::Sheen;
pub use thin::{Thin, slab_reflectance};
pub use varying::Varying;

/// Value of a BSDF for two directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// [`Bsdf::eval`].
    pub value: Rgb,
    /// [`Bsdf::pdf`] of the direction to the eye, given that to the light.
    pub pdf_to_eye: f32,
    /// [`Bsdf::pdf`] of the direction to the light, given that to the eye.
    pub pdf_to_light: f32,
}

impl Evaluation {
    /// No light goes this way, and none is sampled.
    pub const NOTHING: Self = Self { value: Rgb::ZERO, pdf_to_eye: 0.0, pdf_to_light: 0.0 };
}

/// Whether an event of probability `p` happens at the uniform number `u`, and a uniform number for what follows.
#[inline]
fn choose(u: f32, p: f32) -> (bool, f32) {
    // Below 1 also after rounding.
    let rest = |u: f32, p: f32| (u / p).min(1.0 - f32::EPSILON);
    if u < p { (true, rest(u, p)) } else { (false, rest(u - p, 1.0 - p)) }
}

/// One surface's scattering function.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Bsdf {
    /// Reflects nothing.
    Black,
    /// Ideal diffuse reflection from both sides.
    Lambert(Lambert),
    /// Perfect mirror from both sides; delta.
    Mirror(Mirror),
    /// Smooth interface to a medium on the back side; delta.
    Dielectric(Dielectric),
    /// Smooth thin transparent wall; delta.
    Thin(Thin),
    /// Rough metal from both sides.
    Conductor(Conductor),
    /// Dielectric coat over a diffuse base, from both sides.
    Glossy(Glossy),
    /// Rough interface to a medium on the back side.
    RoughDielectric(RoughDielectric),
    /// Rough thin transparent wall.
    RoughThin(RoughThin),
    /// Blend of lobes that are not delta.
    Mix(Mix),
    /// A clear coat and fibres over a blend.
    Layered(Layered),
}

impl Bsdf {
    /// Whether it scatters into discrete directions only.
    #[inline]
    pub fn is_delta(&self) -> bool {
        matches!(self, Self::Mirror(_) | Self::Dielectric(_) | Self::Thin(_))
    }

    /// Whether light passes through it.
    pub fn is_transmissive(&self) -> bool {
        match self {
            Self::Dielectric(_) | Self::Thin(_) | Self::RoughDielectric(_) | Self::RoughThin(_) => true,
            Self::Mix(mix) => mix.is_transmissive(),
            Self::Layered(layered) => layered.base.is_transmissive(),
            _ => false,
        }
    }

    /// The interface of a solid in place of a thin wall; `None`: there is no thin wall.
    pub fn solid(&self) -> Option<Self> {
        match self {
            &Self::Thin(Thin { ior, tint }) => Some(Self::Dielectric(Dielectric { ior, tint })),
            Self::RoughThin(wall) => Some(match wall.solid() {
                Some(solid) => Self::RoughDielectric(solid),
                None => Self::Dielectric(Dielectric { ior: wall.ior, tint: wall.tint }),
            }),
            Self::Mix(mix) => mix.solid().map(Self::Mix),
            Self::Layered(layered) => {
                let base = layered.base.solid()?;
                Some(Self::Layered(Layered { base, ..*layered }))
            }
            _ => None,
        }
    }

    /// f_s(to_light → to_eye), sr⁻¹; a delta BSDF: the coefficient of δ.
    #[inline]
    pub fn eval(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Rgb {
        match self {
            Self::Black => Rgb::ZERO,
            Self::Lambert(b) => b.eval(n, to_light, to_eye),
            Self::Mirror(b) => b.eval(n, to_light, to_eye),
            Self::Dielectric(b) => b.eval(n, to_light, to_eye),
            Self::Thin(b) => b.eval(n, to_light, to_eye),
            _ => self.evaluate_rough(n, to_light, to_eye).value,
        }
    }

    /// Density per unit solid angle of `sample(n, given, ·)` at `sampled`, sr⁻¹; a delta BSDF: the coefficient of δ.
    #[inline]
    pub fn pdf(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        match self {
            Self::Black => 0.0,
            Self::Lambert(b) => b.pdf(n, given, sampled),
            Self::Mirror(b) => b.pdf(n, given, sampled),
            Self::Dielectric(b) => b.pdf(n, given, sampled),
            Self::Thin(b) => b.pdf(n, given, sampled),
            _ => self.evaluate_rough(n, given, sampled).pdf_to_eye,
        }
    }

    /// Value and densities at once.
    #[inline(always)]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        match self {
            Self::Lambert(b) => b.evaluate(n, to_light, to_eye),
            _ => self.evaluate_apart(n, to_light, to_eye),
        }
    }

    /// Of what is not diffuse.
    #[inline(never)]
    fn evaluate_apart(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        match self {
            Self::Black | Self::Mirror(_) | Self::Dielectric(_) | Self::Thin(_) => Evaluation {
                value: self.eval(n, to_light, to_eye),
                pdf_to_eye: self.pdf(n, to_light, to_eye),
                pdf_to_light: self.pdf(n, to_eye, to_light),
            },
            _ => self.evaluate_rough(n, to_light, to_eye),
        }
    }

    /// Of what is neither delta nor diffuse.
    #[inline(never)]
    fn evaluate_rough(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        match self {
            Self::Conductor(b) => b.evaluate(n, to_light, to_eye),
            Self::Glossy(b) => b.evaluate(n, to_light, to_eye),
            Self::RoughDielectric(b) => b.evaluate(n, to_light, to_eye),
            Self::RoughThin(b) => b.evaluate(n, to_light, to_eye),
            Self::Mix(b) => b.evaluate(n, to_light, to_eye),
            Self::Layered(b) => b.evaluate(n, to_light, to_eye),
            _ => Evaluation::NOTHING,
        }
    }

    /// Draws a direction; `None`: absorbed. `u` are three uniform numbers in [0, 1).
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        match self {
            Self::Black => None,
            Self::Lambert(b) => Some(b.sample(n, given, Vec2::new(u[0], u[1]))),
            Self::Mirror(b) => b.delta_direction(n, given, false),
            Self::Dielectric(b) => b.sample(n, given, u),
            Self::Thin(b) => b.sample(n, given, u),
            Self::Conductor(b) => b.sample(n, given, u),
            Self::Glossy(b) => b.sample(n, given, u),
            Self::RoughDielectric(b) => b.sample(n, given, u),
            Self::RoughThin(b) => b.sample(n, given, u),
            Self::Mix(b) => b.sample(n, given, u),
            Self::Layered(b) => b.sample(n, given, u),
        }
    }

    /// P, dimensionless, of the discrete event (reflection, transmission) that turns `given` into `sampled`, known from
    /// the sides that they are on; 0 for a BSDF that is not delta.
    #[inline]
    pub fn event_probability(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f32 {
        match self {
            Self::Mirror(b) => b.event_probability(n, given, sampled),
            Self::Dielectric(b) => b.event_probability(n, given, sampled),
            Self::Thin(b) => b.event_probability(n, given, sampled),
            _ => 0.0,
        }
    }

    /// The direction that a delta BSDF joins to `given` by reflection or by transmission; `None`: there is none.
    #[inline]
    pub fn delta_direction(&self, n: Vec3A, given: Vec3A, transmit: bool) -> Option<Vec3A> {
        match self {
            Self::Mirror(b) => b.delta_direction(n, given, transmit),
            Self::Dielectric(b) => b.delta_direction(n, given, transmit),
            Self::Thin(b) => b.delta_direction(n, given, transmit),
            _ => None,
        }
    }
}
