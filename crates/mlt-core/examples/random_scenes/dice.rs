//! Random choices.

use mlt_core::engine::{Generator, Purpose, generator, uniform};
use mlt_core::glam::{DVec3, Vec3};

/// Random numbers that decide a room.
pub(crate) struct Dice(Generator);

impl Dice {
    pub(crate) fn of(room: u64) -> Self {
        Self(generator(room, Purpose::Image, 0, 0, 0))
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * uniform(&mut self.0)
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        uniform(&mut self.0) < probability
    }

    /// 0 to `most`.
    pub(crate) fn up_to(&mut self, most: usize) -> usize {
        (uniform(&mut self.0) * (most + 1) as f64) as usize
    }

    pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.up_to(from.len() - 1)]
    }

    /// A power of ten.
    pub(crate) fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        libm::exp10(self.between(low, high))
    }

    /// A point of the cube of this half side.
    pub(crate) fn point(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.between(-half, half), self.between(-half, half), self.between(-half, half))
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let point = self.point(1.0);
            if (0.01..1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }

    pub(crate) fn colour(&mut self, low: f64, high: f64) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.between(low, high) as f32))
    }
}
