//! The law by which perturbations draw how far they go.

use crate::transport::geometry::math::on_circle;
use glam::Vec2;
use rand_pcg::rand_core::Rng;

/// Lengths between two: each octave is as likely as any other, and within one all lengths are. That is 1/r in steps of an octave. The
/// law does not depend on the state, so it cancels in T(y→x)/T(x→y).
#[derive(Clone, Copy, Debug)]
pub(super) struct LogUniform {
    /// Bits of the largest.
    largest: u32,
    /// Bits of the largest less those of the least: 2²³ an octave.
    range: u32,
}

impl LogUniform {
    pub(super) const fn new(least: f32, largest: f32) -> Self {
        Self { largest: largest.to_bits(), range: largest.to_bits() - least.to_bits() }
    }

    /// A length, and a direction of the plane, uniformly.
    #[inline(always)]
    pub(super) fn draw(&self, rng: &mut impl Rng) -> (f32, Vec2) {
        let random = rng.next_u64();
        let below = (u64::from(random as u32) * u64::from(self.range)) >> 32;
        (f32::from_bits(self.largest - below as u32), on_circle((random >> 32) as u32))
    }
}
