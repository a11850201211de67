//! glTF's cameras.

use super::graph::{Placed, place};
use crate::text;
use glam::{DMat4, DVec3};
use gltf::{Camera, Node, camera::Projection};
use mlt_core::transport::scene::CameraPose;
use std::f32::consts::PI;

/// The cameras of the scene that is shown, and behind them those of the file outside of it.
pub(super) fn poses(shown: &[Placed], others: &[Placed], warnings: &mut Vec<String>) -> Vec<CameraPose> {
    let among = |nodes: &[Placed], warnings: &mut Vec<String>| -> Vec<_> {
        nodes.iter().filter_map(|(node, to_world)| pose(&node.camera()?, node, to_world, warnings)).collect()
    };
    let mut cameras = among(shown, warnings);
    let outside = among(others, &mut Vec::new());
    if let (true, Some(taken)) = (cameras.is_empty(), outside.first()) {
        let name = text::shown(&taken.name);
        warnings.push(format!("the scene that is shown has no camera; `{name}`, which stands outside of it, is taken"));
    }
    cameras.extend(outside);
    cameras
}

/// The pinhole camera at a node; `None`, with a warning, where there is none like it.
fn pose(camera: &Camera, node: &Node, to_world: &DMat4, warnings: &mut Vec<String>) -> Option<CameraPose> {
    let place = place(node);
    let Projection::Perspective(lens) = camera.projection() else {
        warnings.push(format!(
            "{place}: orthographic cameras are not supported; this one is left out, and the view is another"
        ));
        return None;
    };
    let position = to_world.transform_point3(DVec3::ZERO);
    let forward = to_world.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
    let up = to_world.transform_vector3(DVec3::Y);
    let up = (up - up.dot(forward) * forward).normalize_or_zero();
    let stands = position.is_finite() && forward != DVec3::ZERO && up != DVec3::ZERO;
    if !(stands && lens.yfov() > 0.0 && lens.yfov() < PI) {
        warnings.push(format!(
            "{place}: the camera's transform or field of view is degenerate; it is left out, and the view is another"
        ));
        return None;
    }
    if to_world.determinant() < 0.0 {
        warnings.push(format!("{place}: the camera's mirroring transform is not supported; the image is not mirrored"));
    }
    Some(CameraPose {
        name: camera.name().or(node.name()).map_or_else(|| format!("camera {}", camera.index()), str::to_owned),
        position,
        forward: forward.as_vec3().normalize(),
        up: up.as_vec3().normalize(),
        vertical_fov: lens.yfov(),
        aspect_ratio: lens.aspect_ratio().filter(|ratio| ratio.is_finite() && *ratio > 0.0),
    })
}
