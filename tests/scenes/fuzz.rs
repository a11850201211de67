//! Damaged scene files: every one gives a scene or an error, none a panic, a hang or an invalid mesh.

use crate::support::Document;
use mlt_core::transport::scene::SceneDescription;
use mlt_scene::SceneError;
use rand_pcg::{
    Pcg64Mcg,
    rand_core::{Rng, SeedableRng},
};
use std::{fs, path::Path, time::Instant};
use tempfile::TempDir;

const CASES: usize = 4000;

/// Flips bits, overwrites, repeats, removes or puts in something that parsers stumble over.
fn damage(content: &[u8], rng: &mut impl Rng) -> Vec<u8> {
    const STUMBLING: &[&[u8]] = &[
        b"-1",
        b"1e999",
        b"nan",
        b"4294967295",
        b"18446744073709551615",
        b"null",
        b"[]",
        b"{}",
        b"\"",
        b"\0",
        b"\n",
        b"%ff",
    ];
    let mut bytes = content.to_vec();
    for _ in 0..1 + rng.next_u32() % 4 {
        let at = rng.next_u32() as usize % bytes.len().max(1);
        let end = (at + rng.next_u32() as usize % 8).min(bytes.len());
        match rng.next_u32() % 6 {
            0 => bytes[at..end].iter_mut().for_each(|b| *b ^= 1 << (rng.next_u32() % 8)),
            1 => bytes[at..end].iter_mut().for_each(|b| *b = rng.next_u32() as u8),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.truncate(at),
            4 => bytes = [&bytes[..end], &bytes[at..]].concat(),
            _ => {
                let token = STUMBLING[rng.next_u32() as usize % STUMBLING.len()];
                bytes.splice(at..end, token.iter().copied());
            }
        }
    }
    bytes
}

fn check(scene: &SceneDescription) {
    for mesh in &scene.meshes {
        assert!((mesh.material as usize) < scene.materials.len());
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.normals.is_empty() || mesh.normals.len() == mesh.positions.len());
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
    }
    for camera in &scene.cameras {
        assert!(camera.position.is_finite() && camera.forward.is_normalized() && camera.up.is_normalized());
    }
    assert!(scene.materials.iter().all(|m| m.emission.is_finite() && m.emission.min_element() >= 0.0));
}

/// Loads `main` from `folder` again and again, with `target` damaged; returns how many loads succeeded.
fn fuzz(folder: &Path, main: &str, target: &str, seed: u64) -> usize {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let original = fs::read(folder.join(target)).unwrap();
    let start = Instant::now();
    let mut loads = 0;
    for case in 0..CASES {
        // A new file each time: some file systems flush a file that is overwritten.
        fs::remove_file(folder.join(target)).unwrap();
        fs::write(folder.join(target), damage(&original, &mut rng)).unwrap();
        match mlt_scene::load(&folder.join(main)) {
            Ok(loaded) => {
                check(&loaded.description);
                loads += 1;
            }
            // A known panic of the `gltf` crate; any other would be ours.
            Err(SceneError::Parser { reason, .. }) => {
                assert_eq!(reason, "index out of bounds: the len is 0 but the index is 0");
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
        assert!(start.elapsed().as_secs() < 120, "case {case} of {target} is too slow");
    }
    loads
}

/// Some cases must load and some must fail, or the damage is not worth its name.
fn fuzz_both_ways(folder: &Path, main: &str, target: &str, seed: u64) {
    let loads = fuzz(folder, main, target, seed);
    assert!((CASES / 100..CASES).contains(&loads), "{target}: {loads} of {CASES} load");
}

fn rich_document() -> Document {
    use serde_json::json;
    Document::new()
        .with_view(&[2, 0])
        .with_view(&crate::support::f32s(&[0., 5., 0.]))
        .with(
            "/accessors/0/sparse",
            json!({ "count": 1, "indices": { "bufferView": 3, "componentType": 5123 }, "values": { "bufferView": 4 } }),
        )
        .with("/nodes/1/rotation", json!([0, 0.6, 0, 0.8]))
        .with("/materials/0/emissiveFactor", json!([1, 1, 1]))
        .with("/materials/0/extensions", json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 5 } }))
}

#[test]
fn damaged_gltf() {
    let folder = TempDir::new().unwrap();
    rich_document().write(folder.path());
    fuzz_both_ways(folder.path(), "scene.gltf", "scene.gltf", 1);
}

#[test]
fn damaged_buffer() {
    let folder = TempDir::new().unwrap();
    rich_document().write(folder.path());
    fuzz_both_ways(folder.path(), "scene.gltf", "scene.bin", 2);
}

#[test]
fn damaged_glb() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.glb"), rich_document().glb()).unwrap();
    fuzz_both_ways(folder.path(), "scene.glb", "scene.glb", 3);
}

#[test]
fn damaged_obj_and_mtl() {
    let folder = TempDir::new().unwrap();
    let obj = "mtllib scene.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvn 0 0 1\no thing\nusemtl glass\n\
               f 1//1 2//1 3//1\ng more\nusemtl lamp\nf -4//-1 -3//-1 -2//-1 -1//-1\nf 1 2 3 4 2\n";
    let mtl = "newmtl glass\nKd 0.5 0.5 0.5\nKs 0.5 0.5 0.5\nNs 100\nNi 1.5\nd 0.5\nillum 7\nTf 1 1 1\n\
               newmtl lamp\nKe 5 5 5\nPr 0.5\nmap_Kd a.png\n";
    fs::write(folder.path().join("scene.obj"), obj).unwrap();
    fs::write(folder.path().join("scene.mtl"), mtl).unwrap();
    fuzz_both_ways(folder.path(), "scene.obj", "scene.obj", 4);
    fs::write(folder.path().join("scene.obj"), obj).unwrap();
    // A statement of a library that cannot be read is a warning, so damage there refuses nothing.
    assert_eq!(fuzz(folder.path(), "scene.obj", "scene.mtl", 5), CASES);
}
