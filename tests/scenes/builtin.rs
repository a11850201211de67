//! The built-in scenes load and say what their makers meant.

use glam::{DVec3, Vec3};
use mlt_core::transport::bsdf::Bsdf;
use mlt_core::transport::scene::SceneDescription;
use mlt_scene::{BUILTIN, SceneError, builtin, open};

fn triangles(scene: &SceneDescription) -> usize {
    scene.meshes.iter().map(|m| m.triangles.len()).sum()
}

fn lights(scene: &SceneDescription) -> usize {
    scene.meshes.iter().filter(|m| scene.materials[m.material as usize].emission != Vec3::ZERO).count()
}

#[test]
fn cornell_has_the_right_numbers() {
    let cornell = open("cornell").unwrap();
    let scene = &cornell.description;
    assert_eq!(cornell.name, "cornell");
    assert!(cornell.warnings.is_empty(), "{:?}", cornell.warnings);
    assert_eq!((triangles(scene), lights(scene)), (32, 1));

    let camera = &scene.cameras[0];
    assert!((camera.lens.vertical_fov().unwrap() - 0.685_914_4).abs() < 1e-6);
    assert!(camera.position.distance(DVec3::new(2.78, 2.73, -8.0)) < 1e-6);
    assert_eq!((camera.forward, camera.up, camera.aspect_ratio), (Vec3::Z, Vec3::Y, Some(1.0)));

    let lamp = scene.meshes.iter().find(|m| m.name == "lamp").unwrap();
    let light = &scene.materials[lamp.material as usize];
    assert!(light.emission.distance(Vec3::new(30.0, 24.0, 14.0)) < 1e-4);
    assert!(!light.emits_both_sides && matches!(light.bsdf, Bsdf::Black));
    let [a, b, c] = lamp.triangles[0].map(|i| lamp.positions[i as usize]);
    assert!((b - a).cross(c - a).y < 0.0, "the lamp's front faces down");

    let red = scene.materials.iter().find(|m| m.name == "red").unwrap();
    assert!(matches!(&red.bsdf, Bsdf::Lambert(l) if l.reflectance == Vec3::new(0.57, 0.043, 0.044)));
}

#[test]
fn the_other_scenes_have_their_lights_and_smooth_meshes() {
    for (name, expected_lights, least_triangles) in [("ring", 12, 1000), ("suzanne", 3, 15_744)] {
        let loaded = open(name).unwrap();
        let scene = &loaded.description;
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!(lights(scene), expected_lights, "{name}");
        assert!(triangles(scene) >= least_triangles, "{name}: {}", triangles(scene));
        assert!(scene.meshes.iter().any(|m| m.normals.len() == m.positions.len()), "{name} has smooth normals");
        assert!(scene.meshes.iter().flat_map(|m| &m.normals).all(|n| (n.length() - 1.0).abs() < 1e-5));
    }
}

#[test]
fn every_name_on_the_list_loads_and_others_do_not() {
    assert!(BUILTIN.iter().all(|scene| builtin(scene.name).unwrap().is_ok()));
    assert!(builtin("teapot").is_none());
    let error = open("teapot").unwrap_err();
    assert!(matches!(error, SceneError::NotFound { .. }));
    assert!(error.to_string().contains("cornell"), "{error}");
}
