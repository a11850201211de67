//! Small geometry: products, frames and maps from the unit square.

use glam::{Vec2, Vec3A, Vec3Swizzles, Vec4};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// v/|v|, to the same bits on every machine: glam's `normalize` divides on x86-64, and multiplies by the reciprocal on aarch64.
#[inline(always)]
pub fn unit(v: Vec3A) -> Vec3A {
    v / v.length()
}

/// a × b, to the same bits on every machine: glam's `cross` fuses a product with the difference on aarch64, and on x86-64 where the program
/// is compiled for FMA.
#[inline(always)]
pub fn cross(a: Vec3A, b: Vec3A) -> Vec3A {
    (a.zxy() * b - b.zxy() * a).zxy()
}

/// Two unit vectors that complete the unit vector `n` to a right-handed frame (s, t, n).
///
/// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
#[inline(always)]
pub fn frame(n: Vec3A) -> (Vec3A, Vec3A) {
    let sign = 1f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3A::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3A::new(b, sign + n.y * n.y * a, -n.y))
}

/// Maps the unit square onto the unit disk, preserving relative area; returns the point and its distance from the centre, squared,
/// which is known first.
///
/// Source: Shirley & Chiu, "A Low Distortion Map Between Disk and Square", 1997.
#[inline(always)]
pub fn square_to_disk(u: Vec2) -> (Vec2, f32) {
    let Vec2 { x, y } = 2.0 * u - Vec2::ONE;
    // In vectors, where a choice is no branch: which way it goes is chance.
    let [x_square, y_square] = [x * x, y * y].map(Vec4::splat);
    let square = x_square.max(y_square).x;
    // The lesser over the greater.
    let ratio = x * y / (square + f32::MIN_POSITIVE);
    let Vec2 { x: cos, y: sin } = eighth_turn(FRAC_PI_4 * ratio);
    let [flat, steep] = [Vec4::new(cos, sin, 0.0, 0.0) * x, Vec4::new(sin, cos, 0.0, 0.0) * y];
    let point = Vec4::select(y_square.cmpgt(x_square), steep, flat);
    (Vec2::new(point.x, point.y), square)
}

/// (cos φ, sin φ) for |φ| ≤ π/4, to 3·10⁻⁷, by their series: the same bits on every machine, and no call. Halves of the
/// sums do not wait for each other (Estrin's scheme).
#[inline(always)]
pub(crate) fn eighth_turn(angle: f32) -> Vec2 {
    const COS: [f32; 3] = [1.0 / 24.0, 1.0 / 720.0, 1.0 / 40320.0];
    const SIN: [f32; 4] = [1.0 / 6.0, 1.0 / 120.0, 1.0 / 5040.0, 1.0 / 362_880.0];
    let x2 = angle * angle;
    let x4 = x2 * x2;
    let cos = (1.0 - 0.5 * x2) + x4 * ((COS[0] - COS[1] * x2) + COS[2] * x4);
    let sin = angle * ((1.0 - SIN[0] * x2) + x4 * ((SIN[1] - SIN[2] * x2) + SIN[3] * x4));
    Vec2::new(cos, sin)
}

/// (cos, sin) of no quarter, one, two and three.
const QUARTER_TURNS: [Vec2; 4] = [Vec2::X, Vec2::Y, Vec2::NEG_X, Vec2::NEG_Y];

/// A point on the unit circle, uniformly for uniform `bits`: the first two choose a quarter, the others an angle in it.
#[inline(always)]
pub(crate) fn on_circle(bits: u32) -> Vec2 {
    let in_quarter = f32::from_bits(1f32.to_bits() | bits << 2 >> 9) - 1.5;
    // A product instead of a branch: which way it goes is chance.
    eighth_turn(FRAC_PI_2 * in_quarter).rotate(QUARTER_TURNS[(bits >> 30) as usize])
}

/// (cos 2πu, sin 2πu) for u in [0, 1], to 3·10⁻⁷.
#[inline(always)]
pub(crate) fn turn(u: f32) -> Vec2 {
    let quarter = (4.0 * u + 0.5) as usize;
    eighth_turn(FRAC_PI_2 * (4.0 * u - quarter as f32)).rotate(QUARTER_TURNS[quarter % 4])
}

/// Σ tᵢ xⁱ, by Estrin's scheme.
#[inline(always)]
fn polynomial(t: [f32; 8], x: f32) -> f32 {
    let x2 = x * x;
    let quarter = |i: usize| (t[i] + t[i + 1] * x) + x2 * (t[i + 2] + t[i + 3] * x);
    quarter(0) + (x2 * x2) * quarter(4)
}

/// The angle in [0, π] whose cosine is `x`, to 10⁻⁶: √(1 − |x|) times a polynomial, the same bits on every machine, and no call.
///
/// Source: Abramowitz & Stegun, "Handbook of Mathematical Functions", 4.4.46.
#[inline]
pub(crate) fn acos(x: f32) -> f32 {
    const TERMS: [f32; 8] = [
        FRAC_PI_2,
        -0.214_598_8,
        0.088_978_99,
        -0.050_174_305,
        0.030_891_88,
        -0.017_088_126,
        0.006_670_09,
        -0.001_262_491_1,
    ];
    let from_end = 1.0 - x.abs().min(1.0);
    let angle = from_end.sqrt() * polynomial(TERMS, 1.0 - from_end);
    if x < 0.0 { PI - angle } else { angle }
}

/// The angle in [−π, π] of the point (x, y), to 10⁻⁶; 0 at the origin. The same bits on every machine, and no call.
///
/// Source: Abramowitz & Stegun, 4.4.49.
#[inline]
pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    const TERMS: [f32; 8] = [
        -0.333_331_45,
        0.199_935_51,
        -0.142_089,
        0.106_562_64,
        -0.075_289_64,
        0.042_909_61,
        -0.016_165_737,
        0.002_866_225_7,
    ];
    let (across, along) = (y.abs(), x.abs());
    let slope = across.min(along) / across.max(along).max(f32::MIN_POSITIVE);
    let square = slope * slope;
    let angle = slope + slope * (square * polynomial(TERMS, square));
    let from_axis = if across > along { FRAC_PI_2 - angle } else { angle };
    (if x < 0.0 { PI - from_axis } else { from_axis }).copysign(y)
}

/// A direction about the unit vector `n` with density cosθ/π, sr⁻¹.
#[inline(always)]
pub fn cosine_hemisphere(n: Vec3A, u: Vec2) -> Vec3A {
    let (d, square) = square_to_disk(u);
    let z = (1.0 - square).sqrt();
    let (s, t) = frame(n);
    d.x * s + d.y * t + z * n
}

/// `a`·`b` of the vectors, absolute.
#[inline]
pub fn abs_dot(a: Vec3A, b: Vec3A) -> f32 {
    a.dot(b).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products and sums are rounded one by one, whatever the processor has.
    #[test]
    fn products_have_the_bits_of_their_formulas() {
        for i in 0..1000 {
            let [a, b] =
                [1, 2].map(|k| Vec3A::from_array([3, 5, 7].map(|p| turn((0.1 + 0.37 * (k * p * i) as f32) % 1.0).x)));
            let crossed = [a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y];
            let length = (a.x * a.x + a.y * a.y + a.z * a.z).sqrt();
            assert_eq!(cross(a, b).to_array(), crossed);
            assert_eq!(unit(a).to_array(), a.to_array().map(|x| x / length));
        }
    }

    #[test]
    fn an_eighth_turn_is_a_turn() {
        for i in -100..=100 {
            let angle = FRAC_PI_4 * i as f32 / 100.0;
            let expected = Vec2::new(f64::from(angle).cos() as f32, f64::from(angle).sin() as f32);
            assert!(eighth_turn(angle).distance(expected) < 3e-7, "{angle}");
        }
    }

    #[test]
    fn a_turn_is_one() {
        for i in 0..=1000 {
            let angle = std::f64::consts::TAU * f64::from(i) / 1000.0;
            let expected = Vec2::new(angle.cos() as f32, angle.sin() as f32);
            assert!(turn(i as f32 / 1000.0).distance(expected) < 5e-7, "{i}");
        }
    }

    #[test]
    fn angles_are_those_of_their_cosines_and_points() {
        for i in -1000..=1000 {
            let x = i as f32 / 1000.0;
            assert!((f64::from(acos(x)) - f64::from(x).acos()).abs() < 1e-6, "{x}");
            let angle = f64::from(x) * std::f64::consts::PI;
            let of_point = atan2((3.0 * angle.sin()) as f32, (3.0 * angle.cos()) as f32);
            let off = (f64::from(of_point) - angle).abs();
            assert!(off.min(std::f64::consts::TAU - off) < 1e-6, "{angle}: {of_point}");
        }
        assert_eq!([acos(1.5), atan2(0.0, 0.0)], [0.0; 2]);
    }

    #[test]
    fn the_circle_is_covered_evenly() {
        let mut turns: Vec<_> = (0..1000).map(|i| on_circle((f64::from(i) * 4_294_967.296) as u32)).collect();
        assert!(turns.iter().all(|p| (p.length() - 1.0).abs() < 1e-6));
        turns.sort_by(|a, b| a.to_angle().total_cmp(&b.to_angle()));
        let step = std::f32::consts::TAU / 1000.0;
        assert!(turns.windows(2).all(|p| (p[0].angle_to(p[1]) - step).abs() < 1e-4));
    }

    #[test]
    fn equal_areas_of_the_square_are_equal_areas_of_the_disk() {
        const N: usize = 1001;
        let mut rings = [0.0; 4];
        let mut sectors = [0.0; 8];
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let (p, square) = square_to_disk((Vec2::new(i as f32, j as f32) + 0.5) / N as f32);
            assert!((p.length_squared() - square).abs() < 1e-6);
            rings[(4.0 * p.length_squared()).min(3.99) as usize] += 4.0 / (N * N) as f64;
            let turn = f64::from(p.y).atan2(f64::from(p.x)) / std::f64::consts::TAU;
            sectors[(8.0 * turn.rem_euclid(1.0)).min(7.99) as usize] += 8.0 / (N * N) as f64;
        }
        assert!(rings.iter().chain(&sectors).all(|share: &f64| (share - 1.0).abs() < 0.02), "{rings:?} {sectors:?}");
    }
}
