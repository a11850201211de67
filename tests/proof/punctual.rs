//! Lights without a surface over a plane show what their laws say: ρ/π times I cosθ/d², or E cosθ.

use crate::analytic::{REFLECTANCE, check, image_of};
use crate::support::*;
use glam::{DVec3, Vec3};
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::{Bsdf, Lambert};
use mlt_core::transport::scene::{Punctual, PunctualLight, SceneDescription};
use std::f64::consts::PI;

const EMISSION: Rgb = Rgb::new(3.0, 2.0, 1.0);
const POSITION: DVec3 = DVec3::new(0.3, 0.8, 0.1);
const BUDGET: [f64; 2] = [50.0, 1000.0];

/// A plane that fills the image, under some lights, all of which light every pixel.
fn lit(kinds: &[Punctual]) -> SceneDescription {
    let mut description = SceneDescription::default();
    let plane = quad([[-9., 0., 9.], [9., 0., 9.], [9., 0., -9.], [-9., 0., -9.]]);
    add(&mut description, plane, Bsdf::Lambert(Lambert { reflectance: REFLECTANCE }), Rgb::ZERO);
    let light = |&kind: &Punctual| PunctualLight { name: String::new(), emission: EMISSION, kind };
    description.punctual = kinds.iter().map(light).collect();
    description.cameras.push(pose(DVec3::new(0.2, 1.5, 1.5), DVec3::new(0.3, 0.0, 0.1), 35.0));
    description
}

/// Radiance of the plane where light of irradiance `irradiance` falls on it, a function of the point.
fn compare(name: &str, kinds: &[Punctual], irradiance: impl Fn(DVec3) -> f64) {
    let description = lit(kinds);
    let radiance = |position: DVec3, direction: DVec3| {
        let point = position - direction * (position.y / direction.y);
        (EMISSION * REFLECTANCE).as_dvec3() * (irradiance(point) / PI)
    };
    let truth = Known::exactly(image_of(&description.cameras[0], 64, radiance));
    check(name, &World::new(description), &truth, BUDGET);
}

fn of_point(point: DVec3) -> f64 {
    let step = POSITION - point;
    step.y / step.length().powi(3)
}

#[test]
fn a_point_lights_a_plane() {
    compare("point", &[Punctual::Point { position: POSITION }], of_point);
}

#[test]
fn a_spot_lights_a_plane_in_its_cone() {
    let (axis, cone) = (Vec3::new(0.2, -1.0, 0.3).normalize(), [0.2f32, 1.3]);
    let irradiance = |point: DVec3| {
        let cos = (point - POSITION).normalize().dot(axis.as_dvec3());
        let [inner, outer] = cone.map(|angle| f64::from(angle).cos());
        of_point(point) * ((cos - outer) / (inner - outer)).clamp(0.0, 1.0).powi(2)
    };
    compare("spot", &[Punctual::Spot { position: POSITION, axis, cone }], irradiance);
}

/// A sun that is seen as a disc sends what one without extent does, wherever all of the disc is above the plane.
#[test]
fn a_sun_with_an_angle_lights_a_plane_as_one_without() {
    let along = Vec3::new(0.5, -0.6, -0.2).normalize();
    let cos = -f64::from(along.y);
    compare("sun with an angle", &[Punctual::Directional { along, angle: 0.5 }], |_| cos);
}

/// A sun at an angle, and with a point beside it.
#[test]
fn a_sun_lights_a_plane_at_an_angle() {
    let along = Vec3::new(0.5, -0.6, -0.2).normalize();
    let cos = -f64::from(along.y);
    compare("sun", &[Punctual::Directional { along, angle: 0.0 }], |_| cos);
    let both = [Punctual::Directional { along, angle: 0.0 }, Punctual::Point { position: POSITION }];
    compare("sun and point", &both, |point| cos + of_point(point));
}
