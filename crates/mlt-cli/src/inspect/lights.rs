//! Lights of a scene, counted.

use std::fmt;

use mlt_core::transport::luminance;
use mlt_core::transport::scene::{Lights, Material, Punctual, SceneDescription};
use serde::Serialize;

use super::text::counted;

/// Lights by kind, and those that give no light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LightCounts {
    /// Pieces of surfaces that glow.
    pub surfaces: usize,
    /// Points.
    pub points: usize,
    /// Spots.
    pub spots: usize,
    /// Directions.
    pub suns: usize,
    /// Whether light comes from all around.
    pub environment: bool,
    /// Lights of the file whose intensity or colour is zero.
    pub dark: usize,
    /// Materials that glow, on no surface or on an invisible one.
    pub unused: usize,
}

impl LightCounts {
    /// Of a scene as its file says it, without its surfaces.
    pub(super) fn of(scene: &SceneDescription) -> Self {
        let lit = || scene.punctual.iter().filter(|light| luminance(light.emission) > 0.0);
        let count = |is: fn(&Punctual) -> bool| lit().filter(|light| is(&light.kind)).count();
        let environment = scene.environment.as_ref().is_some_and(|around| around.is_lit());
        let shows = |index: usize| scene.all_meshes().any(|mesh| mesh.material as usize == index);
        let is_unused = |(index, material): (usize, &Material)| {
            material.emission.max_element() > 0.0 && (material.opacity == 0.0 || !shows(index))
        };
        Self {
            surfaces: 0,
            points: count(|kind| matches!(kind, Punctual::Point { .. })),
            spots: count(|kind| matches!(kind, Punctual::Spot { .. })),
            suns: count(|kind| matches!(kind, Punctual::Directional { .. })),
            environment,
            dark: scene.punctual.len() - lit().count(),
            unused: scene.materials.iter().enumerate().filter(|&pair| is_unused(pair)).count(),
        }
    }

    /// With the surfaces among all lights of the scene that was made.
    pub(super) fn among(self, lights: &Lights) -> Self {
        let others = self.points + self.spots + self.suns + usize::from(self.environment);
        Self { surfaces: lights.lights.len().saturating_sub(others), ..self }
    }
}

impl fmt::Display for LightCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { surfaces, points, spots, suns, environment, dark, unused } = *self;
        let listed = |kinds: &[(usize, &str)]| -> Vec<String> {
            kinds.iter().filter(|(count, _)| *count > 0).map(|&(count, name)| counted(count, name)).collect()
        };
        let mut lit = listed(&[(surfaces, "glowing surface"), (points, "point"), (spots, "spot"), (suns, "sun")]);
        lit.extend(environment.then(|| "light from all around".to_owned()));
        writeln!(f, "  counted: {}", lit.join(", "))?;
        let ignored = listed(&[(dark, "light"), (unused, "glowing material")]);
        let why = "of no intensity, or on nothing that is visible";
        if ignored.is_empty() { Ok(()) } else { writeln!(f, "  ignored: {}, {why}", ignored.join(" and ")) }
    }
}
