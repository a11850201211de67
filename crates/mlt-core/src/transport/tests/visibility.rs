//! Rays between surfaces of very different sizes, and from a camera that lies on a surface.

use super::worlds::{Builder, World, lambert, quad};
use crate::engine::{Purpose, generator, uniform, uniform_f32};
use crate::transport::colour::Rgb;
use crate::transport::lights::LightRegion;
use glam::{DVec3, Vec2};

/// A horizontal square of half-width `half` at `height`, its front up or down.
fn square(height: f64, half: f64, up: bool) -> crate::transport::geometry::Mesh {
    let x = if up { half } else { -half };
    let v = |x: f64, z: f64| DVec3::new(x, height, z);
    quad([v(-x, half), v(x, half), v(x, -half), v(-x, -half)])
}

/// Share of pairs of a point seen by the camera and a point on the lights that see each other, asked in both orders.
fn seen_share(world: &World, pairs: u32) -> f64 {
    let region = LightRegion::whole(world.scene.lights());
    let mut rng = generator(1, Purpose::Image, 0, 0, 0);
    let mut seen = 0;
    for _ in 0..pairs {
        let image = Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng));
        let surface = world
            .scene
            .trace(&world.camera.vertex(), world.camera.sample(image, &world.camera.vertex()).direction())
            .expect("the floor");
        let point = region.sample(uniform(&mut rng), uniform(&mut rng));
        let (_, light) = world.scene.light_point(&point);
        for (a, b) in [(&surface, &light), (&light, &surface)] {
            seen += u32::from(world.scene.visible(a, b));
        }
    }
    f64::from(seen) / f64::from(2 * pairs)
}

/// From under a sky thousands of times as wide as the floor, rays end in front of the floor and not behind it.
#[test]
fn a_small_floor_and_a_huge_sky_see_each_other() {
    for half in [1.0, 30.0, 1000.0, 30_000.0] {
        let world = Builder::default()
            .surface(square(0.3, 1.0, true), lambert(Rgb::ONE))
            .light(square(half, half, false), Rgb::ONE, false)
            .seen(DVec3::new(0.1, 0.9, 0.2), DVec3::new(0.0, 0.3, 0.0), 40.0, [8, 8]);
        assert_eq!(seen_share(&world, 2000), 1.0, "half-width {half}");
    }
}

/// A camera on a lamp sees all that is in front of it, and is seen.
#[test]
fn a_camera_on_a_surface_sees_past_it() {
    let (height, floor) = (1.98, square(0.0, 1.0, true));
    for at in [DVec3::new(0.05, height, 0.1), DVec3::new(-0.21, height, 0.033)] {
        let world = Builder::default()
            .surface(floor.clone(), lambert(Rgb::ONE))
            .light(square(height, 0.25, false), Rgb::ONE, false)
            .seen(at, DVec3::new(0.1, 0.0, 0.0), 40.0, [8, 8]);
        let camera = world.camera.vertex();
        for index in 0..64 {
            let image = (Vec2::new((index % 8) as f32, (index / 8) as f32) + 0.5) / 8.0;
            let hit = world
                .scene
                .trace(&camera, world.camera.sample(image, &world.camera.vertex()).direction())
                .expect("the floor");
            assert!(hit.primitive < 2, "the camera sees the lamp that it lies on");
            assert!(world.scene.visible(&camera, &hit) && world.scene.visible(&hit, &camera));
        }
    }
}

/// Half-widths of a ground under things of size 1.
const GROUNDS: [f64; 4] = [10.0, 1e4, 1e6, 1e8];

/// A wall of height 1 at x = 0 on a ground; the view is of the foot of the wall.
fn wall_on_ground(half: f64) -> World {
    let v = DVec3::new;
    Builder::default()
        .surface(square(0.0, half, true), lambert(Rgb::ONE))
        .surface(quad([v(0., 0., -1.), v(0., 0., 1.), v(0., 1., 1.), v(0., 1., -1.)]), lambert(Rgb::ONE))
        .light(square(3.0, 0.5, false), Rgb::ONE, false)
        .seen(v(0.1, 0.5, 0.0), v(0.05, 0.0, 0.0), 20.0, [8, 8])
}

/// Points of the ground lie on it, and do not see past the foot of a wall, however large the ground is.
#[test]
fn a_wall_stands_on_a_ground_of_any_size() {
    let mut rng = generator(2, Purpose::Image, 0, 0, 0);
    for half in GROUNDS {
        let world = wall_on_ground(half);
        let mut met = 0;
        for _ in 0..500 {
            let image = Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng));
            let Some(near) = world
                .scene
                .trace(&world.camera.vertex(), world.camera.sample(image, &world.camera.vertex()).direction())
            else {
                continue;
            };
            let aside = glam::Vec3A::new(-1.0, 0.01, 0.0).normalize();
            if near.primitive > 1 {
                continue;
            }
            met += 1;
            assert!(near.position.y.abs() < 1e-15, "{half}: {near:?}");
            let hit = world.scene.trace(&near, aside).expect("the wall");
            assert!(hit.primitive == 2 || hit.primitive == 3, "{half}: {hit:?}");
            let lamp = world.scene.trace(&near, glam::Vec3A::Y).expect("the lamp");
            assert!(lamp.emits && world.scene.visible(&near, &lamp), "{half}: {near:?}");
        }
        assert!(met > 300, "{half}: {met}");
    }
}
