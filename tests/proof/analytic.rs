//! Scenes whose images are known.

use crate::support::*;
use glam::{DVec2, DVec3, Vec3, Vec3A};
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::{Bsdf, Lambert, MetallicRoughness};
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::lights::Stratification::{Grid, None as Whole};
use mlt_core::transport::render::{Method, Renderer};
use mlt_core::transport::scene::{CameraPose, SceneDescription, View};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

pub(crate) const SIZE: [u32; 2] = [6, 6];

/// Compares every method under every cut with the truth. `budget`: samples a pixel, mutations a pixel.
pub(crate) fn check(name: &str, world: &World, truth: &Known, budget: [f64; 2]) {
    let compare = |what: String, found: Replicas, error: f64| {
        let what = format!("{name}, {what}, ± {:.1e}", found.relative_error());
        assert_same(found.p_value_of(truth), &what);
        assert_different(found.plus(error, &found).p_value_of(truth), &format!("{what}, and {error} too bright"));
    };
    for method in [Method::Path, Method::Bidirectional] {
        let found = replicas(world, SIZE, &settings(method, Whole, budget[0]), 0..16);
        compare(format!("{method:?}"), found, 0.01);
    }
    // A multiplexed sample is one technique of one length, so its b̂ has the widest spread; and where few rounds light a pixel, their mean is
    // not normal.
    for (method, factor, error) in [(Method::PrimaryBidirectional, 8.0, 0.05), (Method::Multiplexed, 32.0, 0.2)] {
        let found = replicas(world, SIZE, &settings(method, Grid(2, 2), factor * budget[0]), 0..32);
        compare(format!("{method:?}"), found, error);
    }
    // The more strata, the more b̂_j share the noise.
    for (cut, factor) in [(Whole, 1.0), (Grid(2, 2), 1.0), (Grid(5, 3), 4.0)] {
        compare(format!("{cut:?}"), metropolis(world, SIZE, cut, factor * budget[1], 0..16), 0.05);
    }
}

/// A box about the origin, seen from inside; one mesh, so one light.
fn inside_of_a_box(half: f64) -> Mesh {
    let bit = |i: u32, axis: u32| if i >> axis & 1 == 1 { half } else { -half };
    let face = |axis: u32, far: bool| {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let first = if far { 1 << axis } else { 0 };
        let [a, b, c, d] = [first, first + u, first + u + v, first + v];
        if far { [[a, d, c], [a, c, b]] } else { [[a, b, c], [a, c, d]] }
    };
    Mesh {
        positions: (0..8).map(|i| DVec3::new(bit(i, 0), bit(i, 1), bit(i, 2))).collect(),
        triangles: (0..3).flat_map(|axis| [face(axis, false), face(axis, true)].concat()).collect(),
        ..Mesh::default()
    }
}

fn uniform_image(radiance: Rgb) -> Known {
    let pixel = radiance.as_dvec3().to_array();
    Known::exactly((0..SIZE[0] * SIZE[1]).flat_map(|_| pixel).collect())
}

/// Walls that emit 1 − ρ and reflect ρ show radiance 1 everywhere.
#[test]
fn a_furnace_of_diffuse_walls() {
    let mut description = SceneDescription::default();
    let reflectance = Rgb::new(0.5, 0.3, 0.7);
    let walls = Bsdf::Lambert(Lambert { reflectance });
    add(&mut description, inside_of_a_box(1.0), walls, Rgb::ONE - reflectance);
    description.cameras.push(pose(DVec3::new(0.2, 0.3, 0.1), DVec3::new(0.0, -1.0, -1.0), 60.0));
    check("diffuse furnace", &World::new(description), &uniform_image(Rgb::ONE), [200.0, 6000.0]);
}

/// Black walls of radiance 1 about something.
fn furnace_about(mesh: Mesh, bsdf: Bsdf, pose: CameraPose) -> World {
    let mut description = SceneDescription::default();
    add(&mut description, inside_of_a_box(4.0), Bsdf::Black, Rgb::ONE);
    add(&mut description, mesh, bsdf, Rgb::ZERO);
    description.cameras.push(pose);
    World::new(description)
}

fn octahedron() -> Mesh {
    let v = DVec3::new;
    Mesh {
        positions: vec![
            v(1.1, 0., 0.),
            v(-1., 0., 0.),
            v(0., 1.2, 0.),
            v(0., -0.9, 0.),
            v(0., 0., 1.),
            v(0., 0., -1.3),
        ],
        triangles: vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
        ..Mesh::default()
    }
}

/// A surface that absorbs nothing cannot be seen in a furnace.
#[test]
fn a_furnace_hides_what_absorbs_nothing() {
    let seen = || pose(DVec3::new(0.4, 0.6, 3.0), DVec3::ZERO, 40.0);
    let lossless = MetallicRoughness { roughness: 0.0, ..Default::default() };
    let wall = MetallicRoughness { metallic: 0.0, transmission: 1.0, ..lossless.clone() };
    // Where almost all samples are 1 and few are not, rounds are too skewed for Student's t: as light that total reflection
    // keeps inside for long makes them, so the glass has a low index and rounds are long.
    let glass = MetallicRoughness { ior: 1.2, thin: false, ..wall.clone() };
    for (name, material) in [("mirror", lossless), ("glass", glass), ("thin wall", wall)] {
        let world = furnace_about(octahedron(), material.bsdf(), seen());
        check(name, &world, &uniform_image(Rgb::ONE), [1600.0, 2000.0]);
    }
}

/// A flat surface in a furnace shows its albedo in the direction of the camera, ∫ f |cosθ| dω, here by quadrature.
#[test]
fn a_furnace_shows_the_albedo_of_rough_surfaces() {
    let metal = MetallicRoughness { roughness: 0.5, base_color: Rgb::new(0.9, 0.6, 0.3), ..Default::default() };
    let coated = MetallicRoughness { metallic: 0.0, ..metal.clone() };
    let frosted = MetallicRoughness { transmission: 1.0, thin: false, roughness: 0.6, ..coated.clone() };
    for (name, material) in [("rough metal", metal), ("coated", coated), ("frosted glass", frosted)] {
        let bsdf = material.bsdf();
        let square = quad([[-3., 0., 3.], [3., 0., 3.], [3., 0., -3.], [-3., 0., -3.]]);
        let seen = pose(DVec3::new(0.0, 2.0, 2.0), DVec3::ZERO, 30.0);
        let truth = image_of(&seen, 4, |_, direction| albedo(&bsdf, -direction.as_vec3()));
        check(name, &furnace_about(square, bsdf, seen), &Known::exactly(truth), [200.0, 2000.0]);
    }
}

/// ∫ f |cosθ| dω over the sphere about y, fine near the mirror direction and its continuation.
fn albedo(bsdf: &Bsdf, to_eye: Vec3) -> DVec3 {
    let n = 200;
    let mut sum = DVec3::ZERO;
    for i in 0..n {
        let cos = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(n);
        for j in 0..n {
            let phi = TAU * (f64::from(j) + 0.5) / f64::from(n);
            let sin = (1.0 - cos * cos).sqrt();
            let to_light = DVec3::new(sin * phi.cos(), cos, sin * phi.sin()).as_vec3a();
            sum += bsdf.eval(Vec3A::Y, to_light, to_eye.into()).as_dvec3() * cos.abs();
        }
    }
    sum * 4.0 * PI / f64::from(n * n)
}

/// Means over pixels of a function of the pinhole's position and the direction, by the midpoint rule on n × n points.
pub(crate) fn image_of(pose: &CameraPose, n: u32, radiance: impl Fn(DVec3, DVec3) -> DVec3) -> Vec<f64> {
    let [width, height] = SIZE.map(f64::from);
    let (forward, up) = (pose.forward.as_dvec3(), pose.up.as_dvec3());
    let half = (0.5 * f64::from(pose.lens.vertical_fov().unwrap())).tan();
    let pixel = |column: u32, row: u32| {
        let mut sum = DVec3::ZERO;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let inside = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(n);
            let x = 2.0 * (f64::from(column) + inside.x) / width - 1.0;
            let y = 1.0 - 2.0 * (f64::from(row) + inside.y) / height;
            let direction = forward + half * (x * width / height * forward.cross(up) + y * up);
            sum += radiance(pose.position, direction.normalize());
        }
        sum / f64::from(n * n)
    };
    (0..SIZE[1]).flat_map(|row| (0..SIZE[0]).flat_map(move |column| pixel(column, row).to_array())).collect()
}

pub(crate) const LIGHT: [[f64; 3]; 4] = [[-0.5, 1., -0.3], [0.7, 1., -0.3], [0.7, 1., 0.5], [-0.5, 1., 0.5]];
pub(crate) const EMISSION: Rgb = Rgb::new(3.0, 2.0, 1.0);
pub(crate) const REFLECTANCE: Rgb = Rgb::new(0.4, 0.6, 0.8);

/// A diffuse plane under a rectangle that faces it.
pub(crate) fn lit_plane() -> SceneDescription {
    let mut description = SceneDescription::default();
    let plane = quad([[-9., 0., 9.], [9., 0., 9.], [9., 0., -9.], [-9., 0., -9.]]);
    add(&mut description, plane, Bsdf::Lambert(Lambert { reflectance: REFLECTANCE }), Rgb::ZERO);
    add(&mut description, quad(LIGHT), Bsdf::Black, EMISSION);
    description.cameras.push(pose(DVec3::new(0.2, 0.9, 2.5), DVec3::new(0.3, 0.0, 0.2), 35.0));
    description
}

/// Radiance of the plane: ρ/π E, E = L/2 Σ_i θ_i (n · γ_i), θ_i the angle that edge i subtends and γ_i the unit normal of
/// the plane through it and the point.
pub(crate) fn plane_radiance(position: DVec3, direction: DVec3) -> DVec3 {
    let point = position - direction * (position.y / direction.y);
    let corners = LIGHT.map(|c| (DVec3::from_array(c) - point).normalize());
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        a.angle_between(b) * a.cross(b).normalize().y
    };
    let factor = 0.5 * (0..4).map(edge).sum::<f64>().abs();
    (EMISSION * REFLECTANCE).as_dvec3() * (factor / PI)
}

#[test]
fn a_rectangle_lights_a_plane() {
    let description = lit_plane();
    let truth = Known::exactly(image_of(&description.cameras[0], 32, plane_radiance));
    check("rectangle", &World::new(description), &truth, [200.0, 2000.0]);
}

/// A light that faces away from all that is seen: its strata are exactly dark and the image is that of the other light.
#[test]
fn a_dark_stratum_takes_nothing_away() {
    let mut description = lit_plane();
    let [a, b, c, d] = LIGHT.map(|[x, y, z]| [x, y + 0.5, z]);
    add(&mut description, quad([d, c, b, a]), Bsdf::Black, Rgb::splat(2.0));
    let truth = Known::exactly(image_of(&description.cameras[0], 32, plane_radiance));
    let world = World::new(description);
    check("a light that faces away", &world, &truth, [200.0, 2000.0]);
    let camera = world.camera(SIZE);
    let view = View { scene: &world.scene, camera: &camera };
    let renderer = Renderer::new(view, settings(Method::Metropolis, Grid(2, 2), 1000.0));
    let mut sums = renderer.sums();
    renderer.render(0..2, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    for (j, stratum) in sums.tally().chains().strata.iter().enumerate() {
        assert_eq!(stratum.b() == 0.0, j >= 4, "stratum {j}");
        assert_eq!(stratum.dark_rounds, if j >= 4 { 2 } else { 0 });
    }
}
