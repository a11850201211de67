//! Cameras for files that bring none.

use glam::DVec3;
use mlt_core::transport::scene::{CameraPose, Prototype, SceneDescription};

/// Where a camera may stand that takes in a whole scene: in front of it (+z) and a little above, else at its side, else above.
const STANDPOINTS: [DVec3; 3] = [DVec3::new(0.0, 0.3, 1.0), DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, 1.0, 0.3)];

/// A standpoint shows enough of a box if the box looks at least so large from it, over how large it looks from the best.
const ENOUGH: f64 = 1.0 / 3.0;

/// A camera in front of (+z) and a little above the box [min, max] that takes it in whole; beside or above it, where the box is flat and
/// would be seen edge-on.
///
/// With r half of the box's diagonal and φ the vertical opening angle, the distance to its centre is r / sin(φ/2):
/// the bounding sphere touches the image's upper and lower edge. An image taller than wide cuts its sides.
pub fn camera_framing(bounds: [DVec3; 2]) -> CameraPose {
    let vertical_fov = 40f32.to_radians();
    let centre = 0.5 * (bounds[0] + bounds[1]);
    let radius = 0.5 * bounds[0].distance(bounds[1]);
    let radius = if radius > 0.0 && radius.is_finite() { radius } else { 1.0 };
    let distance = radius / libm::sin(f64::from(vertical_fov / 2.0));
    let from = centre + distance * standpoint(bounds[1] - bounds[0]);
    CameraPose { name: "framing".to_owned(), ..CameraPose::look_at(from, centre, vertical_fov) }
}

/// The direction from a box of the sides `size` to its camera: the first of the standpoints that shows enough of it.
///
/// A box looks as large as Σ |d_i| A_i, A_i the area of its faces across axis i.
fn standpoint(size: DVec3) -> DVec3 {
    let faces = DVec3::new(size.y * size.z, size.x * size.z, size.x * size.y);
    let directions = STANDPOINTS.map(DVec3::normalize);
    let looks = |direction: &DVec3| direction.dot(faces);
    let best = directions.iter().map(looks).fold(0.0, f64::max);
    directions.into_iter().find(|direction| looks(direction) >= ENOUGH * best).unwrap_or(directions[0])
}

/// The axis-parallel box [min, max] around all triangles; `None`: there are none.
pub fn bounds(scene: &SceneDescription) -> Option<[DVec3; 2]> {
    let own = || scene.meshes.iter().flat_map(|m| m.positions.iter().copied());
    let points = || own().chain(scene.prototypes.iter().flat_map(Prototype::corners));
    Some([points().reduce(DVec3::min)?, points().reduce(DVec3::max)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Where the camera that takes in a box of these sides stands, seen from its centre.
    fn stands(size: [f64; 3]) -> Vec3 {
        -camera_framing([DVec3::ZERO, size.into()]).forward
    }

    #[test]
    fn flat_things_are_not_seen_edge_on() {
        let front = stands([1.0, 1.0, 1.0]);
        assert!(front.z > 0.9, "{front}");
        // A wall across x, a carpet; a wall across z and a room with a low ceiling are seen from the front.
        assert!(stands([0.0, 2.0, 2.0]).x > 0.9);
        assert!(stands([2.0, 0.01, 2.0]).y > 0.9);
        assert_eq!([[2.0, 2.0, 0.0], [5.0, 1.0, 5.0], [0.0; 3]].map(stands), [front; 3]);
    }

    #[test]
    fn a_line_has_some_camera() {
        assert!(stands([0.0, 0.0, 3.0]).is_finite());
    }
}
