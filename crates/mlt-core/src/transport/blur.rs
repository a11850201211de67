//! Smooth images from noisy ones.

/// Means over squares of 2·`radius` + 1 pixels a side, cut off at the image's border.
pub(super) fn blurred(image: &[f64], [width, height]: [u32; 2], radius: usize) -> Vec<f64> {
    let (width, height) = (width as usize, height as usize);
    let rows: Vec<_> = image.chunks(width).flat_map(|row| running_means(row.iter().copied(), radius)).collect();
    let mut result = vec![0.0; image.len()];
    for x in 0..width {
        let column = (0..height).map(|y| rows[y * width + x]);
        running_means(column, radius).into_iter().enumerate().for_each(|(y, mean)| result[y * width + x] = mean);
    }
    result
}

fn running_means(values: impl Iterator<Item = f64>, radius: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    values.for_each(|v| sums.push(sums[sums.len() - 1] + v));
    let n = sums.len() - 1;
    let mean = |i: usize| {
        let (low, high) = (i.saturating_sub(radius), (i + radius + 1).min(n));
        (sums[high] - sums[low]) / (high - low) as f64
    };
    (0..n).map(mean).collect()
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
