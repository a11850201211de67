//! Cameras for files that bring none.

use glam::{DVec3, Vec3};
use mlt_core::transport::scene::{CameraPose, Lens, Prototype, SceneDescription};

/// A camera at `from` that looks at `to` with +y up; `vertical_fov` in radians.
///
/// Where the two points coincide it looks along -z, and where +y is the line of sight, -z is up.
pub fn camera_look_at(from: DVec3, to: DVec3, vertical_fov: f32) -> CameraPose {
    let forward = (to - from).normalize_or(DVec3::NEG_Z);
    let right = forward.cross(DVec3::Y).normalize_or(DVec3::X);
    CameraPose {
        name: "look-at".to_owned(),
        position: from,
        forward: forward.as_vec3().normalize_or(Vec3::NEG_Z),
        up: right.cross(forward).as_vec3().normalize_or(Vec3::Y),
        lens: Lens::Pinhole { vertical_fov },
        aspect_ratio: None,
    }
}

/// A camera in front of (+z) and a little above the box [min, max] that takes it in whole.
///
/// With r half of the box's diagonal and φ the vertical opening angle, the distance to its centre is r / sin(φ/2):
/// the bounding sphere touches the image's upper and lower edge. An image taller than wide cuts its sides.
pub fn camera_framing(bounds: [DVec3; 2]) -> CameraPose {
    let vertical_fov = 40f32.to_radians();
    let centre = 0.5 * (bounds[0] + bounds[1]);
    let radius = 0.5 * bounds[0].distance(bounds[1]);
    let radius = if radius > 0.0 && radius.is_finite() { radius } else { 1.0 };
    let distance = radius / libm::sin(f64::from(vertical_fov / 2.0));
    let from = centre + distance * DVec3::new(0.0, 0.3, 1.0).normalize();
    CameraPose { name: "framing".to_owned(), ..camera_look_at(from, centre, vertical_fov) }
}

/// The axis-parallel box [min, max] around all triangles; `None`: there are none.
pub fn bounds(scene: &SceneDescription) -> Option<[DVec3; 2]> {
    let own = || scene.meshes.iter().flat_map(|m| m.positions.iter().copied());
    let points = || own().chain(scene.prototypes.iter().flat_map(Prototype::corners));
    Some([points().reduce(DVec3::min)?, points().reduce(DVec3::max)?])
}
