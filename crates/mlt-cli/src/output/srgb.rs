//! From linear pixels to the 8 bits a channel that screens show, and back: sRGB, IEC 61966-2-1.

/// All channels of pixels times 2^`exposure`, clipped to 0…1, by the sRGB curve; NaN becomes black.
///
/// `exposure`: in stops (EV).
pub(super) fn bytes(pixels: &[[f32; 3]], exposure: f64) -> Vec<u8> {
    let scale = exposure.exp2();
    pixels.as_flattened().iter().map(|&value| to_byte(encoded(f64::from(value) * scale))).collect()
}

fn encoded(linear: f64) -> f64 {
    match linear {
        x if x <= 0.0 || x.is_nan() => 0.0,
        x if x <= 0.003_130_8 => 12.92 * x,
        x if x < 1.0 => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        _ => 1.0,
    }
}

/// [`srgb_from_linear`]'s inverse on 0…1.
pub(crate) fn linear_from_srgb(encoded: f32) -> f32 {
    let encoded = f64::from(encoded);
    let linear = if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// sRGB's transfer function; clips to 0…1, NaN becomes 0.
pub(crate) fn srgb_from_linear(linear: f32) -> f32 {
    encoded(f64::from(linear)) as f32
}

fn to_byte(encoded: f64) -> u8 {
    (encoded * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of IEC 61966-2-1: middle grey 0.2140 is byte 127 or 128, the linear part has slope 12.92.
    #[test]
    fn the_curve_is_srgb() {
        assert!((encoded(0.214_041_14) - 0.5).abs() < 1e-6);
        assert!((encoded(0.001) - 0.01292).abs() < 1e-12);
        assert_eq!([f64::NAN, -1.0, 0.0].map(encoded), [0.0; 3]);
        assert_eq!([1.0, 7.0, f64::INFINITY].map(encoded), [1.0; 3]);
    }

    #[test]
    fn every_byte_survives_the_curve_both_ways() {
        for byte in 0..=255_u8 {
            assert_eq!(to_byte(encoded(f64::from(linear_from_srgb(f32::from(byte) / 255.0)))), byte);
        }
    }
}
