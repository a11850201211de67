//! glTF's punctual lights (KHR_lights_punctual).

use super::graph::{Placed, place};
use crate::{
    LightUnits, SceneError,
    gallery::{Shape, ball},
    geometry::GeometrySize,
    source::Source,
    text::shown,
};
use glam::{DMat4, DVec3};
use gltf::{
    Document, Node,
    json::Extras,
    khr_lights_punctual::{Kind, Light},
};
use mlt_core::transport::Rgb;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::{Cone, Material, Punctual, PunctualLight, SceneDescription};
use serde_json::Value;
use std::f32::consts::{FRAC_PI_2, PI};

/// Lumens that a watt of radiant flux stands for in files of Blender.
const LUMENS_PER_WATT: f32 = 683.0;

/// How finely a ball is cut: into 8 · 4³ triangles.
const LEVELS: u32 = 3;

/// A light, and the radius of the ball that it is, if it has an extent.
pub(super) struct Found {
    light: PunctualLight,
    radius: Option<f64>,
}

/// The lights at some nodes, in the units that were chosen, or that suit the program that wrote the file.
pub(super) fn lights(
    document: &Document,
    nodes: &[Placed],
    units: Option<LightUnits>,
    warnings: &mut Vec<String>,
) -> Vec<Found> {
    let generator = document.as_json().asset.generator.as_deref().unwrap_or_default();
    let units = units.unwrap_or_else(|| usual(generator));
    let found = |(node, to_world): &Placed, warnings: &mut Vec<String>| {
        let source = node.light()?;
        let radius = extent("shadow_soft_size", &source, node);
        Some(Found { light: light(&source, node, to_world, units, warnings)?, radius })
    };
    nodes.iter().filter_map(|placed| found(placed, warnings)).collect()
}

/// The units that suit the program that wrote a file. Blender's exporter wrote watts as they are before its version 3.4.
fn usual(generator: &str) -> LightUnits {
    if !generator.contains("Blender") {
        return LightUnits::Photometric;
    }
    let version = generator.split_once("I/O v").and_then(|(_, version)| {
        let mut numbers = version.split('.').map(|number| number.parse().ok());
        Some([numbers.next()??, numbers.next()??])
    });
    if version.is_some_and(|version: [u32; 2]| version < [3, 4]) { LightUnits::Raw } else { LightUnits::Blender }
}

/// The extent that Blender's own name for it gives, written as a custom property of the light or of its node.
fn extent(name: &str, light: &Light, node: &Node) -> Option<f64> {
    let number = |extras: &Extras| -> Option<f64> {
        let value: Value = serde_json::from_str(extras.as_ref()?.get()).ok()?;
        value.get(name)?.as_f64().filter(|&extent| extent > 0.0 && extent < 1e9)
    };
    number(light.extras()).or_else(|| number(node.extras()))
}

/// Adds lights to a scene; a point or a spot with a radius r as a ball, of radiance 4 I/A, so that its cross section A/4 sends the intensity I;
/// a spot's emits into its cone alone.
pub(super) fn add(found: Vec<Found>, source: &Source, scene: &mut SceneDescription) -> Result<(), SceneError> {
    for Found { light, radius } in found {
        let (position, cone, radius) = match (light.kind, radius) {
            (Punctual::Point { position }, Some(radius)) => (position, None, radius),
            (Punctual::Spot { position, axis, cone }, Some(radius)) => (position, Some(Cone::new(axis, cone)), radius),
            _ => {
                scene.punctual.push(light);
                continue;
            }
        };
        let Shape { positions, triangles, .. } = ball(position, radius, LEVELS);
        let mut size = GeometrySize::default();
        size.add(triangles.len(), true, false);
        size.take(source)?;
        let corners = triangles.iter().map(|t| t.map(|i| positions[i as usize]));
        let area: f64 = corners.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
        let emission = light.emission * (4.0 / area) as f32;
        let (name, material) = (light.name, scene.materials.len() as u32);
        scene.meshes.push(Mesh { name: name.clone(), positions, triangles, material, ..Mesh::default() });
        scene.materials.push(Material { name, emission, cone, ..Material::default() });
    }
    Ok(())
}

/// One light; `None`, with a warning, where it is none.
fn light(
    light: &Light,
    node: &Node,
    to_world: &DMat4,
    units: LightUnits,
    warnings: &mut Vec<String>,
) -> Option<PunctualLight> {
    let (position, along) = (to_world.transform_point3(DVec3::ZERO), to_world.transform_vector3(DVec3::NEG_Z));
    let axis = along.normalize_or_zero().as_vec3().normalize_or_zero();
    let kind = match light.kind() {
        Kind::Directional => {
            Punctual::Directional { along: axis, angle: extent("angle", light, node).unwrap_or_default() as f32 }
        }
        Kind::Point => Punctual::Point { position },
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let outer = outer_cone_angle.clamp(0.0, FRAC_PI_2);
            Punctual::Spot { position, axis, cone: [inner_cone_angle.clamp(0.0, outer), outer] }
        }
    };
    let emission = per_unit(units, &kind) * light.intensity() * Rgb::from_array(light.color());
    let directed = matches!(kind, Punctual::Point { .. }) || axis.is_normalized();
    let sound = position.is_finite() && directed && emission.is_finite() && emission.min_element() >= 0.0;
    if !sound {
        warnings.push(format!(
            "{}: the light's transform, colour or intensity is not one that a light can have; it is left out: give it \
             a power of 0 or more and a scale that is not 0",
            place(node)
        ));
        return None;
    }
    let name = light.name().or(node.name()).map_or_else(|| format!("light {}", light.index()), shown);
    Some(PunctualLight { name, emission, kind })
}

/// Radiance × area, or × solid angle, that the number 1 in the file stands for.
fn per_unit(units: LightUnits, kind: &Punctual) -> f32 {
    match (units, kind) {
        (LightUnits::Blender, _) => LUMENS_PER_WATT.recip(),
        (LightUnits::Photometric, _) | (LightUnits::Raw, Punctual::Directional { .. }) => 1.0,
        (LightUnits::Raw, _) => (4.0 * PI).recip(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_the_program_that_wrote_the_file() {
        for (generator, units) in [
            ("Khronos glTF Blender I/O v5.0.21", LightUnits::Blender),
            ("Khronos glTF Blender I/O v3.4.50", LightUnits::Blender),
            ("Khronos glTF Blender I/O v3.3.27", LightUnits::Raw),
            ("Khronos glTF Blender I/O v1.2.75", LightUnits::Raw),
            ("Blender", LightUnits::Blender),
            ("GLTFExporter", LightUnits::Photometric),
            ("", LightUnits::Photometric),
        ] {
            assert_eq!(usual(generator), units, "{generator}");
        }
    }
}
