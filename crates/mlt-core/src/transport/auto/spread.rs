//! More samples where an image is noisier.

use crate::transport::blur::blurred;

/// Radius over which the noise of a pixel is estimated, pixels of the pilot's image.
const RADIUS: usize = 1;
/// Fewest and most samples of a pixel, over the mean.
const BOUNDS: [f64; 2] = [0.25, 16.0];
/// Below so many samples the first 2^k points of a sequence are much better spread than any other number of them.
const FEW: f64 = 1e9;

/// Samples of each pixel of an image of `size`, at least one, about `samples` in all.
///
/// With error E_p of one sample of pixel p, Σ E_p / n_p with Σ n_p given is least at n_p ∝ √E_p. `errors` are those of
/// an image of `coarse` pixels.
pub(super) fn counts(errors: &[f64], coarse: [u32; 2], size: [u32; 2], samples: f64) -> Vec<u32> {
    let smooth: Vec<_> = blurred(errors, coarse, RADIUS).into_iter().map(f64::sqrt).collect();
    let mean = smooth.iter().sum::<f64>() / smooth.len() as f64;
    let ideal = |error: f64| if mean > 0.0 { (error / mean).clamp(BOUNDS[0], BOUNDS[1]) } else { 1.0 };
    let density: Vec<_> = smooth.into_iter().map(ideal).collect();
    let coarse_pixel = |x: u32, y: u32| {
        let [i, j] = [(x, 0), (y, 1)].map(|(n, axis)| u64::from(n) * u64::from(coarse[axis]) / u64::from(size[axis]));
        (j * u64::from(coarse[0]) + i) as usize
    };
    let pixels: Vec<_> = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| coarse_pixel(x, y))).collect();
    let mut uses = vec![0.0; density.len()];
    pixels.iter().for_each(|&i| uses[i] += 1.0);
    let total = |scale: f64| density.iter().zip(&uses).map(|(d, n)| n * f64::from(rounded(d * scale))).sum::<f64>();
    let [mut low, mut high] = [0.0, 2.0 * (1.0 + samples / pixels.len() as f64 / BOUNDS[0])];
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if total(middle) < samples { &mut low } else { &mut high }) = middle;
    }
    pixels.into_iter().map(|i| rounded(density[i] * low)).collect()
}

/// A good number of samples close to `ideal`.
fn rounded(ideal: f64) -> u32 {
    if ideal < FEW { 1 << libm::log2(ideal.max(1.0)).round() as u32 } else { ideal.round() as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noisy_halves_get_more() {
        let errors: Vec<_> = (0..64).map(|i| if i % 8 < 4 { 1.0 } else { 9.0 }).collect();
        let counts = counts(&errors, [8, 8], [32, 16], 32.0 * 16.0 * 200.0);
        assert_eq!(counts.len(), 512);
        let total: u32 = counts.iter().sum();
        assert!((f64::from(total) / (512.0 * 200.0) - 1.0).abs() < 0.05, "{total}");
        assert_eq!((counts[0], counts[31]), (100, 300));
    }

    #[test]
    fn every_pixel_gets_one_whatever_the_errors() {
        assert_eq!(counts(&[0.0; 4], [2, 2], [4, 4], 3.0), [1; 16]);
        assert_eq!(counts(&[1.0; 4], [2, 2], [4, 4], 16.0 * 13.0), [8; 16]);
        let one = counts(&[0.0, 0.0, 0.0, 1e9], [2, 2], [8, 8], 640.0);
        assert!(one.iter().all(|&n| n >= 1) && one.iter().sum::<u32>() < 900);
    }
}
