//! Directions in proportion to the luminance of an image that is interpolated linearly in azimuth and height.
//!
//! With rows of luminance l_j(φ), linear between the centres of pixels, and t ∈ [0, 1] the place of z between two rows, luminance is
//! (1 − t) l_j(φ) + t l_{j+1}(φ), and its integral over φ is (1 − t) S_j + t S_{j+1}: linear, too. So z has a distribution of trapezia, and φ
//! given z another one, whose cumulative sums are (1 − t) and t times those of the two rows. Both are inverted in closed form.
//!
//! Above the centres of the first row and below those of the last one luminance does not depend on z.

use super::guide::Guide;
use crate::transport::colour::{Rgb, luminance};
use glam::{DVec2, Vec4};
use std::f64::consts::{PI, TAU};

/// The map from the unit square, u to heights from the top down, v to columns.
#[derive(Clone, Debug)]
pub(super) struct Distribution {
    /// Columns and rows.
    size: [usize; 2],
    /// z of the top, of the rows' centres and of the bottom.
    heights: Vec<f64>,
    /// Share of the power above each of them but the top.
    above: Vec<f64>,
    /// Row by row: ∫ luminance from the first pixel's centre to that of each next one, in pixels; the last one is the first again.
    along: Vec<f64>,
    /// Where to look in `above`.
    to_rows: Guide,
    /// Where to look in `along`, row by row.
    to_columns: Vec<Guide>,
    /// Radiance of each pixel and, last, its luminance: together, as whoever asks for one soon asks for the other.
    pixels: Vec<Vec4>,
}

/// A place between four pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The interval of heights, 0 being that above the first row's centres, and the place in it from the top down.
    pub(super) row: usize,
    pub(super) down: f64,
    /// The column left of it, and the place between it and the next one.
    pub(super) column: usize,
    pub(super) right: f64,
}

impl Distribution {
    pub(super) fn new(size: [usize; 2], pixels: &[Rgb]) -> Self {
        let [width, height] = size;
        let pixels: Vec<Vec4> = pixels.iter().map(|&pixel| pixel.extend(luminance(pixel))).collect();
        let centre = |j: usize| libm::cos(PI * (j as f64 + 0.5) / height as f64);
        let heights: Vec<f64> = [1.0].into_iter().chain((0..height).map(centre)).chain([-1.0]).collect();
        let along = pixels.chunks_exact(width).flat_map(|row| {
            let mut sum = 0.0;
            (0..width).map(move |i| {
                sum += 0.5 * (f64::from(row[i].w) + f64::from(row[(i + 1) % width].w));
                sum
            })
        });
        let along: Vec<f64> = along.collect();
        let to_columns = along.chunks_exact(width).map(Guide::new).collect();
        let mut it = Self { size, heights, above: Vec::new(), along, to_rows: Guide::default(), to_columns, pixels };
        let total = it.integral(|row| it.row_total(row));
        let mut sum = 0.0;
        let up_to = |part| {
            sum += part / total;
            sum
        };
        it.above = it.parts(|row| it.row_total(row)).map(up_to).collect();
        it.to_rows = Guide::new(&it.above);
        it
    }

    /// The radiance, where it is the same in all directions.
    #[inline]
    pub(super) fn even(&self) -> Option<Rgb> {
        if let [pixel] = self.pixels[..] { Some(pixel.truncate()) } else { None }
    }

    /// ∫ x dω of a quantity x that is interpolated as luminance is, from its sum over each row.
    pub(super) fn integral(&self, of_row: impl Fn(usize) -> f64) -> f64 {
        self.parts(of_row).sum()
    }

    /// The same for each interval of heights.
    fn parts(&self, of_row: impl Fn(usize) -> f64) -> impl Iterator<Item = f64> {
        (0..=self.size[1]).map(move |interval| {
            let [a, b] = self.rows(interval).map(&of_row);
            0.5 * (a + b) * (self.heights[interval] - self.heights[interval + 1]) * TAU / self.size[0] as f64
        })
    }

    /// The rows above and below an interval of heights.
    #[inline]
    pub(super) fn rows(&self, interval: usize) -> [usize; 2] {
        [interval.saturating_sub(1), interval.min(self.size[1] - 1)]
    }

    /// The columns left and right of a place.
    #[inline]
    pub(super) fn columns(&self, column: usize) -> [usize; 2] {
        [column, if column + 1 < self.size[0] { column + 1 } else { 0 }]
    }

    /// z of a place.
    #[inline]
    pub(super) fn height(&self, place: &Place) -> f64 {
        mix([self.heights[place.row], self.heights[place.row + 1]], place.down)
    }

    /// The place at a height, whose angle from the top is a share of half a turn, and a share of a turn from the first column's centre.
    #[inline]
    pub(super) fn place(&self, z: f64, polar: f64, turn: f64) -> Place {
        let [width, height] = self.size;
        let row = ((polar * height as f64 + 0.5) as usize).min(height);
        let [top, bottom] = [self.heights[row], self.heights[row + 1]];
        let along = turn * width as f64;
        let column = (along as usize).min(width - 1);
        Place {
            row,
            down: ((top - z) / (top - bottom)).clamp(0.0, 1.0),
            column,
            right: (along - column as f64).clamp(0.0, 1.0),
        }
    }

    /// The place of a point of the unit square.
    #[inline]
    pub(super) fn at(&self, u: f64, v: f64) -> Place {
        let rows = self.to_rows.range(u);
        let row = (rows.start + self.above[rows].partition_point(|&end| end <= u)).min(self.size[1]);
        let begin = if row == 0 { 0.0 } else { self.above[row - 1] };
        let totals = self.rows(row).map(|row| self.row_total(row));
        let down = trapezium_inverse(totals, (u - begin) / (self.above[row] - begin));
        let column = self.column(row, down, v);
        let target = v * mix(totals, down);
        let ends = self.columns(column).map(|column| self.luminance_at(row, down, column));
        let share = (target - self.before(row, down, column)) / (0.5 * (ends[0] + ends[1]));
        Place { row, down, column, right: trapezium_inverse(ends, share) }
    }

    /// The column, in pixels from the centre of the first, and the height of a point of the unit square.
    #[inline]
    pub(super) fn column_and_height(&self, u: f64, v: f64) -> (f64, f64) {
        let place = self.at(u, v);
        (place.column as f64 + place.right, self.height(&place))
    }

    /// The point of the unit square of a place.
    #[inline]
    pub(super) fn coordinates(&self, place: &Place) -> DVec2 {
        let &Place { row, down, column, right } = place;
        let begin = if row == 0 { 0.0 } else { self.above[row - 1] };
        let totals = self.rows(row).map(|row| self.row_total(row));
        let u = begin + (self.above[row] - begin) * trapezium(totals, down);
        let ends = self.columns(column).map(|column| self.luminance_at(row, down, column));
        let passed = self.before(row, down, column) + 0.5 * (ends[0] + ends[1]) * trapezium(ends, right);
        let all = mix(totals, down);
        DVec2::new(u, if all > 0.0 { passed / all } else { 0.0 }).clamp(DVec2::ZERO, DVec2::ONE)
    }

    /// The last column that has no more than the share `v` of the luminance at a height before it. Where a mixture of two rows reaches a
    /// share, one of them has reached it and the other one has not gone beyond.
    #[inline]
    fn column(&self, row: usize, down: f64, v: f64) -> usize {
        let rows = self.rows(row);
        let [a, b] = rows.map(|row| self.to_columns[row].range(v));
        let target = v * mix(rows.map(|row| self.row_total(row)), down);
        let last = self.size[0] - 1;
        let (mut low, mut high) = (a.start.min(b.start).min(last), a.end.max(b.end).min(last) + 1);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if self.before(row, down, middle) <= target { low = middle } else { high = middle }
        }
        low
    }

    /// ∫ luminance from the first column's centre to another one's, at a height.
    #[inline]
    fn before(&self, row: usize, down: f64, column: usize) -> f64 {
        let Some(last) = column.checked_sub(1) else { return 0.0 };
        mix(self.rows(row).map(|row| self.along[row * self.size[0] + last]), down)
    }

    #[inline]
    fn luminance_at(&self, row: usize, down: f64, column: usize) -> f64 {
        mix(self.rows(row).map(|row| f64::from(self.pixels[row * self.size[0] + column].w)), down)
    }

    /// Radiance at a place.
    #[inline]
    pub(super) fn radiance(&self, place: &Place) -> Rgb {
        let columns = self.columns(place.column);
        let [above, below] = self.rows(place.row).map(|row| {
            let [left, right] = columns.map(|column| self.pixels[row * self.size[0] + column]);
            left.lerp(right, place.right as f32)
        });
        above.lerp(below, place.down as f32).truncate()
    }

    /// Largest radiance of a pixel, channel by channel.
    pub(super) fn brightest(&self) -> Rgb {
        self.pixels.iter().copied().fold(Vec4::ZERO, Vec4::max).truncate()
    }

    /// ∫ luminance along a row.
    #[inline]
    fn row_total(&self, row: usize) -> f64 {
        self.along[(row + 1) * self.size[0] - 1]
    }
}

#[inline]
fn mix([a, b]: [f64; 2], t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// Share of a trapezium, of height a on its left and b on its right side, that lies left of x ∈ [0, 1].
#[inline]
fn trapezium([a, b]: [f64; 2], x: f64) -> f64 {
    if a + b > 0.0 { x * (2.0 * a + x * (b - a)) / (a + b) } else { x }
}

/// x of a share.
#[inline]
fn trapezium_inverse([a, b]: [f64; 2], share: f64) -> f64 {
    if a + b <= 0.0 {
        return 0.0;
    }
    let share = share.clamp(0.0, 1.0);
    (share * (a + b) / (a + (a * a + share * (b * b - a * a)).sqrt())).min(1.0)
}
