//! Standard errors of a film's pixels, found while they are written.

use std::{
    ops::Range,
    sync::{Mutex, PoisonError},
};

use mlt_core::engine::Film;

/// Rows whose errors are found together: those of a square's half above and below them are looked at, too.
const ROWS: usize = 64;

/// The errors of a few rows at a time.
#[derive(Debug)]
pub(super) struct Errors<'a> {
    film: &'a Film<3>,
    strip: Mutex<Strip>,
}

/// Some rows and their errors.
type Strip = (Range<usize>, Vec<[f64; 3]>);

impl<'a> Errors<'a> {
    pub(super) fn new(film: &'a Film<3>) -> Self {
        Self { film, strip: Mutex::default() }
    }

    /// The errors of one channel in a row.
    pub(super) fn line(&self, row: usize, channel: usize) -> Vec<f32> {
        let [width, height] = self.film.size().map(|n| n as usize);
        let mut strip = self.strip.lock().unwrap_or_else(PoisonError::into_inner);
        if !strip.0.contains(&row) {
            let rows = row..(row + ROWS).min(height);
            *strip = (rows.clone(), self.film.standard_errors_of(rows));
        }
        strip.1[(row - strip.0.start) * width..][..width].iter().map(|errors| errors[channel] as f32).collect()
    }
}

/// The errors of all pixels, row by row.
pub(crate) fn of_all(film: &Film<3>) -> Vec<[f32; 3]> {
    let height = film.size()[1] as usize;
    let strip = |first: usize| film.standard_errors_of(first..(first + ROWS).min(height));
    let in_f32 = |errors: [f64; 3]| errors.map(|error| error as f32);
    (0..height).step_by(ROWS).flat_map(|first| strip(first).into_iter().map(in_f32)).collect()
}
