//! Lights of a scene, counted.

use std::fmt;

use mlt_core::transport::luminance;
use mlt_core::transport::scene::{Lights, Material, Punctual, SceneDescription};
use serde::Serialize;

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
    /// Of a scene, as its file says it and as it is rendered.
    pub(super) fn of(scene: &SceneDescription, lights: &Lights) -> Self {
        let lit = || scene.punctual.iter().filter(|light| luminance(light.emission) > 0.0);
        let count = |is: fn(&Punctual) -> bool| lit().filter(|light| is(&light.kind)).count();
        let environment = scene.environment.as_ref().is_some_and(|around| around.is_lit());
        let shows = |index: usize| scene.all_meshes().any(|mesh| mesh.material as usize == index);
        let is_unused = |(index, material): (usize, &Material)| {
            material.emission.max_element() > 0.0 && (material.opacity == 0.0 || !shows(index))
        };
        Self {
            surfaces: lights.lights.len() - lit().count() - usize::from(environment),
            points: count(|kind| matches!(kind, Punctual::Point { .. })),
            spots: count(|kind| matches!(kind, Punctual::Spot { .. })),
            suns: count(|kind| matches!(kind, Punctual::Directional { .. })),
            environment,
            dark: scene.punctual.len() - lit().count(),
            unused: scene.materials.iter().enumerate().filter(|&pair| is_unused(pair)).count(),
        }
    }
}

impl fmt::Display for LightCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { surfaces, points, spots, suns, environment, dark, unused } = *self;
        let counted = [(surfaces, "glowing surfaces"), (points, "points"), (spots, "spots"), (suns, "suns")];
        let counted =
            counted.into_iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}"));
        let around = environment.then(|| "light from all around".to_owned());
        writeln!(f, "  counted: {}", counted.chain(around).collect::<Vec<_>>().join(", "))?;
        let ignored = [(dark, "lights of no intensity"), (unused, "glowing materials that nothing visible has")];
        let ignored =
            ignored.into_iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}"));
        match ignored.collect::<Vec<_>>() {
            list if list.is_empty() => Ok(()),
            list => writeln!(f, "  ignored: {}", list.join(", ")),
        }
    }
}
