//! Cones that light goes into.

use crate::transport::geometry::math::{frame, turn, unit};
use glam::{Vec2, Vec3, Vec3A};
use std::f32::consts::TAU;

/// Directions about an axis, and how much of the light along it goes into each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit vector, away from the light.
    pub(super) axis: Vec3A,
    /// Cosines of the angles with the axis up to which all, and from which on nothing is emitted.
    cosines: [f32; 2],
}

impl Cone {
    /// All directions.
    pub(super) const EVERYWHERE: Self = Self { axis: Vec3A::Z, cosines: [-1.0; 2] };

    /// About a unit vector; `angles`: those with it up to which all, and from which on nothing is emitted, radians.
    pub fn new(axis: Vec3, angles: [f32; 2]) -> Self {
        Self { axis: axis.into(), cosines: angles.map(libm::cosf) }
    }

    /// Share of the light along the axis that goes into a direction: ((cosθ − cosθ_o)/(cosθ_i − cosθ_o))², between 0 and 1.
    ///
    /// Source: glTF's extension KHR_lights_punctual.
    pub(super) fn share(&self, direction: Vec3A) -> f32 {
        let [inner, outer] = self.cosines;
        if outer <= -1.0 {
            return 1.0;
        }
        ((self.axis.dot(direction) - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0).powi(2)
    }

    /// ∫ of that share over all directions, sr: 2π ((1 − cosθ_i) + (cosθ_i − cosθ_o)/3).
    pub(super) fn solid_angle(&self) -> f32 {
        let [inner, outer] = self.cosines;
        let rim = (inner - outer).max(if outer <= -1.0 { 0.0 } else { 1e-3 });
        // What is narrower than the rim is cut off by the axis.
        let top = ((1.0 - outer) / rim.max(f32::MIN_POSITIVE)).min(1.0);
        TAU * ((1.0 - outer - rim).max(0.0) + rim * top * top * top / 3.0)
    }

    /// A uniform direction of the cone, from the unit square.
    pub(super) fn direction(&self, u: Vec2) -> Vec3A {
        let cos = 1.0 - u.x * (1.0 - self.cosines[1]);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (s, t) = frame(self.axis);
        let about = turn(u.y);
        unit(sin * (about.x * s + about.y * t) + cos * self.axis)
    }

    /// Its density in the cone, sr⁻¹.
    pub(super) fn pdf(&self) -> f32 {
        1.0 / (TAU * (1.0 - self.cosines[1]))
    }

    /// Angle with the axis from which on nothing is emitted, radians.
    pub(super) fn angle(&self) -> f64 {
        libm::acos(f64::from(self.cosines[1].clamp(-1.0, 1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// By the midpoint rule over the cosine; for equal angles, and for wide ones.
    #[test]
    fn solid_angles_are_integrals_of_shares() {
        for angles in [[0.2f32, 0.5], [0.0, 0.7], [0.4, 0.4], [0.0, 0.0], [1.5, 1.57], [0.0, 3.0]] {
            let cone = Cone::new(Vec3::Z, angles);
            let n = 400_000;
            let share = |i: i32| {
                let cos = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
                f64::from(cone.share(Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos)))
            };
            let sum: f64 = (0..n).map(share).sum::<f64>() * 2.0 / f64::from(n) * f64::from(TAU);
            let found = f64::from(cone.solid_angle());
            assert!((found - sum).abs() < 1e-3 * sum + 1e-6, "{angles:?}: {found} {sum}");
        }
        let all = Cone::EVERYWHERE;
        assert!((all.solid_angle() - 4.0 * PI).abs() < 1e-5 && (all.pdf() * 4.0 * PI - 1.0).abs() < 1e-6);
    }
}
