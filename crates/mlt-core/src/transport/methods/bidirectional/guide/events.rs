//! Reflections and refractions at the specular surfaces that a ray meets first.

use crate::transport::paths::PathVertex;
use crate::transport::scene::{Resolved, View};
use glam::Vec3A;

/// Reflections and refractions from the eye on, until a surface that is not specular, or a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::transport::methods::bidirectional) struct Events {
    count: u32,
    /// One bit for each, the first one's the lowest: whether it is a refraction.
    refractions: u32,
}

impl Events {
    /// Most of them.
    pub(super) const MOST: usize = 16;

    /// One more; `None` if there are too many.
    pub(super) fn with(self, refraction: bool) -> Option<Self> {
        let refractions = self.refractions | u32::from(refraction) << self.count;
        (self.len() < Self::MOST).then_some(Self { count: self.count + 1, refractions })
    }

    pub(in crate::transport::methods::bidirectional) fn len(self) -> usize {
        self.count as usize
    }

    /// Whether the one of a number is a refraction; `None` after the last.
    pub(in crate::transport::methods::bidirectional) fn get(self, number: usize) -> Option<bool> {
        (number < self.len()).then_some((self.refractions >> number) & 1 == 1)
    }

    /// Those of a path, and the probability of these choices; `None` if there are too many.
    pub(super) fn of(vertices: &[PathVertex], view: &View) -> Option<(Self, f64)> {
        let (mut events, mut probability) = (Self::default(), 1.0);
        for i in (1..vertices.len() - 1).rev() {
            let x = &vertices[i];
            if !x.vertex.delta {
                break;
            }
            let to_light = -vertices[i - 1].to_eye;
            events = events.with(is_refraction(x, to_light))?;
            let mut room = Resolved::default();
            let surface = view.scene.surface(&x.vertex, &mut room);
            probability *= f64::from(surface.event_probability(x.to_eye, to_light));
        }
        Some((events, probability))
    }
}

/// Whether the light that a specular vertex joins to `to_eye` passes it.
pub(super) fn is_refraction(x: &PathVertex, to_light: Vec3A) -> bool {
    let normal = x.vertex.shading_normal;
    normal.dot(x.to_eye) * normal.dot(to_light) < 0.0
}
