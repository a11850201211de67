//! glTF's punctual lights (KHR_lights_punctual).

use super::graph::{Placed, place};
use crate::{LightUnits, text::shown};
use glam::{DMat4, DVec3};
use gltf::{Document, Node, khr_lights_punctual::Kind, khr_lights_punctual::Light};
use mlt_core::transport::Rgb;
use mlt_core::transport::scene::{Punctual, PunctualLight};
use std::f32::consts::{FRAC_PI_2, PI};

/// Lumens that a watt of radiant flux stands for in files of Blender.
const LUMENS_PER_WATT: f32 = 683.0;

/// The lights at some nodes, in the units that were chosen, or that suit the program that wrote the file.
pub(super) fn lights(
    document: &Document,
    nodes: &[Placed],
    units: Option<LightUnits>,
    warnings: &mut Vec<String>,
) -> Vec<PunctualLight> {
    let generator = document.as_json().asset.generator.as_deref().unwrap_or_default();
    let usual = if generator.contains("Blender") { LightUnits::Blender } else { LightUnits::Photometric };
    let units = units.unwrap_or(usual);
    nodes.iter().filter_map(|(node, to_world)| light(&node.light()?, node, to_world, units, warnings)).collect()
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
        Kind::Directional => Punctual::Directional { along: axis },
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
            "{}: the light's transform, colour or intensity is not one that a light can have; it is left out",
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
