//! Needs of a scene: the features that it has, so that what it lacks costs nothing.

use super::description::SceneDescription;
use super::light::Environment;
use super::material::Material;
use crate::transport::colour::Rgb;

/// Features that a scene has. Branches, mutations and strata that serve nothing else are not set up where it is lacking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// A surface that scatters into discrete directions only.
    pub specular: bool,
    /// That, and a light that rays may meet: paths that nothing but such a ray makes.
    pub met_by_chance: bool,
    /// A surface with a narrow lobe, or whose roughness varies.
    pub narrow: bool,
    /// A surface that is not opaque.
    pub veils: bool,
    /// Light that comes from all around.
    pub environment: bool,
    /// A surface that emits into a cone.
    pub cones: bool,
    /// A solid that absorbs light.
    pub absorbs: bool,
    /// A light without extent.
    pub punctual: bool,
    /// A distant light that is seen as a disc.
    pub suns: bool,
    /// A surface whose parameters vary.
    pub textured: bool,
    /// A surface with a normal map.
    pub normal_maps: bool,
}

impl Needs {
    /// Of a scene; materials that no mesh has do not count.
    pub(super) fn of(description: &SceneDescription) -> Self {
        let SceneDescription { materials, environment, punctual, .. } = description;
        let any =
            |has: fn(&Material) -> bool| description.all_meshes().any(|mesh| has(&materials[mesh.material as usize]));
        let specular = any(|material| material.bsdf.is_delta());
        let environment = environment.as_ref().is_some_and(Environment::is_lit);
        let suns = punctual.iter().any(|light| light.is_lit() && light.has_extent());
        let lamps = any(|material| material.emission != Rgb::ZERO);
        Self {
            specular,
            met_by_chance: specular && (lamps || environment || suns),
            narrow: any(Material::may_be_narrow),
            veils: any(Material::is_veil),
            environment,
            cones: any(|material| material.cone.is_some()),
            absorbs: any(|material| material.absorption != Rgb::ZERO),
            punctual: punctual.iter().any(|light| light.is_lit() && !light.has_extent()),
            suns,
            textured: any(|material| material.textured.is_some()),
            normal_maps: any(|material| material.textured.as_ref().is_some_and(|t| t.maps.normal.is_some())),
        }
    }

    /// Whether there is a light that is no surface of the scene.
    pub(super) fn light_without_surface(&self) -> bool {
        self.environment || self.punctual || self.suns
    }
}
