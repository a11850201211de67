//! The cameras' maps and densities.

use super::worlds::{World, blurred, lambert, parallel, room};
use crate::engine::{Generator, Purpose, generator, uniform_f32};
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::geometry::math::{cosine_hemisphere, frame};
use crate::transport::scene::Camera;
use glam::{Vec2, Vec3A};
use std::f64::consts::PI;

/// One of each kind.
fn worlds() -> [(&'static str, World); 3] {
    [("pinhole", room(lambert(Rgb::ONE), false)), ("thin lens", blurred()), ("orthographic", parallel())]
}

/// A surface that a ray meets after some way.
fn seen(origin: Vec3A, step: Vec3A, way: f32) -> Vertex {
    Vertex::camera(origin + way * step, step)
}

fn pair(rng: &mut Generator) -> Vec2 {
    Vec2::new(uniform_f32(rng), uniform_f32(rng))
}

#[test]
fn a_point_leads_back_to_its_film_point() {
    for (name, World { camera, .. }) in worlds() {
        let mut rng = generator(1, Purpose::Image, 0, 0, 0);
        for _ in 0..1000 {
            let film = pair(&mut rng).clamp(Vec2::splat(1e-3), Vec2::splat(0.999));
            let lens = camera.sample_lens(&mut rng);
            let back = |film: Vec2, way: f32| {
                let ray = camera.sample(film, &lens);
                camera.project(&lens, &seen(ray.origin, ray.step, way), way.signum() * ray.direction())
            };
            let found = back(film, 0.1 + uniform_f32(&mut rng)).unwrap();
            assert!(found.distance(film) < 2e-6, "{name}: {film} {found}");
            assert_eq!(back(film, -0.5), None, "{name}");
            assert_eq!((back(Vec2::new(1.01, 0.5), 1.0), back(Vec2::new(0.5, -0.01), 1.0)), (None, None), "{name}");
        }
    }
    let camera = room(lambert(Rgb::ONE), false).camera;
    assert_eq!((camera.pixel(Vec2::new(0.99, 0.0)), camera.pixel(Vec2::new(0.0, 0.99))), (15, 240));
}

/// A part of a view sees through its film points what the whole sees through those, and W_e is over its own area.
#[test]
fn a_part_of_a_view_is_the_view_there() {
    for (name, World { camera, .. }) in worlds() {
        let (whole, part) = (camera.with_size([40, 20]), camera.with_size([40, 20]).part([10, 5], [8, 10]));
        let mut rng = generator(5, Purpose::Image, 0, 0, 0);
        for _ in 0..100 {
            let (film, lens) = (pair(&mut rng), whole.sample_lens(&mut rng));
            let there = (Vec2::new(10.0, 5.0) + film * Vec2::new(8.0, 10.0)) / Vec2::new(40.0, 20.0);
            let [a, b] = [whole.sample(there, &lens), part.sample(film, &lens)];
            assert!(a.origin.distance(b.origin) + a.step.distance(b.step) < 1e-5, "{name}: {a:?} {b:?}");
            let (seen, direction) = (seen(a.origin, a.step, 1.0), a.direction());
            assert!(part.project(&lens, &seen, direction).unwrap().distance(film) < 1e-4, "{name}");
            for of in [Camera::w_e, Camera::pdf] {
                assert!((of(&part, direction) / of(&whole, direction) - 10.0).abs() < 1e-3, "{name}");
            }
        }
        let outside = whole.sample(Vec2::new(0.24, 0.5), &whole.vertex());
        assert_eq!(part.project(&whole.vertex(), &seen(outside.origin, outside.step, 1.0), outside.direction()), None);
    }
}

/// Mean and z of its difference from 1.
fn compared_with_one(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (n, sum, squares) = values.fold((0.0, 0.0, 0.0), |(n, sum, squares), x| (n + 1.0, sum + x, squares + x * x));
    let mean: f64 = sum / n;
    [mean, (mean - 1.0) / ((squares / n - mean * mean) / n).sqrt()]
}

/// ∫ W_e cosθ dω dA and ∫ pdf dω over the directions into the image, by directions of density cosθ/π from points of the lens; the
/// power of the cosine that is forgotten is the control.
#[test]
fn importance_and_density_integrate_to_one() {
    for (name, World { camera, .. }) in worlds().into_iter().take(2) {
        let integral = |value: &dyn Fn(Vec3A, f32) -> f32| {
            let mut rng = generator(2, Purpose::Image, 0, 0, 0);
            let axis = camera.vertex().geometric_normal;
            compared_with_one((0..400_000).map(|_| {
                let lens = camera.sample_lens(&mut rng);
                let direction = cosine_hemisphere(axis, pair(&mut rng));
                let seen = seen(lens.position, direction, 1.0);
                let inside = camera.project(&lens, &seen, direction).is_some();
                if inside { f64::from(value(direction, axis.dot(direction))) * PI } else { 0.0 }
            }))
        };
        let [importance, z] = integral(&|direction, _| camera.w_e(direction));
        assert!(z.abs() < 4.0 && (importance - 1.0).abs() < 0.03, "{name}: {importance}, z = {z}");
        let [density, z] = integral(&|direction, cos| camera.pdf(direction) / cos);
        assert!(z.abs() < 4.0 && (density - 1.0).abs() < 0.03, "{name}: {density}, z = {z}");
        let [wrong, z] = integral(&|direction, _| camera.pdf(direction));
        assert!(z.abs() > 4.0, "{name}: {wrong}, z = {z}");
    }
}

/// ∫ W_e dA over points of a plane that parallel rays cross, and ∫ pdf dA.
#[test]
fn importance_of_parallel_rays_integrates_to_one() {
    let camera = parallel().camera;
    let [axis, lens] = [camera.vertex().geometric_normal, camera.vertex().position];
    let (right, up) = frame(axis);
    let (side, mut rng) = (3.0, generator(3, Purpose::Image, 0, 0, 0));
    let integral = |size: f32, rng: &mut Generator| {
        compared_with_one((0..400_000).map(|_| {
            let p = size * (pair(rng) - 0.5);
            let seen = Vertex::camera(lens + axis + p.x * right + p.y * up, axis);
            let inside = camera.project(&camera.vertex(), &seen, axis).is_some();
            if inside { f64::from(camera.w_e(axis) * side * side) } else { 0.0 }
        }))
    };
    assert_eq!(camera.w_e(axis), camera.pdf(axis));
    let [right, wrong] = [integral(side, &mut rng), integral(0.98 * side, &mut rng)];
    assert!(right[1].abs() < 4.0 && (right[0] - 1.0).abs() < 0.02, "{right:?}");
    assert!(wrong[1].abs() > 4.0, "{wrong:?}");
}

/// Rays through one film point meet in the plane in focus, and nowhere else.
#[test]
fn a_lens_is_sharp_where_it_is_in_focus() {
    let camera = blurred().camera;
    let axis = camera.vertex().geometric_normal;
    let mut rng = generator(4, Purpose::Image, 0, 0, 0);
    let spread = |way: f32, rng: &mut Generator| {
        let film = Vec2::new(0.2, 0.7);
        let points: Vec<_> = (0..100)
            .map(|_| {
                let lens = camera.sample_lens(rng);
                lens.position + way * camera.sample(film, &lens).step
            })
            .collect();
        points.iter().map(|p| p.distance(points[0])).fold(0.0, f32::max)
    };
    // The camera stands at a known distance from the origin, in the world's units and in the scene's own.
    let unit = camera.vertex().position.length() / Vec3A::new(0.2, 0.1, 3.4).length();
    let focus = 2.6 * unit;
    assert!((camera.sample(Vec2::splat(0.5), &camera.vertex()).step - axis).length() < 1e-6);
    let [sharp, blurred] = [focus, 1.5 * focus].map(|way| spread(way, &mut rng));
    assert!(sharp < 0.1 * blurred, "{sharp} and {blurred}");
}
