//! Features of what is seen.

use super::worlds::{Builder, World, curtain, glass, lambert, mirror, room, veil, veils, walls};
use crate::transport::bsdf::MetallicRoughness;
use crate::transport::colour::Rgb;
use crate::transport::lights::Stratification;
use crate::transport::render::{NOWHERE, SurfaceFeatures, strongest_strata, surfaces};
use crate::transport::scene::Material;
use glam::{DVec3, Vec3};

const EYE: Vec3 = Vec3::new(0.2, 0.1, 3.4);

/// The box with a material on a quad across it, seen from the front.
fn across(material: Material) -> World {
    walls().mesh(curtain(0.0), material).seen(EYE.as_dvec3(), DVec3::ZERO, 20.0, [9, 9])
}

/// Features of the pixel in the middle.
fn middle(world: &World) -> SurfaceFeatures {
    surfaces(world.view())[40]
}

#[test]
fn walls_have_their_place_colour_and_normal() {
    let forward = -EYE.normalize();
    let mut seen = 0;
    for feature in surfaces(room(glass(0.0), true).view()) {
        let position = Vec3::from(feature.position);
        assert!((feature.depth - (position - EYE).dot(forward)).abs() < 1e-4, "{feature:?}");
        assert!(position.abs().max_element() < 1.0001 && Vec3::from(feature.normal).length() < 1.0001);
        if (position.z + 1.0).abs() < 1e-4 && feature.normal == [0.0, 0.0, 1.0] {
            assert!((Vec3::from(feature.albedo) - 0.7).abs().max_element() < 1e-5, "{feature:?}");
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn smooth_surfaces_have_the_albedo_of_what_is_seen_in_them() {
    let plain = middle(&across(veil(lambert(Rgb::new(0.2, 0.3, 0.4)), 1.0)));
    assert!((Vec3::from(plain.albedo) - Vec3::new(0.2, 0.3, 0.4)).length() < 1e-5, "{plain:?}");
    // The mirror shows the open front of the box.
    let metal = middle(&across(veil(mirror(), 1.0)));
    assert!((Vec3::from(metal.albedo) - Vec3::new(0.9, 0.8, 0.6)).length() < 0.01, "{metal:?}");
    // A pane reflects 2F/(1 + F) of the front, F = 0.04, and shows the white back.
    let pane = MetallicRoughness { roughness: 0.0, metallic: 0.0, transmission: 1.0, ..MetallicRoughness::default() };
    let pane = middle(&across(veil(pane.bsdf(), 1.0)));
    assert!((pane.albedo[0] - (0.0769 + 0.9231 * 0.7)).abs() < 0.01, "{pane:?}");
    for feature in [plain, metal, pane] {
        assert!((feature.normal[2] - 1.0).abs() < 1e-5 && feature.position[2].abs() < 1e-5, "{feature:?}");
    }
}

/// At a pixel's centre the first surface that is there for more than a half; in means all that are, by their shares.
#[test]
fn veils_count_by_their_shares() {
    let of = |opacity| middle(&across(veil(lambert(Rgb::ZERO), opacity)));
    let [thin, dense] = [of(0.25), of(0.75)];
    assert!((thin.position[2] + 1.0).abs() < 1e-4 && dense.position[2].abs() < 1e-4, "{thin:?} {dense:?}");
    assert!((thin.albedo[0] - 0.75 * 0.7).abs() < 0.1 && (dense.albedo[0] - 0.25 * 0.7).abs() < 0.1);
    assert!(surfaces(veils().view()).iter().all(|feature| feature.depth.is_finite()));
}

#[test]
fn nothing_is_seen_beyond_the_last_surface() {
    let lamp = super::worlds::quad([[-1., 0.], [1., 0.], [1., 2.], [-1., 2.]].map(|[x, y]| DVec3::new(x, y, 0.0)));
    let world = Builder::default().light(lamp, Rgb::ONE, true).seen(EYE.as_dvec3(), DVec3::ZERO, 20.0, [9, 9]);
    let features = surfaces(world.view());
    let nothing = SurfaceFeatures { albedo: [0.0; 3], normal: [0.0; 3], position: [0.0; 3], depth: NOWHERE };
    assert_eq!(features[80], nothing);
    assert!(features[0].depth < 4.0);
}

#[test]
fn each_side_of_a_lamp_lights_its_own_side_most() {
    let world = walls().seen(EYE.as_dvec3(), DVec3::ZERO, 38.0, [16, 16]);
    let strata = strongest_strata(world.view(), Stratification::Grid(2, 2));
    let [left, right] = [strata[8 * 16], strata[8 * 16 + 15]];
    assert!(left.is_some() && right.is_some() && left != right, "{left:?} {right:?}");
    // The ceiling has no direct light.
    let whole = strongest_strata(world.view(), Stratification::None);
    assert!(whole.contains(&Some(0)) && whole.contains(&None) && whole.iter().flatten().all(|&stratum| stratum == 0));
}
