//! Images on surfaces: 8 bits a channel in memory, decoded where they are looked up.

use glam::{UVec2, Vec2, Vec4};
use std::sync::{Arc, LazyLock};

/// Pixels, rows from the top, 8 bits a channel.
#[derive(Clone, Debug)]
pub struct Pixels {
    size: UVec2,
    channels: usize,
    bytes: Vec<u8>,
}

impl Pixels {
    /// `channels`: 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGBA). `None`: the number of bytes does not fit, or there is none.
    pub fn new(size: [u32; 2], channels: usize, bytes: Vec<u8>) -> Option<Self> {
        let count = (size[0] as usize).checked_mul(size[1] as usize)?.checked_mul(channels)?;
        let fits =
            (1..=4).contains(&channels) && count > 0 && bytes.len() == count && size.iter().all(|&n| n < 1 << 24);
        fits.then_some(Self { size: size.into(), channels, bytes })
    }

    /// Columns and rows.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Bytes a pixel: 1 to 4.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// RGBA of all pixels, rows from the top.
    pub fn iter(&self) -> impl Iterator<Item = [u8; 4]> {
        (0..self.size.y).flat_map(move |y| (0..self.size.x).map(move |x| self.at(UVec2::new(x, y))))
    }

    /// RGBA of a pixel, which lies inside.
    #[inline]
    pub fn at(&self, pixel: UVec2) -> [u8; 4] {
        let start = (pixel.y as usize * self.size.x as usize + pixel.x as usize) * self.channels;
        match self.bytes[start..start + self.channels] {
            [grey] => [grey, grey, grey, u8::MAX],
            [grey, alpha] => [grey, grey, grey, alpha],
            [r, g, b] => [r, g, b, u8::MAX],
            [r, g, b, a] => [r, g, b, a],
            _ => [u8::MAX; 4],
        }
    }
}

/// How an image goes on beyond its edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored.
    Mirror,
    /// The edge.
    Clamp,
}

impl Wrap {
    /// Column or row inside of `size` for one anywhere.
    #[inline]
    fn inside(self, i: i64, size: u32) -> u32 {
        let n = i64::from(size);
        let inside = match self {
            Self::Repeat => i.rem_euclid(n),
            Self::Clamp => i.clamp(0, n - 1),
            Self::Mirror => {
                let twice = i.rem_euclid(2 * n);
                twice.min(2 * n - 1 - twice)
            }
        };
        inside as u32
    }
}

/// Between pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Filter {
    /// The nearest one.
    Nearest,
    /// Linear interpolation along both axes.
    #[default]
    Bilinear,
}

/// Meaning of the numbers of an image; alpha is linear always.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Encoding {
    /// Proportional to the value.
    Linear,
    /// Colours as IEC 61966-2-1 encodes them.
    Srgb,
}

/// Values in [0, 1] of bytes.
type Decoded = [f32; 256];

static LINEAR: LazyLock<Decoded> = LazyLock::new(|| std::array::from_fn(|i| i as f32 / 255.0));

static SRGB: LazyLock<Decoded> = LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));

/// A value in [0, 1] of one that is encoded as in sRGB.
///
/// Source: IEC 61966-2-1.
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::powf((encoded + 0.055) / 1.055, 2.4) }
}

/// Coordinates from which on none is read.
const FARTHEST: f32 = 1e9;

/// An image with its sampler.
#[derive(Clone, Debug)]
pub struct Texture {
    pixels: Arc<Pixels>,
    /// Along u and v.
    wrap: [Wrap; 2],
    filter: Filter,
    /// Of colours.
    decoded: &'static Decoded,
    linear: &'static Decoded,
}

impl Texture {
    /// Memory of the images of some textures, each image counted once, bytes.
    pub(crate) fn bytes(textures: &[Self]) -> usize {
        let image = |texture: &Self| (Arc::as_ptr(&texture.pixels), texture.pixels.bytes.len());
        let mut images: Vec<_> = textures.iter().map(image).collect();
        images.sort_unstable();
        images.dedup();
        images.iter().map(|(_, bytes)| bytes).sum()
    }

    /// An image as one kind of parameter reads it.
    pub fn new(pixels: Arc<Pixels>, wrap: [Wrap; 2], filter: Filter, encoding: Encoding) -> Self {
        let (linear, srgb) = (&*LINEAR, &*SRGB);
        let decoded = if encoding == Encoding::Srgb { srgb } else { linear };
        Self { pixels, wrap, filter, decoded, linear }
    }

    /// RGBA at (u, v), which is (0, 0) at the upper left corner of the image and (1, 1) at the lower right one. So far away that an
    /// image is less than a rounding error, and where there is no number, it is that of (0, 0).
    #[inline]
    pub fn at(&self, uv: Vec2) -> Vec4 {
        let uv = if uv.abs().cmplt(Vec2::splat(FARTHEST)).all() { uv } else { Vec2::ZERO };
        let size = self.pixels.size;
        let position = uv * size.as_vec2();
        if self.filter == Filter::Nearest {
            return self.pixel(position.x.floor() as i64, position.y.floor() as i64);
        }
        let corner = (position - 0.5).floor();
        let share = position - 0.5 - corner;
        let (x, y) = (corner.x as i64, corner.y as i64);
        let row = |y: i64| self.pixel(x, y).lerp(self.pixel(x + 1, y), share.x);
        row(y).lerp(row(y + 1), share.y)
    }

    #[inline]
    fn pixel(&self, x: i64, y: i64) -> Vec4 {
        let size = self.pixels.size;
        let [r, g, b, a] = self.pixels.at(UVec2::new(self.wrap[0].inside(x, size.x), self.wrap[1].inside(y, size.y)));
        let colour = |byte: u8| self.decoded[usize::from(byte)];
        Vec4::new(colour(r), colour(g), colour(b), self.linear[usize::from(a)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(wrap: Wrap, filter: Filter, encoding: Encoding) -> Texture {
        let pixels = Pixels::new([2, 2], 1, vec![0, 255, 51, 102]).unwrap();
        Texture::new(Arc::new(pixels), [wrap; 2], filter, encoding)
    }

    #[test]
    fn the_first_pixel_is_the_upper_left_one() {
        let t = texture(Wrap::Repeat, Filter::Nearest, Encoding::Linear);
        let values = [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]].map(|uv| t.at(uv.into()).x);
        assert_eq!(values, [0.0, 1.0, 0.2, 0.4]);
        assert_eq!(t.at(Vec2::splat(0.1)).w, 1.0);
    }

    #[test]
    fn beyond_the_edge_it_wraps() {
        for (wrap, expected) in [(Wrap::Repeat, [1.0, 0.0]), (Wrap::Clamp, [0.0, 1.0]), (Wrap::Mirror, [0.0, 1.0])] {
            let t = texture(wrap, Filter::Nearest, Encoding::Linear);
            assert_eq!([-0.25, 1.25].map(|u| t.at(Vec2::new(u, 0.25)).x), expected, "{wrap:?}");
        }
        let twice = |wrap| texture(wrap, Filter::Nearest, Encoding::Linear).at(Vec2::new(-0.75, 0.25)).x;
        assert_eq!([Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(twice), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn between_pixels_it_is_linear_after_decoding() {
        let t = texture(Wrap::Clamp, Filter::Bilinear, Encoding::Srgb);
        assert!((t.at(Vec2::new(0.5, 0.25)).x - 0.5).abs() < 1e-6);
        let centre = (1.0 + srgb_to_linear(0.2) + srgb_to_linear(0.4)) / 4.0;
        assert!((t.at(Vec2::splat(0.5)).x - centre).abs() < 1e-6);
    }

    #[test]
    fn coordinates_without_sense_give_some_colour() {
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let t = texture(Wrap::Mirror, filter, Encoding::Srgb);
            for far in [1e8, 1e30, f32::MAX, f32::INFINITY, f32::NAN, -1e30] {
                for uv in [Vec2::splat(far), Vec2::new(0.5, far), Vec2::new(far, 0.5)] {
                    assert!(t.at(uv).is_finite() && t.at(uv).min_element() >= 0.0, "{uv}");
                }
            }
        }
    }

    /// A uniform square has the mean of the pixels, whatever the filter.
    #[test]
    fn filters_keep_the_mean() {
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let t = texture(Wrap::Repeat, filter, Encoding::Linear);
            let at = |i: u32| (f64::from(i) + 0.5) as f32 / 64.0;
            let sum: f32 = (0..64 * 64).map(|i| t.at(Vec2::new(at(i % 64), at(i / 64))).x).sum();
            assert!((sum / 4096.0 - 0.4).abs() < 1e-5, "{filter:?}: {}", sum / 4096.0);
        }
    }

    #[test]
    fn srgb_is_that_of_the_standard() {
        for (encoded, linear) in [(0.0, 0.0), (0.04, 0.003_096), (0.5, 0.214_041), (1.0, 1.0)] {
            assert!((srgb_to_linear(encoded) - linear).abs() < 1e-6);
        }
    }

    #[test]
    fn pixels_have_as_many_bytes_as_they_say() {
        assert!(Pixels::new([2, 2], 3, vec![0; 12]).is_some());
        for (size, channels, bytes) in [([2, 2], 3, 11), ([0, 2], 3, 0), ([2, 2], 5, 20), ([u32::MAX; 2], 4, 0)] {
            assert!(Pixels::new(size, channels, vec![0; bytes]).is_none());
        }
    }
}
