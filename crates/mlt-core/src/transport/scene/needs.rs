//! Needs of a scene: the features that it has, so that what it lacks costs nothing.

use super::material::Material;
use crate::transport::geometry::Mesh;

/// Features that a scene has. Branches, mutations and strata that serve nothing else are not set up where it is lacking.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// A surface that scatters into discrete directions only.
    pub specular: bool,
    /// A surface that is not opaque.
    pub veils: bool,
}

impl Needs {
    /// Of the surfaces of a scene; materials that no mesh has do not count.
    pub(super) fn of(meshes: &[Mesh], materials: &[Material]) -> Self {
        let any = |has: fn(&Material) -> bool| meshes.iter().any(|mesh| has(&materials[mesh.material as usize]));
        Self { specular: any(|material| material.bsdf.is_delta()), veils: any(|material| material.opacity < 1.0) }
    }
}
