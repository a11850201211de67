//! Rotations as files hold them.

use glam::DQuat;

/// A rotation of any length, as a unit quaternion.
pub(super) fn rotation(q: [f32; 4]) -> DQuat {
    let q = DQuat::from_array(q.map(f64::from));
    let length = q.length();
    if length > 0.0 && length.is_finite() { q / length } else { DQuat::IDENTITY }
}
