//! The gallery's files are what its code writes, and load without a word of complaint.

use glam::{DVec3, Vec3};
use mlt_core::memory::Memory;
use mlt_core::transport::scene::{Scene, UnusableScene};
use mlt_scene::{
    EnvironmentSource, LoadOptions, Loaded,
    gallery::{HardScene, RightOutcome, SCENES, find},
    open_within,
};
use std::{fs, path::Path};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// A scene that is to be refused gets no sky.
fn loaded(scene: &HardScene) -> Loaded {
    let folder = tempfile::tempdir().unwrap();
    let mut options = LoadOptions::default();
    if scene.outcome == RightOutcome::Refused {
        options.environment.source = EnvironmentSource::None;
    }
    let path = scene.write(folder.path()).unwrap();
    open_within(path, &options, &Memory::unlimited()).unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

/// With the environment variable MLT_WRITE_GALLERY, the files are written instead.
#[test]
fn stored_files_are_what_the_code_writes() {
    for scene in SCENES {
        let Some(folder) = scene.folder.map(|folder| root().join(folder)) else { continue };
        if std::env::var_os("MLT_WRITE_GALLERY").is_some() {
            fs::create_dir_all(&folder).unwrap();
            scene.write(&folder).unwrap();
        }
        for (name, content) in scene.files() {
            let stored = fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{}/{name}: {error}", scene.name));
            assert!(stored == content, "{}/{name} is not what the code writes", scene.name);
        }
        assert!(folder.join("README.md").is_file(), "{} has no README", scene.name);
    }
}

#[test]
fn every_scene_loads_as_it_should() {
    for scene in SCENES {
        let Loaded { description, warnings, .. } = loaded(scene);
        assert!(warnings.is_empty(), "{}: {warnings:?}", scene.name);
        assert_eq!(description.cameras.len(), 1, "{}", scene.name);
        match Scene::new(description) {
            Ok(_) => assert_ne!(scene.outcome, RightOutcome::Refused, "{}", scene.name),
            Err(error) => {
                assert_eq!((scene.outcome, error), (RightOutcome::Refused, UnusableScene::NoLight), "{}", scene.name)
            }
        }
    }
}

#[test]
fn there_are_as_many_emissive_triangles_as_promised() {
    let emissive = |name: &str| -> usize {
        let description = loaded(find(name).unwrap()).description;
        let emits = |material: u32| description.materials[material as usize].emission != Vec3::ZERO;
        description.meshes.iter().filter(|m| emits(m.material)).map(|m| m.triangles.len()).sum()
    };
    assert_eq!((emissive("confetti"), emissive("lights-200"), emissive("no-light")), (100_000, 400, 0));
}

/// The two keyholes are mirror images, so that both halves of the image have the same energy.
#[test]
fn the_islands_are_mirror_images() {
    let description = loaded(find("islands").unwrap()).description;
    let corners = |side: f64| {
        let mesh = |name: &str| description.meshes.iter().find(|m| m.name == name).unwrap();
        let name = if side < 0.0 { "left" } else { "right" };
        let mut points: Vec<_> = [format!("{name} wall"), format!("{name} chamber"), format!("{name} lamp")]
            .iter()
            .flat_map(|name| mesh(name).positions.clone())
            .map(|p| (p * DVec3::new(side, 1.0, 1.0)).to_array().map(f64::to_bits))
            .collect();
        points.sort_unstable();
        points
    };
    assert_eq!(corners(-1.0), corners(1.0));
}

/// Scales and offsets leave what the camera sees the same: the renderer's own coordinates agree to a few ulps.
#[test]
fn distorted_controls_are_the_control() {
    let plain = loaded(find("plain").unwrap()).description;
    for (name, scale, offset) in [("scale-small", 1e-4f32, 0.0), ("scale-large", 1e5, 0.0), ("offset", 1.0, 1e5)] {
        let other = loaded(find(name).unwrap()).description;
        let back = |p: DVec3| (p - DVec3::new(offset, -offset, offset)) / f64::from(scale);
        let pairs = plain.meshes.iter().zip(&other.meshes).flat_map(|(a, b)| a.positions.iter().zip(&b.positions));
        assert!(pairs.into_iter().all(|(a, b)| a.distance(back(*b)) < 1e-9), "{name}");
        assert!(plain.cameras[0].position.distance(back(other.cameras[0].position)) < 1e-9, "{name}");
        assert_eq!(plain.cameras[0].forward, other.cameras[0].forward, "{name}");
    }
}
