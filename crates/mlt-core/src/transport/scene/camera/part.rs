//! Parts of an image.

use glam::Vec2;

/// A rectangle of an image, in film points of the whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Its top left corner.
    pub low: Vec2,
    /// Its width and height.
    pub size: Vec2,
}

impl Part {
    /// Of so many pixels from a pixel on, in an image of `whole` pixels.
    pub(super) fn of_pixels(corner: [u32; 2], size: [u32; 2], whole: [u32; 2]) -> Self {
        let share = |pixels: [u32; 2]| {
            let [x, y] = [0, 1].map(|axis| (f64::from(pixels[axis]) / f64::from(whole[axis])) as f32);
            Vec2::new(x, y)
        };
        Self { low: share(corner), size: share(size) }
    }

    /// From the whole's middle to its own, in halves of the whole.
    pub(super) fn offset(&self) -> Vec2 {
        2.0 * self.low + self.size - Vec2::ONE
    }
}
