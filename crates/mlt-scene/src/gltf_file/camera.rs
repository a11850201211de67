//! glTF's cameras.

use super::graph::{Placed, place};
use crate::text;
use glam::{DMat4, DVec3};
use gltf::{Camera, Node, camera::Projection};
use mlt_core::transport::scene::{CameraPose, Lens};
use serde_json::{Map, Value};
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
        warnings.push(format!("the scene that is shown has no camera; `{name}`, which stands outside of it, is taken; --camera chooses another"));
    }
    cameras.extend(outside);
    cameras
}

/// The camera at a node; `None`, with a warning, where it is none.
fn pose(camera: &Camera, node: &Node, to_world: &DMat4, warnings: &mut Vec<String>) -> Option<CameraPose> {
    let place = place(node);
    let position = to_world.transform_point3(DVec3::ZERO);
    let forward = to_world.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
    let up = to_world.transform_vector3(DVec3::Y);
    let up = (up - up.dot(forward) * forward).normalize_or_zero();
    let stands = position.is_finite() && forward != DVec3::ZERO && up != DVec3::ZERO;
    let seeing = lens(camera, node);
    let Some((lens, aspect_ratio)) = seeing.filter(|_| stands) else {
        warnings.push(format!(
            "{place}: the camera's transform, field of view or size is degenerate; it is left out, and the view is another: mend \
             it, or choose a view by --camera-from and --camera-to"
        ));
        return None;
    };
    if to_world.determinant() < 0.0 {
        warnings.push(format!(
            "{place}: the camera's mirroring transform is not supported; the image is not mirrored: give the \
             camera a positive scale (Blender: Object > Apply > Scale)"
        ));
    }
    Some(CameraPose {
        name: camera.name().or(node.name()).map_or_else(|| format!("camera {}", camera.index()), str::to_owned),
        position,
        forward: forward.as_vec3().normalize(),
        up: up.as_vec3().normalize(),
        lens,
        aspect_ratio: aspect_ratio.filter(|ratio| ratio.is_finite() && *ratio > 0.0),
    })
}

/// The lens and the aspect ratio; `None` where they are no camera's.
fn lens(camera: &Camera, node: &Node) -> Option<(Lens, Option<f32>)> {
    match camera.projection() {
        Projection::Perspective(view) => {
            let vertical_fov = view.yfov();
            let lens = disc(camera, node, view.aspect_ratio(), vertical_fov);
            let seen = vertical_fov > 0.0 && vertical_fov < PI;
            seen.then_some((lens.unwrap_or(Lens::Pinhole { vertical_fov }), view.aspect_ratio()))
        }
        Projection::Orthographic(view) => {
            // Some programs write a negative size to mirror the image.
            let [width, height] = [view.xmag(), view.ymag()].map(f32::abs);
            let seen = width > 0.0 && height > 0.0 && height.is_finite();
            seen.then_some((Lens::Orthographic { height: 2.0 * f64::from(height) }, Some(width / height)))
        }
    }
}

/// The lens that Blender's own names of a camera's properties describe, written as custom properties of the camera or of its node:
/// `aperture_fstop` and `focus_distance`, and as far as known `lens` and `sensor_width` in mm; in an object `dof`, or by themselves.
///
/// Focal length f = w / (2 tan(φ/2)), for a sensor of width w, 36 mm if not given, that sees φ along the image's longer side;
/// radius f / (2 N). The unit of glTF is the metre.
fn disc(camera: &Camera, node: &Node, aspect: Option<f32>, vertical_fov: f32) -> Option<Lens> {
    let extras = [camera.extras(), node.extras()].map(|extras| {
        let value: Value = serde_json::from_str(extras.as_ref()?.get()).ok()?;
        value.as_object().cloned()
    });
    let extras = extras.into_iter().flatten().find(|extras| number(extras, "aperture_fstop").is_some())?;
    let used = |map: &Map<String, Value>| map.get("use_dof").is_none_or(|used| used.as_bool() != Some(false));
    let dof = extras.get("dof").and_then(Value::as_object);
    let [f_number, focus] = ["aperture_fstop", "focus_distance"].map(|name| number(&extras, name));
    let sensor = number(&extras, "sensor_width").unwrap_or(36.0);
    let longer = f64::from(aspect.unwrap_or(1.0)).max(1.0) * libm::tan(0.5 * f64::from(vertical_fov));
    let focal = number(&extras, "lens").unwrap_or(0.5 * sensor / longer);
    let (radius, focus) = (0.5e-3 * focal / f_number?, focus?);
    (used(&extras) && dof.is_none_or(used)).then_some(Lens::Thin { vertical_fov, radius, focus })
}

/// A positive number, in an object or in its `dof`.
fn number(extras: &Map<String, Value>, name: &str) -> Option<f64> {
    let inner = extras.get("dof").and_then(|dof| dof.get(name));
    inner.or_else(|| extras.get(name))?.as_f64().filter(|&number| number > 0.0 && number < 1e9)
}
