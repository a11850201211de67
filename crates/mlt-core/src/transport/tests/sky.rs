//! Light from afar, environments and suns: its distribution, and closed forms.

use super::worlds::{
    Builder, World, ball, beams, brushed, cloudy, glass, glossy, lambert, lamps_and_sky, mirror, outdoors, quad,
    spotted_pane, suns,
};
use crate::check::{self, Trials};
use crate::engine::{Generator, Purpose, generator, uniform, uniform_f32};
use crate::transport::colour::{Rgb, luminance};
use crate::transport::image::mean_luminance;
use crate::transport::lights::{LightRegion, LightStrata, Stratification};
use crate::transport::methods::metropolis::LightStratum;
use crate::transport::methods::{Method, Settings};
use crate::transport::paths::mis::Ends;
use crate::transport::paths::subpath::{
    light_numbers, start_at_eye, start_at_light, start_near, step_from_eye, step_from_light,
};
use crate::transport::paths::{LightPath, Luminance, PathVertex, mis, set_scattering};
use crate::transport::render::Renderer;
use crate::transport::scene::light::{Light, Shape};
use crate::transport::scene::{Environment, Punctual};
use glam::{DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// A floor that fills the image, under some light, seen from above.
fn floor_under(light: impl FnOnce(Builder) -> Builder) -> World {
    let v = DVec3::new;
    let floor = quad([v(-1., 0., 1.), v(1., 0., 1.), v(1., 0., -1.), v(-1., 0., -1.)]);
    light(Builder::default().surface(floor, lambert(Rgb::splat(0.5)))).seen(v(0.1, 1.0, 0.2), DVec3::ZERO, 40.0, [4, 4])
}

/// A floor under an environment.
fn floor(environment: Environment) -> World {
    floor_under(|builder| builder.under(environment))
}

/// A floor under suns, given by the height of their middles, their angles and irradiances, all in one plane, and a sky of radiance ½.
fn sunlit(suns: &[(f32, f32, f32)]) -> World {
    let sun = |&(height, angle, irradiance): &(f32, f32, f32)| {
        let along = -Vec3::new(height.cos(), height.sin(), 0.0);
        (Rgb::splat(irradiance), Punctual::Directional { along, angle })
    };
    floor_under(|builder| builder.lit_by(suns.iter().map(sun)).under(Environment::constant(Rgb::splat(0.5))))
}

/// An image that is bright above and dark below, or the other way round.
fn halves(above: f32, below: f32) -> Environment {
    let pixels = (0..512).map(|i| Rgb::splat(if i < 256 { above } else { below })).collect();
    Environment::image([1, 512], pixels).expect("as many pixels as it says").0
}

fn radiance(light: &Light, direction: Vec3) -> f64 {
    let Shape::Environment(around) = &light.shape else { panic!("an environment") };
    f64::from(luminance(around.radiance(direction)))
}

/// ∫ radiance dω over 16 × 16 cells of equal solid angle; `measure`: dω over dz dφ, which is 1.
fn power_of_cells(light: &Light, measure: impl Fn(f64) -> f64) -> Vec<f64> {
    const FINE: usize = 24;
    let mut cells = vec![0.0; 256];
    for (i, j) in (0..16 * FINE).flat_map(|i| (0..16 * FINE).map(move |j| (i, j))) {
        let at = |i: usize| (i as f64 + 0.5) / (16 * FINE) as f64;
        let (z, azimuth) = (1.0 - 2.0 * at(i), TAU * at(j) - PI);
        let sin = (1.0 - z * z).sqrt();
        let direction = DVec3::new(sin * azimuth.cos(), z, sin * azimuth.sin()).as_vec3();
        cells[i / FINE * 16 + j / FINE] += radiance(light, direction) * measure(z);
    }
    let sum: f64 = cells.iter().sum();
    cells.into_iter().map(|cell| cell / sum).collect()
}

/// χ² of directions drawn by power, against the image's integral over cells: with density L dω, and, as a control, with densities per
/// angle from the top instead of per height.
#[test]
fn directions_are_drawn_in_proportion_to_luminance() {
    let world = floor(cloudy());
    let lights = world.scene.lights();
    let (light, region) = (&lights.lights[0], LightRegion::whole(lights));
    let mut rng = generator(1, Purpose::Sample, 0, 0, 0);
    let (n, mut counts) = (100_000, vec![0.0; 256]);
    for _ in 0..n {
        let point = region.sample(uniform(&mut rng), uniform(&mut rng));
        let direction = world.scene.light_point(&point).1.position;
        let row = (8.0 * (1.0 - direction.y)).clamp(0.0, 15.0) as usize;
        let column = (16.0 * (f64::from(direction.z.atan2(direction.x)) / TAU + 0.5)).clamp(0.0, 15.0) as usize;
        counts[row * 16 + column] += 1.0;
    }
    let chi2 = |cells: &[f64]| -> f64 {
        counts
            .iter()
            .zip(cells)
            .map(|(count, p): (&f64, _)| (count - p * f64::from(n)).powi(2) / (p * f64::from(n)))
            .sum()
    };
    let found = chi2(&power_of_cells(light, |_| 1.0));
    assert!(found < 340.0, "χ² = {found} with 255 degrees of freedom");
    let wrong = chi2(&power_of_cells(light, |z| (1.0 - z * z).max(0.0).sqrt().recip().min(10.0)));
    assert!(wrong > 1000.0, "χ² = {wrong} without the sine");
}

#[test]
fn a_direction_leads_back_to_its_point_of_the_square() {
    for environment in [cloudy(), Environment::sky(), Environment::constant(Rgb::ONE), halves(1.0, 0.0)] {
        let world = floor(environment);
        let lights = world.scene.lights();
        let mut rng = generator(2, Purpose::Sample, 0, 0, 0);
        for _ in 0..3000 {
            let (u, v) = (uniform(&mut rng), uniform(&mut rng));
            let point = LightRegion::whole(lights).sample(u, v);
            let (light, vertex) = world.scene.light_point(&point);
            assert!((vertex.position.length() - 1.0).abs() < 1e-6 && radiance(light, vertex.position.into()) > 0.0);
            let back = lights.point(vertex.primitive, vertex.position).expect("on the environment");
            let off = |a: f64, b: f64| (a - b).abs().min(1.0 - (a - b).abs());
            // Around the poles azimuths are all one place.
            let near_pole = vertex.position.y.abs() > 0.999;
            assert!(off(point.u, back.u) < 2e-5 && (near_pole || off(point.v, back.v) < 2e-5), "{point:?} {back:?}");
        }
    }
}

/// Density of M/Φ integrates to 1 over directions, and the sky is 5/9 in the mean.
#[test]
fn power_is_the_integral_of_exitance() {
    for (environment, mean) in [(Environment::sky(), 5.0 / 9.0), (Environment::constant(Rgb::splat(0.25)), 0.25)] {
        let world = floor(environment);
        let [light] = &world.scene.lights().lights[..] else { panic!("one light") };
        assert!((f64::from(luminance(light.emission)) / mean - 1.0).abs() < 2e-3, "{}", light.emission);
        let radius = f64::from(world.scene.sphere().radius);
        let power = 4.0 * PI * f64::from(luminance(light.emission)) * PI * radius * radius;
        assert!((light.power() / power - 1.0).abs() < 1e-6);
    }
}

/// One technique's estimate of the light that a floor reflects at once: the mean over samples, and its standard error. Densities
/// are taken `wrong`(path) times too large.
fn alone(world: &World, s: usize, wrong: impl Fn(&LightPath) -> f64) -> [f64; 2] {
    let (view, region) = (world.view(), LightRegion::whole(world.scene.lights()));
    let sample = |path: &mut LightPath, rng: &mut Generator| -> Option<f64> {
        path.vertices = vec![PathVertex::new(view.camera.vertex()); 3];
        let film = Vec2::new(uniform_f32(rng), uniform_f32(rng));
        path.cross(&view, film);
        if s == 2 {
            (path.vertices[0], path.light) = start_at_light(&view, &region, light_numbers(rng));
            step_from_light(&mut path.vertices, 0, &view, rng)?;
        } else {
            start_at_eye(&mut path.vertices, 2, film, &view, rng)?;
            set_scattering(&mut path.vertices, 2, &view)?;
        }
        if s == 1 {
            let x_1 = path.vertices[1];
            (path.vertices[0], path.light, _) = start_near(&view, &region, &x_1, light_numbers(rng));
        }
        if s == 0 {
            step_from_eye(&mut path.vertices, 1, &view, rng)?;
            let x = &path.vertices[0].vertex;
            path.light = view.scene.lights().point(x.primitive, x.position)?;
            path.update(&view, 0..=2)?;
        } else {
            path.connect(&view, s, 0..=2)?;
        }
        let ends = Ends::new(path, &view, &region, 1.0);
        Some(path.contribution().x / (mis::density(path.vertices(), s, ends) * wrong(path)))
    };
    let (n, mut path) = (40_000, LightPath::default());
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..n {
        let value = sample(&mut path, &mut generator(3, Purpose::Sample, 0, s as u64, i)).unwrap_or(0.0);
        (sum, squares) = (sum + value, squares + value * value);
    }
    let mean = sum / n as f64;
    [mean, ((squares / n as f64 - mean * mean) / n as f64).sqrt()]
}

/// Each technique by itself: met by chance, drawn for the floor, and sent from the disc. A floor of albedo ρ under a sky of radiance L
/// shows ρ L; so it does under its upper half, and nothing under its lower one.
#[test]
fn each_technique_alone_finds_what_a_floor_reflects() {
    for s in 0..3 {
        for (environment, expected) in [
            (Environment::constant(Rgb::splat(2.0)), 1.0),
            (halves(2.0, 0.0), 1.0),
            // E/π of (5 + 4 cosθ′)/9 is 5/9 + 4/9 · ⅔ times the cosine of the brightest direction with the normal.
            (Environment::sky(), 0.5 * (5.0 + 4.0 * 2.0 / 3.0 * 0.8003) / 9.0),
        ] {
            let [mean, error] = alone(&floor(environment), s, |_| 1.0);
            assert!((mean - expected).abs() < 4.0 * error + 2e-3 * expected, "s = {s}: {mean} ± {error}, {expected}");
        }
        let [dark, _] = alone(&floor(halves(0.0, 2.0)), s, |_| 1.0);
        assert!(dark < 1e-2, "s = {s}: {dark}");
    }
}

/// The controls: without π R², and without the cosine at the floor, what is sent from the disc is wrong.
#[test]
fn a_wrong_density_of_what_is_sent_is_seen() {
    let world = floor(Environment::constant(Rgb::splat(2.0)));
    let area = world.scene.sphere().pdf();
    let off = |wrong: &dyn Fn(&LightPath) -> f64| {
        let [mean, error] = alone(&world, 2, wrong);
        (mean - 1.0).abs() / error
    };
    assert!(off(&|_| 1.0 / f64::from(area)) > 10.0, "without π R²");
    assert!(off(&|path| 1.0 / f64::from(path.vertices[0].cosines[1])) > 10.0, "without the cosine");
}

/// A disc wholly above the floor sends it E sinh, h being the height of its middle; discs in the same directions, and the sky
/// behind them, send the sum.
#[test]
fn each_technique_alone_finds_what_suns_send() {
    let cases: [&[(f32, f32, f32)]; 4] = [
        &[(0.9, 0.01, 3.0)],
        &[(0.6, 1.0, 2.0)],
        &[(1.0, 0.8, 2.0), (1.3, 0.8, 1.0)],
        &[(1.2, 1.5, 1.0), (1.2, 0.2, 2.0)],
    ];
    for suns in cases {
        let world = sunlit(suns);
        let irradiance: f64 = suns.iter().map(|&(height, _, e)| f64::from(e * height.sin())).sum();
        let expected = 0.5 * (0.5 + irradiance / PI);
        // What is as narrow as a sun is not met by chance in so few samples.
        for s in usize::from(suns[0].1 < 0.1)..3 {
            let [mean, error] = alone(&world, s, |_| 1.0);
            assert!(
                (mean - expected).abs() < 4.0 * error + 1e-3 * expected,
                "{suns:?}, s = {s}: {mean} ± {error}, {expected}"
            );
        }
    }
    // The control: one of two that are seen in the same directions is missed.
    let [single, error] = alone(&sunlit(&[(1.2, 1.5, 1.0)]), 1, |_| 1.0);
    let both = 0.5 * (0.5 + 3.0 * libm::sin(1.2) / PI);
    assert!((single - both).abs() > 10.0 * error, "{single} ± {error}, {both}");
}

/// The floor in the shadow of a black half-plane at the height 1, `behind` its edge, under a sun overhead of half the angle `half`, of irradiance π.
fn shaded(behind: f64, half: f32) -> World {
    let v = DVec3::new;
    let screen = quad([v(0., 1., -9.), v(9., 1., -9.), v(9., 1., 9.), v(0., 1., 9.)]);
    let floor = quad([v(-1., 0., 1.), v(1., 0., 1.), v(1., 0., -1.), v(-1., 0., -1.)]);
    let sun = Punctual::Directional { along: Vec3::NEG_Y, angle: 2.0 * half };
    Builder::default()
        .surface(floor, lambert(Rgb::ONE))
        .surface(screen, lambert(Rgb::ZERO))
        .lit_by([(Rgb::splat(PI as f32), sun)])
        .seen(v(behind, 0.5, 0.0), v(behind, 0.0, 0.0), 0.5, [4, 4])
}

/// A white floor shows the share of the disc that it sees, weighted by cosθ: the disc's area seen from above, of radius sinα, where x < −d z.
#[test]
fn a_penumbra_is_as_dark_as_the_disc_is_hidden() {
    let (behind, half) = (0.25, 0.5f32);
    let (n, radius) = (1000, f64::from(half).sin());
    let at = |i: i32| radius * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
    let points = (0..n).flat_map(|i| (0..n).map(move |j| (at(i), at(j)))).filter(|(x, y)| x.hypot(*y) < radius);
    let [mut seen, mut all] = [0.0; 2];
    for (x, y) in points {
        all += 1.0;
        seen += f64::from(u8::from(x < -behind * (1.0 - x * x - y * y).sqrt()));
    }
    let world = shaded(behind, half);
    for method in METHODS {
        let [mean, error] = mean_of(&world, settings(method, Stratification::None));
        assert!((mean - seen / all).abs() < 4.0 * error + 2e-3, "{method:?}: {mean} ± {error}, {}", seen / all);
        assert!(error < 0.04, "{method:?}: ± {error}");
    }
    let [mean, error] = mean_of(&world, settings(Method::Metropolis, Stratification::Grid(4, 4)));
    assert!((mean - seen / all).abs() < 4.0 * error + 2e-3, "strata: {mean} ± {error}, {}", seen / all);
    // The control: without extent the sun is wholly hidden.
    let [dark, _] = mean_of(&shaded(behind, 0.0), settings(Method::Path, Stratification::None));
    assert!(seen / all > 0.1 && dark == 0.0, "{dark}");
}

fn settings(method: Method, strata: Stratification) -> Settings {
    Settings { stratification: strata, max_edges: Some(8), ..Settings::new(method, 32.0) }
}

/// Mean luminance of an image and its standard error.
fn mean_of(world: &World, settings: Settings) -> [f64; 2] {
    let renderer = Renderer::new(world.view(), settings);
    let mut sums = renderer.sums();
    renderer.render(0..16, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let mean = mean_luminance(sums.film());
    [mean.mean, mean.stderr]
}

/// A convex white body under a sky of radiance 1 vanishes; a grey one shows its albedo.
#[test]
fn a_furnace_is_even() {
    let world = Builder::default()
        .surface(ball(DVec3::ZERO, 1.0, false), lambert(Rgb::ONE))
        .under(Environment::constant(Rgb::ONE))
        .seen(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 40.0, [8, 8]);
    for method in METHODS {
        let [mean, error] = mean_of(&world, settings(method, Stratification::None));
        assert!((mean - 1.0).abs() < 4.0 * error + 1e-3, "{method:?}: {mean} ± {error}");
        assert!(error < 0.02, "{method:?}: ± {error}");
    }
}

const METHODS: [Method; 6] = [
    Method::Path,
    Method::Bidirectional,
    Method::Metropolis,
    Method::PrimaryBidirectional,
    Method::Multiplexed,
    Method::Auto,
];

/// All methods see the same sky, sunlit caustics of glass among it, the same suns, and what lamps send into cones.
#[test]
fn methods_agree_under_a_sky() {
    for (name, world) in [
        ("glass", outdoors(glass(0.0))),
        ("gloss", outdoors(glossy())),
        ("lamps", lamps_and_sky()),
        ("suns", suns(glossy())),
        ("frosted", suns(glass(0.5))),
        ("spotted pane", spotted_pane()),
        ("beams", beams()),
        ("brushed", brushed()),
    ] {
        let found: Vec<_> = METHODS
            .into_iter()
            .map(|method| (method, Stratification::None))
            .chain([Method::Metropolis, Method::Multiplexed].map(|method| (method, Stratification::Grid(4, 4))))
            .map(|(method, strata)| (method, strata, mean_of(&world, settings(method, strata))))
            .collect();
        let weight: f64 = found.iter().map(|(.., [_, error])| error.powi(-2)).sum();
        let mean = found.iter().map(|(.., [mean, error])| mean * error.powi(-2)).sum::<f64>() / weight;
        for (method, strata, [found, error]) in found {
            assert!(
                (found - mean).abs() < 4.0 * error,
                "{name}, {method:?}, {strata:?}: {found} ± {error}, mean {mean}"
            );
        }
    }
}

/// Strata over directions are a partition whose samples are what they say.
#[test]
fn strata_over_directions_pass_the_checks() {
    for world in [outdoors(mirror()), lamps_and_sky(), suns(mirror())] {
        let parts = LightStrata::new(world.scene.lights(), Stratification::Grid(2, 2));
        let strata = LightStratum::all(&parts, world.view(), 6);
        let whole = LightStrata::new(world.scene.lights(), Stratification::None);
        let [whole] = &LightStratum::all(&whole, world.view(), 6)[..] else { panic!("one stratum") };
        let report = check::strata(&strata, whole, &Luminance, Trials { count: 10_000, seed: 1 });
        assert!(report.is_sound(), "{report}");
    }
}
