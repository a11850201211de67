//! Smooth images from noisy ones.

use rayon::prelude::*;

/// Means over squares of 2·`radius` + 1 pixels a side, cut off at the image's border: along rows, then along columns, from
/// running sums.
pub(crate) fn blurred(image: &[f64], [width, height]: [u32; 2], radius: usize) -> Vec<f64> {
    let (width, height) = (width as usize, height as usize);
    // The sums of columns up to each row, below a row of zeros.
    let mut sums = vec![0.0; (height + 1) * width];
    let rows = sums.par_chunks_mut(width).skip(1).zip(image.par_chunks(width));
    rows.for_each_init(Vec::new, |running, (means, row)| row_means(row, radius, running, means));
    for i in width..sums.len() {
        sums[i] += sums[i - width];
    }
    let mut result = vec![0.0; image.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(y, means)| {
        let [low, high] = window(y, radius, height);
        let [below, above] = [low, high].map(|y| &sums[y * width..][..width]);
        means.iter_mut().enumerate().for_each(|(x, m)| *m = (above[x] - below[x]) / (high - low) as f64);
    });
    result
}

/// Means of a row; `running` is scratch for its running sums.
fn row_means(row: &[f64], radius: usize, running: &mut Vec<f64>, means: &mut [f64]) {
    running.clear();
    running.push(0.0);
    row.iter().for_each(|v| running.push(running[running.len() - 1] + v));
    for (x, mean) in means.iter_mut().enumerate() {
        let [low, high] = window(x, radius, row.len());
        *mean = (running[high] - running[low]) / (high - low) as f64;
    }
}

/// The first index of the window around `i`, and the one after its last, of `n`.
fn window(i: usize, radius: usize, n: usize) -> [usize; 2] {
    [i.saturating_sub(radius), (i + radius + 1).min(n)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_and_a_point_spreads() {
        assert!(blurred(&[2.0; 12], [4, 3], 2).iter().all(|x| (x - 2.0).abs() < 1e-12));
        let mut image = vec![0.0; 49];
        image[24] = 9.0;
        let spread = blurred(&image, [7, 7], 1);
        assert!((spread[24] - 1.0).abs() < 1e-12 && (spread[16] - 1.0).abs() < 1e-12);
        assert!(spread[9].abs() < 1e-12 && (spread.iter().sum::<f64>() - 9.0).abs() < 1e-12);
    }
}
