//! What every [`Bsdf`] keeps: densities, reciprocity, energy, finite numbers.

use super::super::Rgb;
use super::*;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// A normal along no axis.
fn normal() -> Vec3 {
    Vec3::new(0.36, -0.48, 0.8)
}

fn uniform(rng: &mut Pcg64Mcg) -> f32 {
    (rng.next_u32() >> 8) as f32 / (1u32 << 24) as f32
}

fn uniform3(rng: &mut Pcg64Mcg) -> [f32; 3] {
    [uniform(rng), uniform(rng), uniform(rng)]
}

/// At `cos` = n·direction and azimuth 0.7 about the normal.
fn direction(n: Vec3, cos: f32) -> Vec3 {
    spherical(n, cos as f64, 0.7)
}

fn spherical(n: Vec3, cos: f64, azimuth: f64) -> Vec3 {
    let (s, t) = super::super::math::frame(n);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, t, n) = (s.as_dvec3(), t.as_dvec3(), n.as_dvec3());
    (sin * azimuth.cos() * s + sin * azimuth.sin() * t + cos * n).as_vec3()
}

fn close(a: f32, b: f32, relative: f32) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs())
}

mod delta {
    use super::*;

    fn all() -> Vec<(Bsdf, f32)> {
        let tint = Rgb::new(0.9, 0.5, 0.2);
        vec![
            (Bsdf::Mirror(Mirror { f0: tint }), 1.0),
            (Bsdf::Dielectric(Dielectric { ior: 1.5, tint }), 1.5),
            (Bsdf::Dielectric(Dielectric { ior: 0.7, tint }), 0.7),
            (Bsdf::Dielectric(Dielectric { ior: 1.0, tint }), 1.0),
            (Bsdf::Thin(Thin { ior: 1.5, tint }), 1.0),
        ]
    }

    /// Every pair (given, sampled) of a few angles on both sides, with η² of the two sides.
    fn pairs(b: &Bsdf, inside: f32, mut check: impl FnMut(Vec3, Vec3, f32, f32)) {
        let n = normal();
        let eta2 = |v: Vec3| if n.dot(v) > 0.0 { 1.0 } else { inside * inside };
        for cos in [1.0, 0.8, 0.5, 0.1, 0.01, -0.01, -0.3, -0.8, -1.0] {
            let given = direction(n, cos);
            for sampled in [false, true].into_iter().filter_map(|t| b.delta_direction(n, given, t)) {
                check(given, sampled, eta2(given), eta2(sampled));
            }
        }
    }

    #[test]
    fn throughput_is_share_over_probability_times_radiance_scaling() {
        let n = normal();
        for (b, inside) in all() {
            pairs(&b, inside, |given, sampled, eta2_given, eta2_sampled| {
                let p = b.event_probability(n, given, sampled);
                let scaled = b.pdf(n, given, sampled) / n.dot(sampled).abs();
                assert!(close(scaled, p * eta2_sampled, 1e-5));
                if p == 0.0 {
                    return;
                }
                // F/P: a dielectric's factor is the tint of what it transmits.
                let weight = match &b {
                    Bsdf::Mirror(m) => fresnel::schlick(m.f0, 1.0, n.dot(given).abs()),
                    _ if n.dot(given) * n.dot(sampled) > 0.0 => Rgb::ONE,
                    _ => Rgb::new(0.9, 0.5, 0.2),
                };
                let from_eye = b.eval(n, sampled, given) / scaled;
                let from_light = b.eval(n, given, sampled) / scaled;
                for c in 0..3 {
                    assert!(close(from_eye[c], weight[c] * eta2_given / eta2_sampled, 1e-5));
                    assert!(close(from_light[c], weight[c], 1e-5));
                }
            });
        }
    }

    #[test]
    fn events_exhaust_and_return() {
        let n = normal();
        for (b, inside) in all() {
            let mut total = 0.0;
            let mut last = Vec3::ZERO;
            pairs(&b, inside, |given, sampled, _, _| {
                assert!(b.is_delta() && (sampled.length() - 1.0).abs() < 1e-6);
                let back = b.delta_direction(n, sampled, n.dot(given) * n.dot(sampled) < 0.0).unwrap();
                // At grazing angles cosθ' magnifies the rounding of cosθ.
                assert!((back - given).length() < 1e-6 / n.dot(given).abs().min(n.dot(sampled).abs()));
                total = if given == last { total } else { 0.0 } + b.event_probability(n, given, sampled);
                last = given;
                assert!(total < 1.0 + 1e-4);
            });
            assert!((total - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn sampled_shares_match_event_probability() {
        let n = normal();
        let mut rng = Pcg64Mcg::seed_from_u64(7);
        for (b, _) in all() {
            for cos in [0.9, 0.3, -0.3, -0.9] {
                let given = direction(n, cos);
                let draws = 40_000;
                let reflected = (0..draws)
                    .filter_map(|_| b.sample(n, given, uniform3(&mut rng)))
                    .filter(|s| n.dot(*s) * cos > 0.0)
                    .count() as f64;
                let p = b.delta_direction(n, given, false).map_or(0.0, |r| b.event_probability(n, given, r)) as f64;
                let sd = (p * (1.0 - p) * draws as f64).sqrt();
                assert!((reflected - p * draws as f64).abs() <= 4.5 * sd + 1e-3, "{b:?} {cos}: {reflected} for {p}");
            }
        }
    }

    #[test]
    fn glass_as_textbooks_say() {
        let n = normal();
        let glass = Bsdf::Dielectric(Dielectric { ior: 1.5, tint: Rgb::ONE });
        // Radiance that enters glass is concentrated by η²; a pane seen from outside shows 1 - 0.04.
        assert!(close(glass.eval(n, n, -n).x, 0.96 * 2.25, 1e-5) && close(glass.eval(n, -n, n).x, 0.96, 1e-5));
        // Beyond the critical angle, cosθ = √(1 - 1/1.5²) = 0.745, everything is reflected.
        let inside = direction(n, -0.7);
        assert!(glass.delta_direction(n, inside, true).is_none());
        assert_eq!(glass.sample(n, inside, [0.5, 0.5, 0.999]), glass.delta_direction(n, inside, false));
        let pane = Bsdf::Thin(Thin { ior: 1.5, tint: Rgb::ONE });
        assert!(close(pane.eval(n, n, n).x, 0.08 / 1.04, 1e-5));
        assert_eq!(pane.delta_direction(n, inside, true), Some(-inside));
    }
}
