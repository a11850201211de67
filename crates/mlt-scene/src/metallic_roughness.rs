//! From a file's material parameters to a BSDF.

use mlt_core::transport::{
    Rgb,
    bsdf::{Bsdf, Lambert},
};

/// The parameters of glTF's material model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MetallicRoughness {
    /// Reflectance of the base, or the tint of what passes through it.
    pub base_color: Rgb,
    /// 0: dielectric, 1: metal.
    pub metallic: f32,
    /// √α of the microfacet distribution; 0: smooth.
    pub roughness: f32,
    /// Index of refraction.
    pub ior: f32,
    /// Weight of the dielectric's reflection.
    pub specular: f32,
    /// Colour of the dielectric's reflection at normal incidence.
    pub specular_color: Rgb,
    /// Share of the base that transmits instead of scattering diffusely.
    pub transmission: f32,
    /// The surface is a thin wall, which does not bend light.
    pub thin: bool,
}

impl MetallicRoughness {
    /// A diffuse surface without any reflection above it.
    pub fn lambert(base_color: Rgb) -> Self {
        Self { base_color, metallic: 0.0, specular: 0.0, ..Self::default() }
    }

    /// The scattering function.
    pub fn bsdf(&self) -> Bsdf {
        let black = self.base_color == Rgb::ZERO && self.specular == 0.0;
        if black { Bsdf::Black } else { Bsdf::Lambert(Lambert { reflectance: self.base_color }) }
    }
}

impl Default for MetallicRoughness {
    /// glTF's default values.
    fn default() -> Self {
        Self {
            base_color: Rgb::ONE,
            metallic: 1.0,
            roughness: 1.0,
            ior: 1.5,
            specular: 1.0,
            specular_color: Rgb::ONE,
            transmission: 0.0,
            thin: true,
        }
    }
}

/// Moves a material's parameters into their ranges, with a warning for each that was outside.
pub(crate) struct Range<'a> {
    /// The material's name.
    pub material: &'a str,
    /// Where the warnings go.
    pub warnings: &'a mut Vec<String>,
}

impl Range<'_> {
    /// `value` in [least, most]; what is not a number becomes the least.
    pub fn number(&mut self, what: &str, value: f32, [least, most]: [f32; 2]) -> f32 {
        let taken = if value.is_nan() { least } else { value.clamp(least, most) };
        if taken != value {
            let name = self.material;
            self.warnings.push(format!("material `{name}`: {what} is {value}; {taken} is taken instead"));
        }
        taken
    }

    /// Each component in [0, most].
    pub fn colour(&mut self, what: &str, value: Rgb, most: f32) -> Rgb {
        Rgb::from_array(value.to_array().map(|c| self.number(what, c, [0.0, most])))
    }
}
