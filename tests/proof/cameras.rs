//! Images through a lens and by parallel rays are what integrals over film and lens say.

use crate::analytic::{EMISSION, LIGHT, SIZE, check, lit_plane, plane_radiance};
use crate::support::*;
use glam::{DVec2, DVec3};
use mlt_core::transport::bsdf::Bsdf;
use mlt_core::transport::scene::{CameraPose, Lens, SceneDescription};

const RADIUS: f64 = 0.4;
const FOCUS: f64 = 2.0;
/// Half the side of a square lamp that faces the camera, and its depth.
const HALF: f64 = 0.25;
const DEPTH: f64 = 4.0;

/// Means over pixels of a function of the film point, in [−1, 1]², y up, by the midpoint rule on n × n points.
fn over_film(n: u32, radiance: impl Fn(DVec2) -> DVec3) -> Vec<f64> {
    let pixel = |column: u32, row: u32| {
        let mut sum = DVec3::ZERO;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let inside = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) / f64::from(n);
            let film = (DVec2::new(f64::from(column), f64::from(row)) + inside) / SIZE[0] as f64;
            sum += radiance(DVec2::new(2.0 * film.x - 1.0, 1.0 - 2.0 * film.y));
        }
        sum / f64::from(n * n)
    };
    (0..SIZE[1]).flat_map(|row| (0..SIZE[0]).flat_map(move |column| pixel(column, row).to_array())).collect()
}

/// Mean over a disc, by equal areas.
fn over_disc(radius: f64, n: u32, value: impl Fn(DVec2) -> DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (i, j) in (0..n).flat_map(|i| (0..4 * n).map(move |j| (i, j))) {
        let r = radius * ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
        let phi = std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(4 * n);
        sum += value(r * DVec2::new(phi.cos(), phi.sin()));
    }
    sum / f64::from(4 * n * n)
}

/// A lamp that is out of focus shows in a pixel for the share of film and lens whose rays meet it: a ray from l through p leaves the
/// lens at l and passes depth z at l + z (p − l/f).
#[test]
fn a_lamp_out_of_focus_is_spread() {
    let degrees = 40f32;
    let mut description = SceneDescription::default();
    let [x, y, z] = [HALF, HALF, -DEPTH];
    add(&mut description, quad([[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]]), Bsdf::Black, EMISSION);
    let lens = Lens::Thin { vertical_fov: degrees.to_radians(), radius: RADIUS, focus: FOCUS };
    description.cameras.push(CameraPose { lens, ..pose(DVec3::ZERO, DVec3::NEG_Z, degrees) });
    let half = f64::from(0.5 * degrees.to_radians()).tan();
    let truth = over_film(24, |p| {
        over_disc(RADIUS, 24, |l| {
            let at = l + DEPTH * (half * p - l / FOCUS);
            if at.abs().max_element() < HALF { EMISSION.as_dvec3() } else { DVec3::ZERO }
        })
    });
    check("lamp out of focus", &World::new(description), &known_to(truth, 2e-3), [400.0, 4000.0]);
}

/// The midpoint rule integrates a step to about this.
fn known_to(values: Vec<f64>, error: f64) -> Known {
    let variances = values.iter().map(|v| (v * error).powi(2).max(1e-12)).collect();
    Known { values, variances }
}

/// A plane that a rectangle lights, through a lens: the mean over the lens of what pinholes see.
#[test]
fn a_plane_through_a_lens_is_the_mean_over_pinholes() {
    let mut description = lit_plane();
    let pinhole = description.cameras[0].clone();
    let vertical_fov = pinhole.lens.vertical_fov().unwrap();
    let (radius, focus) = (0.3, 1.5);
    description.cameras[0].lens = Lens::Thin { vertical_fov, radius, focus };
    let (forward, up) = (pinhole.forward.as_dvec3(), pinhole.up.as_dvec3());
    let (right, half) = (forward.cross(up), f64::from(0.5 * vertical_fov).tan());
    let truth = over_film(8, |p| {
        over_disc(radius, 12, |l| {
            let [p, l] = [half * p, l].map(|v| v.x * right + v.y * up);
            plane_radiance(pinhole.position + l, (forward + p - l / focus).normalize())
        })
    });
    check("plane through a lens", &World::new(description), &known_to(truth, 1e-4), [200.0, 2000.0]);
}

/// The same plane by parallel rays, and the lamp itself, seen in its true size.
#[test]
fn parallel_rays_see_a_plane_without_perspective() {
    let mut description = lit_plane();
    let camera = &mut description.cameras[0];
    let height = 1.1;
    camera.lens = Lens::Orthographic { height };
    let (position, forward, up) = (camera.position, camera.forward.as_dvec3(), camera.up.as_dvec3());
    let truth = over_film(16, |p| {
        let at = position + 0.5 * height * (p.x * forward.cross(up) + p.y * up);
        plane_radiance(at, forward)
    });
    check("plane by parallel rays", &World::new(description), &Known::exactly(truth), [200.0, 2000.0]);

    let mut description = SceneDescription::default();
    add(&mut description, quad(LIGHT), Bsdf::Black, EMISSION);
    let seen = CameraPose { lens: Lens::Orthographic { height: 3.0 }, ..pose(DVec3::ZERO, DVec3::Y, 40.0) };
    let right = seen.forward.cross(seen.up).as_dvec3();
    let up = seen.up.as_dvec3();
    description.cameras.push(seen);
    let truth = over_film(240, |p| {
        let at = 1.5 * (p.x * right + p.y * up);
        let inside = (-0.5..0.7).contains(&at.x) && (-0.3..0.5).contains(&at.z);
        if inside { EMISSION.as_dvec3() } else { DVec3::ZERO }
    });
    check("lamp by parallel rays", &World::new(description), &known_to(truth, 1e-3), [200.0, 2000.0]);
}
