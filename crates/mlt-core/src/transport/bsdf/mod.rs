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

mod dielectric;
pub mod fresnel;
mod lambert;
mod mirror;
#[cfg(test)]
mod tests;
mod thin;

use super::Rgb;
use glam::Vec3;

pub use dielectric::Dielectric;
pub use lambert::Lambert;
pub use mirror::Mirror;
pub use thin::{Thin, slab_reflectance};

/// One surface's scattering function.
#[derive(Clone, Debug)]
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
}

impl Bsdf {
    /// Whether it scatters into discrete directions only.
    #[inline]
    pub fn is_delta(&self) -> bool {
        matches!(self, Self::Mirror(_) | Self::Dielectric(_) | Self::Thin(_))
    }

    /// f_s(to_light → to_eye), sr⁻¹; a delta BSDF: the coefficient of δ.
    #[inline]
    pub fn eval(&self, n: Vec3, to_light: Vec3, to_eye: Vec3) -> Rgb {
        match self {
            Self::Black => Rgb::ZERO,
            Self::Lambert(b) => b.eval(n, to_light, to_eye),
            Self::Mirror(b) => b.eval(n, to_light, to_eye),
            Self::Dielectric(b) => b.eval(n, to_light, to_eye),
            Self::Thin(b) => b.eval(n, to_light, to_eye),
        }
    }

    /// Density per unit solid angle of `sample(n, given, ·)` at `sampled`, sr⁻¹; a delta BSDF: the coefficient of δ.
    #[inline]
    pub fn pdf(&self, n: Vec3, given: Vec3, sampled: Vec3) -> f32 {
        match self {
            Self::Black => 0.0,
            Self::Lambert(b) => b.pdf(n, given, sampled),
            Self::Mirror(b) => b.pdf(n, given, sampled),
            Self::Dielectric(b) => b.pdf(n, given, sampled),
            Self::Thin(b) => b.pdf(n, given, sampled),
        }
    }

    /// Draws a direction; `None`: absorbed. `u` are three uniform numbers in [0, 1).
    #[inline]
    pub fn sample(&self, n: Vec3, given: Vec3, u: [f32; 3]) -> Option<Vec3> {
        match self {
            Self::Black => None,
            Self::Lambert(b) => b.sample(n, given, u),
            Self::Mirror(b) => b.delta_direction(n, given, false),
            Self::Dielectric(b) => b.sample(n, given, u),
            Self::Thin(b) => b.sample(n, given, u),
        }
    }

    /// P, dimensionless, of the discrete event (reflection, transmission) that turns `given` into `sampled`, known from
    /// the sides that they are on; 0 for a BSDF that is not delta.
    #[inline]
    pub fn event_probability(&self, n: Vec3, given: Vec3, sampled: Vec3) -> f32 {
        match self {
            Self::Mirror(b) => b.event_probability(n, given, sampled),
            Self::Dielectric(b) => b.event_probability(n, given, sampled),
            Self::Thin(b) => b.event_probability(n, given, sampled),
            _ => 0.0,
        }
    }

    /// The direction that a delta BSDF joins to `given` by reflection or by transmission; `None`: there is none.
    #[inline]
    pub fn delta_direction(&self, n: Vec3, given: Vec3, transmit: bool) -> Option<Vec3> {
        match self {
            Self::Mirror(b) => b.delta_direction(n, given, transmit),
            Self::Dielectric(b) => b.delta_direction(n, given, transmit),
            Self::Thin(b) => b.delta_direction(n, given, transmit),
            _ => None,
        }
    }
}
