//! The camera's maps and densities.

use super::worlds::{lambert, room};
use crate::engine::{Purpose, generator, uniform_f32};
use crate::transport::colour::Rgb;
use crate::transport::geometry::math::cosine_hemisphere;
use glam::Vec2;
use std::f64::consts::PI;

#[test]
fn a_direction_leads_back_to_its_film_point() {
    let camera = room(lambert(Rgb::ONE), false).camera;
    let mut rng = generator(1, Purpose::Image, 0, 0, 0);
    for _ in 0..1000 {
        let image =
            Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng)).clamp(Vec2::splat(1e-4), Vec2::splat(0.9999));
        let back = camera.project(&camera.vertex(), camera.sample(image).direction()).unwrap();
        assert!(back.distance(image) < 2e-6, "{image} {back}");
        assert_eq!(camera.project(&camera.vertex(), -camera.sample(image).direction()), None);
    }
    assert_eq!(camera.project(&camera.vertex(), camera.sample(Vec2::new(1.01, 0.5)).direction()), None);
    assert_eq!(camera.project(&camera.vertex(), camera.sample(Vec2::new(0.5, -0.01)).direction()), None);
    assert_eq!(camera.pixel(Vec2::new(0.99, 0.0)), 15);
    assert_eq!(camera.pixel(Vec2::new(0.0, 0.99)), 240);
}

/// ∫ W_e cosθ dω and ∫ pdf dω over the directions into the image, by directions of density cosθ/π.
#[test]
fn importance_and_density_integrate_to_one() {
    let camera = room(lambert(Rgb::ONE), false).camera;
    let axis = camera.vertex().geometric_normal;
    let mut rng = generator(2, Purpose::Image, 0, 0, 0);
    let n = 400_000;
    let mut sums = [0.0; 4];
    for _ in 0..n {
        let direction = cosine_hemisphere(axis, Vec2::new(uniform_f32(&mut rng), uniform_f32(&mut rng)));
        let cos = axis.dot(direction);
        if camera.project(&camera.vertex(), direction).is_some() {
            let x = f64::from(camera.w_e(&camera.vertex(), direction)) * PI;
            let y = f64::from(camera.pdf(&camera.vertex(), direction) / cos) * PI;
            [x, x * x, y, y * y].iter().zip(&mut sums).for_each(|(v, s)| *s += v / f64::from(n));
        }
    }
    for [mean, square] in [[sums[0], sums[1]], [sums[2], sums[3]]] {
        let z = (mean - 1.0) / ((square - mean * mean) / f64::from(n)).sqrt();
        assert!(z.abs() < 4.0, "{mean}: z = {z}");
        assert!((mean - 1.0).abs() < 0.03);
    }
}
