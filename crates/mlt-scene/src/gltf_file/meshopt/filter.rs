//! Filters of decoded attributes.

/// Unit vectors from points of an octahedron: x and y over the third component, as signed integers of a quarter of the stride.
pub(super) fn octahedral(elements: &mut [u8], stride: usize) {
    for element in elements.chunks_exact_mut(stride) {
        if stride == 4 {
            let [x, y, one] = [0, 1, 2].map(|k| f32::from(element[k] as i8));
            unfolded(x, y, one, 127.0).into_iter().zip(element).for_each(|(v, byte)| *byte = v as i8 as u8);
        } else {
            let [x, y, one] = [0, 1, 2].map(|k| f32::from(half(element, k)));
            let unit = unfolded(x, y, one, 32767.0);
            (0..3).for_each(|k| element[2 * k..][..2].copy_from_slice(&(unit[k] as i16).to_le_bytes()));
        }
    }
}

/// The vector of a point of the octahedron, of length `largest`, rounded.
fn unfolded(x: f32, y: f32, one: f32, largest: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = z.min(0.0);
    let [x, y] = [x, y].map(|v| if v >= 0.0 { v + fold } else { v - fold });
    let length = (x * x + y * y + z * z).sqrt().max(f32::MIN_POSITIVE);
    [x, y, z].map(|v| (v * (largest / length)).round())
}

/// Unit quaternions from three of their components and the number of the largest one, which is left out.
pub(super) fn quaternion(elements: &mut [u8]) {
    for element in elements.chunks_exact_mut(8) {
        let last = half(element, 3);
        let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(last | 3);
        let [x, y, z] = [0, 1, 2].map(|k| f32::from(half(element, k)) * scale);
        let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        for (k, v) in [(1, x), (2, y), (3, z), (0, w)] {
            let at = ((last & 3) as usize + k) & 3;
            element[2 * at..][..2].copy_from_slice(&((v * 32767.0).round() as i16).to_le_bytes());
        }
    }
}

/// Floating-point numbers from a mantissa of 24 bits and an exponent of 8.
pub(super) fn exponential(elements: &mut [u8]) {
    for element in elements.chunks_exact_mut(4) {
        let v = i32::from_le_bytes([element[0], element[1], element[2], element[3]]);
        let value = libm::ldexp(f64::from(v << 8 >> 8), v >> 24) as f32;
        element.copy_from_slice(&value.to_le_bytes());
    }
}

fn half(element: &[u8], k: usize) -> i16 {
    i16::from_le_bytes([element[2 * k], element[2 * k + 1]])
}
