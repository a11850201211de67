//! Lights, their parts, and the way from a point to its part.

use super::worlds::{Builder, World, ball, glass, lambert, mirror, quad, two_lights};
use crate::engine::{Importance, Purpose, Stratum, generator, uniform};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Mesh;
use crate::transport::lights::{Cell, LightRegion, LightStrata, Stratification};
use crate::transport::methods::metropolis::LightStratum;
use crate::transport::paths::mis::met_by_chance;
use crate::transport::paths::{Classes, LightPath, Luminance};
use crate::transport::scene::Scene;
use crate::transport::scene::light::{Area, Shape};
use glam::{DVec2, DVec3};

const CUTS: [Stratification; 4] =
    [Stratification::None, Stratification::Grid(1, 1), Stratification::Grid(2, 2), Stratification::Grid(5, 3)];

/// A rectangle, a triangle and a ball, all of them lights.
fn lights() -> World {
    let v = DVec3::new;
    let kite = quad([v(0., 0., 0.), v(1., 0.2, 0.), v(1., 1., 0.), v(0.2, 1., 0.)]);
    Builder::default()
        .light(quad([v(0., 2., 0.), v(2., 2., 0.), v(2.5, 3., 0.), v(0.5, 3., 0.)]), Rgb::new(1.0, 2.0, 3.0), false)
        .light(kite, Rgb::splat(0.5), true)
        .light(ball(v(3.0, 0.0, -1.0), 0.7, true), Rgb::splat(2.0), false)
        .seen(v(0., 0., 9.), DVec3::ZERO, 40.0, [8, 8])
}

#[test]
fn a_point_drawn_in_a_part_lies_in_that_part() {
    for world in [lights(), two_lights(lambert(Rgb::ONE), lambert(Rgb::ONE))] {
        let scene = &world.scene;
        for cut in CUTS {
            let strata = LightStrata::new(scene.lights(), cut);
            let mut rng = generator(3, Purpose::Sample, 0, 0, 0);
            for (j, region) in (0..).zip(strata.regions()) {
                for _ in 0..500 {
                    let point = region.sample(uniform(&mut rng), uniform(&mut rng));
                    assert_eq!(strata.index(&point), j, "{cut:?}");
                }
                for corner in [(0.0, 0.0), (1.0 - f64::EPSILON, 1.0 - f64::EPSILON)] {
                    assert_eq!(strata.index(&region.sample(corner.0, corner.1)), j, "{cut:?}");
                }
            }
        }
    }
}

#[test]
fn coordinates_lead_back_from_a_position() {
    let world = lights();
    let lights = world.scene.lights();
    assert_eq!(lights.lights.len(), 3);
    let region = LightRegion::whole(lights);
    let mut rng = generator(4, Purpose::Sample, 0, 0, 0);
    for _ in 0..3000 {
        let point = region.sample(uniform(&mut rng), uniform(&mut rng));
        let (_, vertex) = world.scene.light_point(&point);
        let back = lights.point(vertex.primitive, vertex.position).unwrap();
        assert_eq!(back.light, point.light);
        assert!((back.u - point.u).abs() < 2e-6, "{point:?} {back:?}");
        // At a triangle's corner all v are one point.
        let (_, again) = world.scene.light_point(&back);
        assert!(again.position.distance(vertex.position) < 2e-6, "{point:?} {back:?}");
    }
}

/// ∫ M/power dA over a region is the share of it that a mesh's parts sum to; the parts of one light are equal.
#[test]
fn parts_share_a_light_equally() {
    let world = lights();
    let lights = world.scene.lights();
    for cut in CUTS {
        let strata = LightStrata::new(lights, cut);
        let powers: Vec<f64> = strata.regions().iter().map(LightRegion::power).collect();
        assert!((powers.iter().sum::<f64>() / lights.power() - 1.0).abs() < 1e-12);
        if cut != Stratification::None {
            let parts = powers.len() / lights.lights.len();
            for (light, powers) in lights.lights.iter().zip(powers.chunks(parts)) {
                powers.iter().for_each(|p| assert!((p * parts as f64 / light.power() - 1.0).abs() < 1e-12));
            }
        }
    }
}

/// A uniform point of a light's surface, found without its map, falls into each of 15 parts equally often.
#[test]
fn parts_have_equal_area() {
    let world = lights();
    let scene: &Scene = &world.scene;
    let strata = LightStrata::new(scene.lights(), Stratification::Grid(5, 3));
    let mut rng = generator(5, Purpose::Sample, 0, 0, 0);
    let n = 60_000;
    for (id, light) in scene.lights().lights.iter().enumerate() {
        let mut counts = [0f64; 15];
        for _ in 0..n {
            let (primitive, position) = surface_point(scene, id, light.measure, &mut rng);
            let point = scene.lights().point(primitive, position.into()).unwrap();
            counts[strata.index(&point) as usize - 15 * id] += 1.0;
        }
        let expected = f64::from(n) / 15.0;
        let chi2: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
        assert!(chi2 < 45.0, "light {id}: χ² = {chi2} with 14 degrees of freedom, {counts:?}");
    }
}

/// A uniform point of a light, by rejection over its triangles' bounding parallelograms.
fn surface_point(scene: &Scene, light: usize, area: f64, rng: &mut crate::engine::Generator) -> (u32, glam::Vec3) {
    let triangles: Vec<(u32, [glam::Vec3; 3])> = match &scene.lights().lights[light].shape {
        &Shape::Area(Area::Parallelogram { origin, edges: [e, f], primitives: [first, second] }) => {
            vec![(first, [origin, origin + e, origin + f]), (second, [origin + e + f, origin + f, origin + e])]
        }
        Shape::Area(Area::Even(even)) => even.primitives.iter().copied().zip(even.vertices.iter().copied()).collect(),
        _ => Vec::new(),
    };
    let mut remaining = uniform(rng) * area;
    for (primitive, [a, b, c]) in triangles {
        remaining -= 0.5 * f64::from((b - a).cross(c - a).length());
        if remaining <= 0.0 {
            let (mut u, mut v) = (uniform(rng) as f32, uniform(rng) as f32);
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            return (primitive, a + u * (b - a) + v * (c - a));
        }
    }
    surface_point(scene, light, area, rng)
}

#[test]
fn points_of_a_region_have_density_in_proportion_to_exitance() {
    let world = lights();
    let lights = world.scene.lights();
    let half = |light, low, high| Cell { light, low: DVec2::new(low, 0.0), high: DVec2::new(high, 1.0) };
    let cells = vec![half(0, 0.0, 0.25), half(1, 0.5, 1.0), half(2, 0.0, 1.0)];
    let region = LightRegion::new(lights, cells);
    let n = 100_000;
    let mut rng = generator(6, Purpose::Sample, 0, 0, 0);
    let mut counts = [0.0; 3];
    (0..n).for_each(|_| counts[region.sample(uniform(&mut rng), uniform(&mut rng)).light as usize] += 1.0);
    for (cell, count) in region.cells().iter().zip(counts) {
        let p = cell.power(&lights.lights) / region.power();
        let z = (count - p * f64::from(n)) / (p * (1.0 - p) * f64::from(n)).sqrt();
        assert!(f64::abs(z) < 4.0, "light {}: {count} of {n}, p = {p}", cell.light);
    }
}

fn is_rectangle(mesh: Mesh) -> bool {
    let world = Builder::default().light(mesh, Rgb::ONE, false).seen(DVec3::Z, DVec3::ZERO, 40.0, [8, 8]);
    let [light] = &world.scene.lights().lights[..] else { return false };
    matches!(light.shape, Shape::Area(Area::Parallelogram { .. }))
}

#[test]
fn two_triangles_are_a_rectangle_only_if_they_form_a_parallelogram() {
    let v = |x, y| DVec3::new(x, y, 0.0);
    let square = [v(0., 0.), v(1., 0.), v(1., 1.), v(0., 1.)];
    assert!(is_rectangle(quad(square)));
    assert!(is_rectangle(quad([v(0., 0.), v(1., 0.), v(1.5, 1.), v(0.5, 1.)])), "a slanted one");
    assert!(!is_rectangle(quad([v(0., 0.), v(1., 0.), v(1.3, 1.3), v(0., 1.)])), "a kite");
    for triangles in [[[1, 2, 0], [3, 0, 2]], [[0, 1, 3], [1, 2, 3]], [[2, 1, 0], [3, 2, 0]]] {
        assert!(is_rectangle(Mesh { triangles: triangles.to_vec(), ..quad(square) }), "{triangles:?}");
    }
    let opposed = Mesh { triangles: vec![[0, 1, 2], [0, 3, 2]], ..quad(square) };
    assert!(!is_rectangle(opposed), "triangles that face opposite ways");
    let folded = quad([v(0., 0.), v(1., 0.), v(1., 1.), DVec3::new(0.3, 0.3, 1.0)]);
    assert!(!is_rectangle(folded), "not in one plane");
}

#[test]
fn a_rectangle_emits_from_the_side_of_its_winding() {
    let v = |x, y| DVec3::new(x, y, 0.0);
    for flip in [false, true] {
        let mut corners = [v(0., 0.), v(1., 0.), v(1., 1.), v(0., 1.)];
        if flip {
            corners.reverse();
        }
        let world = Builder::default().light(quad(corners), Rgb::ONE, false).seen(DVec3::Z, DVec3::ZERO, 40.0, [8, 8]);
        let (_, vertex) = world.scene.light_point(&Default::default());
        assert_eq!(vertex.geometric_normal.z, if flip { -1.0 } else { 1.0 });
        assert_eq!(world.scene.emitted(&vertex, glam::Vec3A::Z) == Rgb::ZERO, flip);
    }
}

/// ∫ I over the paths that strata hold, those that some connection makes and those that only chance meets, each with the variance of
/// its estimate.
fn held(strata: &[LightStratum], samples: u64) -> [[f64; 2]; 2] {
    let mut held = [[0.0; 2]; 2];
    for (j, stratum) in (0..).zip(strata) {
        let mut moments = [[0.0; 2]; 2];
        for i in 0..samples {
            let mut sums = [0.0; 2];
            stratum.sample(&mut generator(8, Purpose::Sample, 0, j, i), &mut |path: &LightPath, weight| {
                assert_eq!(strata.iter().filter(|other| other.contains(path)).count(), 1, "of all strata");
                sums[usize::from(met_by_chance(path.vertices()))] += weight * Luminance.eval(path);
            });
            for (moments, sum) in moments.iter_mut().zip(sums) {
                *moments = [moments[0] + sum, moments[1] + sum * sum];
            }
        }
        let n = samples as f64;
        for (held, [sum, squares]) in held.iter_mut().zip(moments) {
            *held = [held[0] + sum / n, held[1] + (squares - sum * sum / n) / (n * n)];
        }
    }
    held
}

/// Cut strata are a partition and hold what all of path space holds, of what only chance meets as well. The control is without the
/// strata of that.
#[test]
fn what_chance_meets_is_held_apart_and_whole() {
    let world = two_lights(glass(0.0), mirror());
    let none = LightStrata::new(world.scene.lights(), Stratification::None);
    let cut = LightStrata::new(world.scene.lights(), Stratification::Grid(2, 2));
    let whole = held(&LightStratum::all(&none, world.view(), 12), 100_000);
    for (lengths, tiles) in [(false, [1, 1]), (true, [2, 1])] {
        let strata = LightStratum::product(&cut, world.view(), 12, Classes { lengths, tiles });
        let z = |found: [[f64; 2]; 2]| [0, 1].map(|m| (found[m][0] - whole[m][0]) / (found[m][1] + whole[m][1]).sqrt());
        let found = held(&strata, 20_000);
        assert!(z(found).iter().all(|z| z.abs() < 4.0), "{found:?}, whole {whole:?}");
        let connected: Vec<_> = strata.into_iter().filter(|stratum| !stratum.is_met()).collect();
        let [others, met] = z(held(&connected, 20_000));
        assert!(others.abs() < 4.0 && met < -4.0, "{others}, {met}");
    }
}
