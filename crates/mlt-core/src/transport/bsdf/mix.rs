//! Blend of lobes.

use super::anisotropic::AnisotropicGgx;
use super::{Bsdf, Conductor, Evaluation, Glossy, Lambert, RoughDielectric, RoughThin, choose};
use glam::{Vec2, Vec3A};

/// A part of a surface's scattering that is not delta.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Lobe {
    /// Ideal diffuse reflection.
    Lambert(Lambert),
    /// Rough metal.
    Conductor(Conductor),
    /// Dielectric coat over a diffuse base.
    Glossy(Glossy),
    /// Metal that is rougher along one direction than across it.
    BrushedMetal(Conductor<AnisotropicGgx>),
    /// The same of a coat over a diffuse base.
    BrushedCoat(Glossy<AnisotropicGgx>),
    /// Rough interface to a medium on the back side.
    RoughDielectric(RoughDielectric),
    /// Rough thin transparent wall.
    RoughThin(RoughThin),
}

impl Lobe {
    #[inline]
    fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        match self {
            Self::Lambert(b) => b.evaluate(n, to_light, to_eye),
            Self::Conductor(b) => b.evaluate(n, to_light, to_eye),
            Self::Glossy(b) => b.evaluate(n, to_light, to_eye),
            Self::BrushedMetal(b) => b.evaluate(n, to_light, to_eye),
            Self::BrushedCoat(b) => b.evaluate(n, to_light, to_eye),
            Self::RoughDielectric(b) => b.evaluate(n, to_light, to_eye),
            Self::RoughThin(b) => b.evaluate(n, to_light, to_eye),
        }
    }

    #[inline]
    fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        match self {
            Self::Lambert(b) => Some(b.sample(n, given, Vec2::new(u[0], u[1]))),
            Self::Conductor(b) => b.sample(n, given, u),
            Self::Glossy(b) => b.sample(n, given, u),
            Self::BrushedMetal(b) => b.sample(n, given, u),
            Self::BrushedCoat(b) => b.sample(n, given, u),
            Self::RoughDielectric(b) => b.sample(n, given, u),
            Self::RoughThin(b) => b.sample(n, given, u),
        }
    }

    /// Whether light passes through it.
    pub fn is_transmissive(&self) -> bool {
        matches!(self, Self::RoughDielectric(_) | Self::RoughThin(_))
    }
}

impl From<Lobe> for Bsdf {
    fn from(lobe: Lobe) -> Self {
        match lobe {
            Lobe::Lambert(b) => Self::Lambert(b),
            Lobe::Conductor(b) => Self::Conductor(b),
            Lobe::Glossy(b) => Self::Glossy(b),
            Lobe::RoughDielectric(b) => Self::RoughDielectric(b),
            Lobe::RoughThin(b) => Self::RoughThin(b),
            Lobe::BrushedMetal(_) | Lobe::BrushedCoat(_) => {
                Self::Mix(Mix { lobes: [(1.0, Some(lobe)), (0.0, None), (0.0, None)] })
            }
        }
    }
}

/// f_s = Σ wᵢ fᵢ.
#[derive(Clone, Copy, Debug)]
pub struct Mix {
    /// Weights, which sum to 1 or less, and lobes; what has no lobe is black.
    pub lobes: [(f32, Option<Lobe>); 3],
}

impl Mix {
    /// Σ wᵢ fᵢ, and densities alike.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let mut sum = Evaluation::NOTHING;
        for (weight, lobe) in &self.lobes {
            if let Some(lobe) = lobe {
                let found = lobe.evaluate(n, to_light, to_eye);
                sum.value += *weight * found.value;
                sum.pdf_to_eye += weight * found.pdf_to_eye;
                sum.pdf_to_light += weight * found.pdf_to_light;
            }
        }
        sum
    }

    /// Samples lobe i with probability wᵢ; `None`: absorbed.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Option<Vec3A> {
        let (mut rest, mut left) = (u[2], 1.0);
        for (weight, lobe) in &self.lobes {
            let (taken, unused) = choose(rest, (weight / left).min(1.0));
            if taken {
                return lobe.as_ref()?.sample(n, given, [u[0], u[1], unused]);
            }
            (rest, left) = (unused, left - weight);
        }
        None
    }

    /// With solids in place of thin walls; `None`: there is no thin wall that bends light.
    pub fn solid(&self) -> Option<Self> {
        let mut solid = *self;
        let mut found = false;
        for (_, lobe) in &mut solid.lobes {
            if let Some(Lobe::RoughThin(wall)) = lobe
                && let Some(interface) = wall.solid()
            {
                (*lobe, found) = (Some(Lobe::RoughDielectric(interface)), true);
            }
        }
        found.then_some(solid)
    }

    /// Whether light passes through it.
    pub fn is_transmissive(&self) -> bool {
        self.lobes.iter().filter_map(|(_, lobe)| lobe.as_ref()).any(Lobe::is_transmissive)
    }
}
