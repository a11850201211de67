//! Laws that every [`Bsdf`] keeps: densities, reciprocity, energy, finite numbers.

use super::microfacet::Microfacets;
use super::*;
use crate::transport::colour::Rgb;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// A normal along no axis.
fn normal() -> Vec3A {
    Vec3A::new(0.36, -0.48, 0.8)
}

fn uniform(rng: &mut Pcg64Mcg) -> f32 {
    (rng.next_u32() >> 8) as f32 / (1u32 << 24) as f32
}

fn uniform3(rng: &mut Pcg64Mcg) -> [f32; 3] {
    [uniform(rng), uniform(rng), uniform(rng)]
}

/// At `cos` = n·direction and azimuth 0.7 about the normal.
fn direction(n: Vec3A, cos: f32) -> Vec3A {
    spherical(n, cos as f64, 0.7)
}

fn spherical(n: Vec3A, cos: f64, azimuth: f64) -> Vec3A {
    let (s, t) = crate::transport::geometry::math::frame(n);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, t, n) = (s.as_dvec3(), t.as_dvec3(), n.as_dvec3());
    (sin * azimuth.cos() * s + sin * azimuth.sin() * t + cos * n).as_vec3a()
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
    fn pairs(b: &Bsdf, inside: f32, mut check: impl FnMut(Vec3A, Vec3A, f32, f32)) {
        let n = normal();
        let eta2 = |v: Vec3A| if n.dot(v) > 0.0 { 1.0 } else { inside * inside };
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
            let mut last = Vec3A::ZERO;
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

mod rough {
    use super::microfacet::Ggx;
    use super::*;
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    use std::f64::consts::{PI, TAU};

    const TINT: Rgb = Rgb::new(0.9, 0.5, 0.2);

    fn coat(alpha: f32, f90: f32) -> Bsdf {
        let base = Lambert { reflectance: Rgb::new(0.8, 0.3, 0.1) };
        Bsdf::Glossy(Glossy::new(base, Conductor::new(Rgb::splat(0.04 * f90), f90, Ggx { alpha })))
    }

    /// A coat, a pane, metal, and a little of nothing.
    fn mix(alpha: f32) -> Bsdf {
        let Bsdf::Glossy(coat) = coat(alpha, 0.5) else { unreachable!() };
        let pane = Lobe::RoughThin(RoughThin::new(1.5, TINT, Ggx { alpha }));
        let metal = Lobe::Conductor(Conductor::new(TINT, 1.0, Ggx { alpha }));
        let lobes = [(0.4, Some(Lobe::Glossy(coat))), (0.3, Some(pane)), (0.2, Some(metal))];
        Bsdf::Mix(Mix { lobes })
    }

    /// A coat over fibres over `mix`.
    fn layered(alpha: f32) -> Bsdf {
        let Bsdf::Mix(base) = mix(alpha) else { unreachable!() };
        let lobe = Conductor::new(Rgb::splat(0.04), 1.0, Ggx { alpha });
        let coat = Some(Coat { lobe, share: 0.7, normal: None });
        let sheen = Some(Sheen::new(Rgb::new(0.3, 0.9, 0.5), alpha.sqrt()));
        Bsdf::Layered(Layered { coat, sheen, base })
    }

    /// A tangent of `normal`, along no axis.
    fn tangent() -> Vec3A {
        (Vec3A::new(0.2, 0.9, 0.1) - normal() * normal().dot(Vec3A::new(0.2, 0.9, 0.1))).normalize()
    }

    /// A metal, and a coat over a base, both ten times as rough along a direction as across it, but no more than 1.
    fn brushed(alpha: f32, swap: bool) -> Bsdf {
        let alphas = [(10.0 * alpha).min(1.0), alpha];
        let facets = Facets::brushed(tangent(), if swap { [alphas[1], alphas[0]] } else { alphas });
        let coat = Glossy::new(Lambert { reflectance: TINT }, Conductor::of(Rgb::splat(0.04), 1.0, facets));
        let metal = Lobe::BrushedMetal(Conductor::of(TINT, 1.0, facets));
        Bsdf::Mix(Mix { lobes: [(0.3, Some(Lobe::BrushedCoat(coat))), (0.7, Some(metal)), (0.0, None)] })
    }

    /// Every kind that is not delta, with the index on the back side.
    fn all(alpha: f32) -> Vec<(Bsdf, f32)> {
        let ggx = Ggx { alpha };
        let glass = |ior| Bsdf::RoughDielectric(RoughDielectric::new(ior, TINT, ggx));
        let pane = || Bsdf::RoughThin(RoughThin::new(1.5, TINT, ggx));
        vec![
            (Bsdf::Conductor(Conductor::new(TINT, 1.0, ggx)), 1.0),
            (coat(alpha, 1.0), 1.0),
            (glass(1.5), 1.5),
            (glass(0.7), 0.7),
            (pane(), 1.0),
            (mix(alpha), 1.0),
            (layered(alpha), 1.0),
        ]
    }

    /// The same and what is brushed.
    fn all_and_brushed(alpha: f32) -> Vec<(Bsdf, f32)> {
        all(alpha).into_iter().chain([false, true].map(|swap| (brushed(alpha, swap), 1.0))).collect()
    }

    /// `all` and Lambert at `alphas`, seen at a few angles on both sides.
    fn cases(alphas: &[f32]) -> Vec<(Bsdf, f32, Vec3A)> {
        let lambert = (Bsdf::Lambert(Lambert { reflectance: TINT }), 1.0);
        let bsdfs = alphas.iter().flat_map(|a| all_and_brushed(*a)).chain([lambert]);
        bsdfs
            .flat_map(|(b, ior)| [1.0, 0.7, 0.3, 0.05, -0.05, -0.5, -0.9].map(|cos| (b, ior, direction(normal(), cos))))
            .collect()
    }

    /// Cells of equal polar angle and azimuth about the normal; the horizon is a border.
    const ROWS: usize = 20;
    const COLUMNS: usize = 40;

    /// A rectangle of (polar angle, azimuth).
    #[derive(Clone, Copy)]
    struct Patch {
        corner: [f64; 2],
        size: [f64; 2],
    }

    impl Patch {
        fn quarters(self) -> [Self; 4] {
            let size = self.size.map(|s| 0.5 * s);
            [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]
                .map(|q| Self { corner: [self.corner[0] + q[0] * size[0], self.corner[1] + q[1] * size[1]], size })
        }

        /// ∫ g dω by 3 × 3 Gauss–Legendre nodes.
        fn gauss<const N: usize>(self, n: Vec3A, g: &impl Fn(Vec3A) -> [f64; N]) -> [f64; N] {
            let offset = 0.5 * 0.6f64.sqrt();
            let nodes = [(0.5 - offset, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + offset, 5.0 / 18.0)];
            let mut sum = [0.0; N];
            for (x, wx) in nodes {
                let theta = self.corner[0] + x * self.size[0];
                for (y, wy) in nodes {
                    let values = g(spherical(n, theta.cos(), self.corner[1] + y * self.size[1]));
                    let weight = wx * wy * self.size[0] * self.size[1] * theta.sin();
                    (0..N).for_each(|k| sum[k] += weight * values[k]);
                }
            }
            sum
        }

        /// ∫ g dω, halving until `whole` and the sum of the quarters agree.
        fn refine<const N: usize>(
            self,
            n: Vec3A,
            whole: [f64; N],
            depth: u32,
            g: &impl Fn(Vec3A) -> [f64; N],
        ) -> [f64; N] {
            let quarters = self.quarters().map(|q| (q, q.gauss(n, g)));
            let sum: [f64; N] = std::array::from_fn(|k| quarters.iter().map(|q| q.1[k]).sum());
            let agree = (0..N).all(|k| (sum[k] - whole[k]).abs() <= 1e-6 + 1e-4 * sum[k].abs());
            if depth >= 6 || (depth >= 1 && agree) {
                return sum;
            }
            let parts = quarters.map(|(q, value)| q.refine(n, value, depth + 1, g));
            std::array::from_fn(|k| parts.iter().map(|p| p[k]).sum())
        }
    }

    /// ∫ g dω over each cell.
    fn cell_integrals<const N: usize>(n: Vec3A, g: &impl Fn(Vec3A) -> [f64; N]) -> Vec<[f64; N]> {
        let size = [PI / ROWS as f64, TAU / COLUMNS as f64];
        (0..ROWS * COLUMNS)
            .map(|i| Patch { corner: [(i / COLUMNS) as f64 * size[0], (i % COLUMNS) as f64 * size[1]], size })
            .map(|patch| patch.refine(n, patch.gauss(n, g), 0, g))
            .collect()
    }

    /// ∫ g dω over the sphere.
    fn sphere_integral<const N: usize>(n: Vec3A, g: &impl Fn(Vec3A) -> [f64; N]) -> [f64; N] {
        let cells = cell_integrals(n, g);
        std::array::from_fn(|k| cells.iter().map(|c| c[k]).sum())
    }

    fn cell(n: Vec3A, d: Vec3A) -> usize {
        let (s, t) = crate::transport::geometry::math::frame(n);
        let (x, y, z) = (d.dot(s) as f64, d.dot(t) as f64, d.dot(n) as f64);
        let row = (x.hypot(y).atan2(z) / PI * ROWS as f64) as usize;
        let column = (y.atan2(x).rem_euclid(TAU) / TAU * COLUMNS as f64) as usize;
        row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)
    }

    /// p-value of Pearson's χ² of `sample` against `pdf`; absorption is one more cell, the rare cells are joined.
    fn chi2_p(b: &Bsdf, given: Vec3A, draws: usize, seed: u64, pdf: &impl Fn(Vec3A) -> f64) -> f64 {
        let n = normal();
        let mut expected: Vec<f64> = cell_integrals(n, &|d| [pdf(d)]).iter().map(|c| c[0]).collect();
        expected.push(1.0 - expected.iter().sum::<f64>());
        let mut seen = vec![0.0; expected.len()];
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        for _ in 0..draws {
            let at = b.sample(n, given, uniform3(&mut rng)).map_or(ROWS * COLUMNS, |d| cell(n, d));
            seen[at] += 1.0;
        }
        let (mut statistic, mut cells, mut rare) = (0.0, 0, (0.0, 0.0));
        for (p, o) in expected.iter().zip(&seen) {
            let e = p * draws as f64;
            if e < 8.0 {
                rare = (rare.0 + e, rare.1 + o);
            } else {
                statistic += (o - e) * (o - e) / e;
                cells += 1;
            }
        }
        let e = rare.0.max(8.0);
        statistic += (rare.1 - rare.0) * (rare.1 - rare.0) / e;
        ChiSquared::new(cells as f64).unwrap().sf(statistic)
    }

    /// Level of each of `tests` tests, so that all together are falsely rejected once in a hundred.
    fn sidak(tests: usize) -> f64 {
        1.0 - (1.0f64 - 0.01).powf(1.0 / tests as f64)
    }

    #[test]
    fn samples_follow_pdf() {
        let n = normal();
        let cases = cases(&[0.05, 0.3, 0.8]);
        for (i, (b, _, given)) in cases.iter().enumerate() {
            let p = chi2_p(b, *given, 100_000, i as u64, &|d| b.pdf(n, *given, d) as f64);
            assert!(p > sidak(cases.len()), "p = {p:.2e}: {b:?} at cosθ = {}", n.dot(*given));
        }
    }

    /// 5 % too much of the transmitted lobe must show.
    #[test]
    fn wrong_pdf_is_found() {
        let n = normal();
        let given = direction(n, 0.7);
        for alpha in [0.05, 0.8] {
            for (b, _) in &all(alpha)[2..] {
                let wrong = |d: Vec3A| b.pdf(n, given, d) as f64 * if n.dot(d) < 0.0 { 1.05 } else { 1.0 };
                let p = chi2_p(b, given, 400_000, 5, &wrong);
                assert!(p < sidak(147), "p = {p:.2e}: {b:?}");
            }
        }
    }

    #[test]
    fn reciprocal_up_to_radiance_scaling() {
        let n = normal();
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        for alpha in [1e-3, 0.05, 0.3, 0.8] {
            for (b, ior) in all_and_brushed(alpha) {
                let eta2 = |v: Vec3A| if n.dot(v) > 0.0 { 1.0 } else { ior * ior };
                for _ in 0..2_000 {
                    let e = direction(n, 2.0 * uniform(&mut rng) - 1.0);
                    let Some(l) = b.sample(n, e, uniform3(&mut rng)) else { continue };
                    let (there, back) = (b.eval(n, l, e) / eta2(e), b.eval(n, e, l) / eta2(l));
                    assert!((0..3).all(|c| close(there[c], back[c], 1e-4)), "{b:?}: {there} {back}");
                }
            }
        }
    }

    /// Light that leaves along `eye` under radiance η² from everywhere is as much as a beam that comes along `eye` scatters.
    #[test]
    fn energy_is_kept_and_sampling_agrees_with_quadrature() {
        let n = normal();
        for (i, (b, ior, eye)) in cases(&[0.05, 0.3, 0.8]).into_iter().enumerate() {
            let eta2 = |v: Vec3A| if n.dot(v) > 0.0 { 1.0 } else { ior * ior };
            let furnace = |l: Vec3A| (b.eval(n, l, eye) * (n.dot(l).abs() * eta2(l) / eta2(eye))).as_dvec3().to_array();
            let beam = |e: Vec3A| (b.eval(n, eye, e) * n.dot(e).abs()).as_dvec3().to_array();
            let both = sphere_integral(n, &|d| {
                let (f, b) = (furnace(d), beam(d));
                [f[0], f[1], f[2], b[0]]
            });
            assert!(both[0] <= 1.0 + 3e-3, "{b:?} at {}: {both:?}", n.dot(eye));
            assert!((both[0] - both[3]).abs() < 1e-3 * both[0], "{b:?}: {both:?}");

            let mut rng = Pcg64Mcg::seed_from_u64(i as u64);
            let draws = 20_000;
            let (mut sum, mut sum2) = (0.0, 0.0);
            for _ in 0..draws {
                let d = b.sample(n, eye, uniform3(&mut rng)).filter(|d| b.pdf(n, eye, *d) > 0.0);
                let w = d.map_or(0.0, |d| furnace(d)[1] / b.pdf(n, eye, d) as f64);
                (sum, sum2) = (sum + w, sum2 + w * w);
            }
            let mean = sum / draws as f64;
            let se = ((sum2 / draws as f64 - mean * mean).max(0.0) / draws as f64).sqrt();
            assert!((mean - both[1]).abs() < 4.5 * se + 1e-3 * mean, "{b:?}: {mean} ± {se}, {}", both[1]);
        }
    }

    /// The share of a beam along `given` that a surface of values `eval` scatters, ∫ f |cosθ| dω, and its standard error: by
    /// quadrature of wide lobes on one side, else the mean of f |cosθ|/p over `b`'s samples.
    fn scattered(b: &Bsdf, given: Vec3A, roughness: f32, eval: impl Fn(Vec3A) -> Rgb) -> [glam::DVec3; 2] {
        let n = normal();
        let value = |d: Vec3A| (eval(d) * n.dot(d).abs()).as_dvec3();
        if roughness >= 0.3 && !matches!(b, Bsdf::RoughDielectric(_)) {
            return [sphere_integral(n, &|d| value(d).to_array()).into(), glam::DVec3::ZERO];
        }
        let mut rng = Pcg64Mcg::seed_from_u64(21);
        let (draws, mut sum, mut sum2) = (20_000, glam::DVec3::ZERO, glam::DVec3::ZERO);
        for _ in 0..draws {
            let drawn = b.sample(n, given, uniform3(&mut rng)).map(|d| (d, f64::from(b.pdf(n, given, d))));
            let weight = drawn.filter(|(_, p)| *p > 0.0).map_or(glam::DVec3::ZERO, |(d, p)| value(d) / p);
            (sum, sum2) = (sum + weight, sum2 + weight * weight);
        }
        let mean = sum / f64::from(draws);
        let variance = (sum2 / f64::from(draws) - mean * mean).max(glam::DVec3::ZERO);
        [mean, glam::DVec3::from_array((variance / f64::from(draws)).to_array().map(f64::sqrt))]
    }

    /// Materials without absorption at each roughness, seen from grazing to normal incidence, from both sides.
    fn white(roughnesses: &[f32], mut check: impl FnMut(Bsdf, Vec3A, f32)) {
        let metal = MetallicRoughness::default();
        let plastic = |ior, specular, specular_color| MetallicRoughness {
            metallic: 0.0,
            ior,
            specular,
            specular_color,
            ..metal.clone()
        };
        let wall = MetallicRoughness { transmission: 1.0, ..plastic(1.5, 1.0, Rgb::ONE) };
        let glass = |ior| MetallicRoughness { thin: false, ior, ..wall.clone() };
        let materials = [
            metal.clone(),
            plastic(1.0, 1.0, Rgb::ONE),
            plastic(1.5, 1.0, Rgb::ONE),
            plastic(1.5, 0.3, Rgb::new(1.0, 0.3, 0.0)),
            plastic(2.5, 1.0, Rgb::new(0.2, 1.0, 50.0)),
            MetallicRoughness { metallic: 0.3, transmission: 0.4, ..plastic(1.5, 0.8, Rgb::ONE) },
            wall.clone(),
            glass(1.05),
            glass(1.5),
            glass(0.7),
        ];
        for &roughness in roughnesses {
            for material in &materials {
                let b = MetallicRoughness { roughness, ..material.clone() }.bsdf();
                for cos in [0.02, 0.2, 1.0, -0.02, -0.7] {
                    check(b, direction(normal(), cos), roughness);
                }
            }
        }
    }

    /// In a furnace, what absorbs nothing shows radiance 1 at every roughness and angle.
    #[test]
    fn white_is_white() {
        let n = normal();
        white(&[0.0, 0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0], |b, given, roughness| {
            let [share, stderr] = scattered(&b, given, roughness, |d| b.eval(n, given, d));
            let off = (share - 1.0).abs() - 4.5 * stderr;
            assert!(off.max_element() < 3e-3, "{share} ± {stderr} at cosθ = {}: {b:?}", n.dot(given));
        });
    }

    /// So does brushed metal, and a white base under a brushed coat but at grazing angles, within what is told of the tables. Isotropic tables
    /// of the mean α are the control.
    #[test]
    fn white_is_white_where_it_is_brushed() {
        let (n, mut isotropic) = (normal(), 0.0f64);
        for [along, across] in [[0.3, 0.3], [1.0, 0.25], [0.57, 0.16], [0.1, 0.8], [0.4, 0.01]] {
            let facets = Facets::brushed(tangent(), [along, across]);
            let metal = Conductor::of(Rgb::ONE, 1.0, facets);
            let plastic = Glossy::new(Lambert { reflectance: Rgb::ONE }, Conductor::of(Rgb::splat(0.04), 1.0, facets));
            let lobes = [(Lobe::BrushedMetal(metal), 7e-3), (Lobe::BrushedCoat(plastic), 2e-2)];
            for (cos, azimuth) in [(0.03, 0.3), (0.2, 0.0), (0.2, 1.4), (0.6, 0.8), (-0.6, 2.5), (1.0, 0.0)] {
                let given = spherical(n, cos, azimuth);
                for (lobe, bound) in lobes {
                    let b = Bsdf::from(lobe);
                    // Samples where the lobe is narrow.
                    let [share, stderr] = scattered(&b, given, across.min(along).sqrt(), |d| b.eval(n, given, d));
                    let off = (share - 1.0).abs() - 4.5 * stderr;
                    assert!(
                        off.max_element() < bound,
                        "{along}, {across}: {share} ± {stderr} at {cos}, {azimuth}: {b:?}"
                    );
                }
                let iso = Facets::new(Ggx { alpha: (along * across).sqrt() }).lacking(n, given).white;
                isotropic = isotropic.max(f64::from((iso - facets.lacking(n, given).white).abs()));
            }
        }
        assert!(isotropic > 0.1, "{isotropic}");
    }

    /// A coat with a normal of its own over `mix`; white metal over nothing where `white`.
    fn tilted(alpha: f32, white: bool) -> Bsdf {
        let normal = Some((normal() + 0.3 * tangent()).normalize());
        let Bsdf::Mix(base) = mix(alpha) else { unreachable!() };
        let (f0, base) = if white { (1.0, Mix { lobes: [(0.0, None); 3] }) } else { (0.04, base) };
        let lobe = Conductor::new(Rgb::splat(f0), 1.0, Ggx { alpha });
        Bsdf::Layered(Layered { coat: Some(Coat { lobe, share: 1.0, normal }), sheen: None, base })
    }

    /// Samples follow the density, and no more leaves than comes. Where none of it is cut off, a white coat is white; without |ω·n_c|/|ω·n|
    /// it is not.
    #[test]
    fn a_coat_has_a_normal_of_its_own() {
        let n = normal();
        for (i, cos) in [1.0, 0.6, 0.1, -0.05, -0.7].into_iter().enumerate() {
            let (b, given) = (tilted(0.2, false), direction(n, cos));
            let p = chi2_p(&b, given, 100_000, i as u64, &|d| b.pdf(n, given, d) as f64);
            assert!(p > sidak(5), "p = {p:.2e} at cosθ = {cos}");
            let [share] = sphere_integral(n, &|l| [f64::from((b.eval(n, l, given) * n.dot(l).abs()).x)]);
            assert!(share <= 1.0 + 3e-3, "{share} at cosθ = {cos}");
        }
        let (b, own) = (tilted(0.05, true), (n + 0.3 * tangent()).normalize());
        let [share, wrong] = sphere_integral(n, &|l| {
            let value = f64::from((b.eval(n, l, n) * n.dot(l).abs()).x);
            [value, value * f64::from(n.dot(l) / own.dot(l).max(1e-3)).abs()]
        });
        assert!((share - 1.0).abs() < 3e-3 && wrong < 0.95, "{share} {wrong}");
    }

    /// With equal α brushed metal is metal.
    #[test]
    fn what_is_brushed_evenly_is_not_brushed() {
        let (n, mut rng) = (normal(), Pcg64Mcg::seed_from_u64(4));
        for alpha in [0.05, 0.3, 0.9] {
            let metal = Conductor::new(TINT, 1.0, Ggx { alpha });
            let brushed = Conductor::of(TINT, 1.0, Facets::brushed(tangent(), [alpha; 2]));
            for _ in 0..1000 {
                let e = direction(n, uniform(&mut rng));
                let Some(l) = metal.sample(n, e, uniform3(&mut rng)) else { continue };
                let (a, b) = (metal.evaluate(n, l, e), brushed.evaluate(n, l, e));
                let near = |a: f32, b: f32| (a - b).abs() < 0.02 * a.max(b) + 0.01;
                assert!(near(a.value.y, b.value.y) && near(a.pdf_to_eye, b.pdf_to_eye), "{a:?} {b:?}");
            }
        }
    }

    /// The same test finds what one scattering lacks, and what a base adds that does not know of its coat.
    #[test]
    fn white_is_not_white_without_its_terms() {
        let n = normal();
        let (mut least, mut greatest) = (1.0f64, 1.0f64);
        white(&[0.0, 1.0], |b, given, roughness| {
            let eval = |d: Vec3A| match &b {
                Bsdf::Conductor(metal) => {
                    Rgb::splat(metal.facets.ggx.reflection(n, given, d).map_or(0.0, |met| met.value))
                }
                Bsdf::RoughDielectric(glass) => glass.once.evaluate(n, given, d).value,
                Bsdf::Glossy(plastic) => plastic.coat.evaluate(n, given, d).value + plastic.base.eval(n, given, d),
                other => other.eval(n, given, d),
            };
            let [share, _] = scattered(&b, given, roughness, eval);
            (least, greatest) = (least.min(share.min_element()), greatest.max(share.max_element()));
        });
        assert!(least < 0.5 && greatest > 1.1, "{least} {greatest}");
    }

    /// f |cosθ|/p stays bounded where rounding of directions is as large as the lobe.
    #[test]
    fn weights_are_bounded_at_small_alpha() {
        let n = normal();
        let mut rng = Pcg64Mcg::seed_from_u64(99);
        for alpha in [1e-6, 1e-5, 1e-4, 1e-2] {
            for (b, ior) in all(alpha) {
                let eta2 = |v: Vec3A| if n.dot(v) > 0.0 { 1.0 } else { ior * ior };
                // Where m is mostly rounding, its share of samples, as small, has weights up to those of q at cosθ = 1.
                let bound = 2.0f32.max((1.0 + 1.0 / (alpha * alpha)).ln());
                for _ in 0..20_000 {
                    let e = direction(n, 2.0 * uniform(&mut rng) - 1.0);
                    let Some(d) = b.sample(n, e, uniform3(&mut rng)) else { continue };
                    let p = b.pdf(n, e, d) * eta2(e) / eta2(d);
                    assert!(b.eval(n, d, e).max_element() * n.dot(d).abs() <= bound * p, "{b:?} {e} {d}");
                }
            }
        }
    }

    #[test]
    fn rough_tends_to_smooth() {
        let n = normal();
        let mut rng = Pcg64Mcg::seed_from_u64(13);
        let (tint, ior) = (TINT, 1.5);
        let smooth = [
            Bsdf::Mirror(Mirror { f0: tint }),
            Bsdf::Dielectric(Dielectric { ior, tint }),
            Bsdf::Thin(Thin { ior, tint }),
        ];
        for alpha in [1e-4, 1e-6] {
            let rough = all(alpha);
            for (s, r) in smooth.iter().zip([0, 2, 4].map(|i| &rough[i])) {
                for cos in [1.0, 0.8, 0.3, -0.3, -0.8] {
                    let eye = direction(n, cos);
                    let mut albedo = |b: &Bsdf, draws: u32| {
                        let mut sum = Rgb::ZERO;
                        for _ in 0..draws {
                            if let Some(l) = b.sample(n, eye, uniform3(&mut rng)) {
                                sum += b.eval(n, l, eye) * n.dot(l).abs() / b.pdf(n, eye, l);
                            }
                        }
                        sum / draws as f32
                    };
                    let (s, r) = (albedo(s, 40_000), albedo(&r.0, 40_000));
                    assert!((s - r).abs().max_element() < 0.02, "α = {alpha}, cosθ = {cos}: {s} {r}");
                }
            }
        }
    }
}

/// A million inputs, many of them degenerate: no NaN, no infinity, no negative number.
#[test]
fn finite_whatever_the_input() {
    let mut rng = Pcg64Mcg::seed_from_u64(17);
    let factor = |rng: &mut Pcg64Mcg| [0.0, 1e-3, 0.03, 0.5, 1.0][rng.next_u32() as usize % 5];
    let bsdfs: Vec<Bsdf> = (0..1000)
        .map(|_| {
            let m = MetallicRoughness {
                base_color: Rgb::new(0.9, factor(&mut rng), 0.1),
                metallic: factor(&mut rng).round(),
                roughness: factor(&mut rng),
                ior: [0.0, 0.7, 1.0, 1.0011, 1.5, 2.4][rng.next_u32() as usize % 6],
                specular: factor(&mut rng),
                specular_color: Rgb::ONE,
                transmission: factor(&mut rng),
                thin: rng.next_u32() % 2 == 0,
                clearcoat: factor(&mut rng),
                clearcoat_roughness: factor(&mut rng),
                sheen_color: Rgb::splat(factor(&mut rng).round()),
                sheen_roughness: factor(&mut rng),
                anisotropy: Anisotropy::default(),
            };
            m.bsdf()
        })
        .collect();
    for i in 0..1_000_000 {
        let n = random_direction(&mut rng, Vec3A::X, Vec3A::X);
        let alphas = [factor(&mut rng), factor(&mut rng)];
        let facets = Facets::brushed(n.any_orthonormal_vector(), alphas);
        let brushed = Bsdf::from(Lobe::BrushedMetal(Conductor::of(Rgb::new(0.9, 0.5, 0.0), 1.0, facets)));
        let b = if i % 8 == 0 { &brushed } else { &bsdfs[i % bsdfs.len()] };
        let given = random_direction(&mut rng, n, n);
        let other = random_direction(&mut rng, n, given);
        let u = uniform3(&mut rng).map(|u| {
            if u < 0.05 {
                0.0
            } else if u > 0.95 {
                1.0 - f32::EPSILON / 2.0
            } else {
                u
            }
        });
        let sampled = b.sample(n, given, u);
        for d in sampled.into_iter().chain([other]) {
            assert!((d.length() - 1.0).abs() < 1e-5, "{b:?}: {d}");
            let (f, p) = (b.eval(n, d, given), b.pdf(n, given, d));
            assert!(f.is_finite() && f.min_element() >= 0.0, "{b:?} {n} {given} {d}: {f}");
            assert!(p.is_finite() && p >= 0.0, "{b:?} {n} {given} {d}: {p}");
            assert!(p > 0.0 || f == Rgb::ZERO, "{b:?} {n} {given} {d}: {f} can never be drawn");
            assert!((0.0..=1.0).contains(&b.event_probability(n, given, d)));
        }
        if let Some(d) = sampled.filter(|d| b.pdf(n, given, *d) > 0.0) {
            let weight = b.eval(n, d, given) * (n.dot(d).abs() / b.pdf(n, given, d));
            // η² = 5.76, times the greatest weight of q.
            assert!(
                weight.max_element() < 5.8 * (1.0 + 1.0 / (SMOOTH_ALPHA * SMOOTH_ALPHA)).ln(),
                "{b:?} {n} {given} {d}: {weight}"
            );
        }
    }
}

/// Uniform, or one of `n`, -`n`, ±`v`, a tangent to `n`, and directions within a few roundings of those.
fn random_direction(rng: &mut Pcg64Mcg, n: Vec3A, v: Vec3A) -> Vec3A {
    let mut uniform_direction = || {
        let d = Vec3A::from_array(uniform3(rng)) * 2.0 - 1.0;
        d.try_normalize().unwrap_or(Vec3A::Z)
    };
    let (free, noise) = (uniform_direction(), uniform_direction());
    let d = match rng.next_u32() % 8 {
        0 => n,
        1 => -n,
        2 => -v,
        3 => n.cross(free),
        4 => fresnel::reflect(v, n),
        _ => free,
    };
    let noise = noise * [0.0, 0.0, 1e-7, 1e-5, 1e-3][rng.next_u32() as usize % 5];
    (d + noise).try_normalize().unwrap_or(Vec3A::Z)
}
