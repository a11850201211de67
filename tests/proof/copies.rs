//! Copies of meshes that are held once against the same copies in world space.

use crate::support::*;
use glam::{DMat4, DVec3};
use image::{ImageFormat, Rgba, RgbaImage};
use mlt_core::memory::Memory;
use mlt_core::transport::lights::Stratification::{Grid, None as Whole};
use mlt_core::transport::render::Method;
use mlt_core::transport::scene::SceneDescription;
use mlt_scene::{Copies, LoadOptions, open_within};
use serde_json::{Value, json};
use std::io::Cursor;

const SIZE: [u32; 2] = [12, 12];

/// A glTF document in the making.
#[derive(Default)]
struct Writer {
    bin: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
}

impl Writer {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() }));
        self.bin.extend(bytes);
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, values: &[f32], kind: &str, components: usize) -> usize {
        let view = self.view(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
        let count = values.len() / components;
        self.accessors.push(json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    /// A mesh of some rows of points on a surface, by u and v.
    fn surface(
        &mut self,
        [rows, columns]: [u32; 2],
        material: usize,
        at: impl Fn(f64, f64) -> DVec3,
        round: bool,
    ) -> usize {
        let part = |i: u32, n: u32| f64::from(i) / f64::from(n);
        let grid: Vec<_> =
            (0..=rows).flat_map(|i| (0..=columns).map(move |j| (part(j, columns), part(i, rows)))).collect();
        let quads = (0..rows).flat_map(|i| (0..columns).map(move |j| i * (columns + 1) + j));
        let triangles: Vec<_> = quads
            .flat_map(|a| [[a, a + columns + 2, a + 1], [a, a + columns + 1, a + columns + 2]])
            .flat_map(|t| t.map(|i| grid[i as usize]))
            .collect();
        let points: Vec<_> = triangles.iter().flat_map(|&(u, v)| at(u, v).as_vec3().to_array()).collect();
        let uv: Vec<_> = triangles.iter().flat_map(|&(u, v)| [u as f32, v as f32]).collect();
        let (positions, uv) = (self.accessor(&points, "VEC3", 3), self.accessor(&uv, "VEC2", 2));
        let mut attributes = json!({ "POSITION": positions, "TEXCOORD_0": uv });
        if round {
            attributes["NORMAL"] = positions.into();
        }
        self.meshes.push(json!({ "primitives": [{ "attributes": attributes, "material": material }] }));
        self.meshes.len() - 1
    }

    fn place(&mut self, mesh: usize, place: DMat4) {
        self.nodes.push(json!({ "mesh": mesh, "matrix": place.to_cols_array().map(|x| x as f32) }));
    }

    fn write(mut self, texture: &[u8]) -> tempfile::TempDir {
        let image = self.view(texture);
        let factors = |colour: [f64; 3], roughness: f64| json!({ "baseColorFactor": [colour[0], colour[1], colour[2], 1.0], "metallicFactor": 0, "roughnessFactor": roughness });
        let textured = |mut factors: Value| {
            factors["baseColorTexture"] = json!({ "index": 0 });
            factors
        };
        let all: Vec<_> = (0..=self.nodes.len()).collect();
        self.nodes.push(json!({ "camera": 0, "translation": [0, 1.2, 6] }));
        let document = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": all }],
            "nodes": self.nodes,
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
            "meshes": self.meshes,
            "materials": [
                { "pbrMetallicRoughness": factors([0.7, 0.7, 0.7], 1.0) },
                { "emissiveFactor": [1, 1, 1], "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } } },
                { "pbrMetallicRoughness": textured(factors([0.9, 0.8, 0.7], 0.5)), "normalTexture": { "index": 0 } },
                { "pbrMetallicRoughness": factors([0.9, 1.0, 0.9], 0.0),
                  "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } } },
                { "pbrMetallicRoughness": textured(factors([0.4, 0.9, 0.3], 1.0)), "alphaMode": "MASK", "doubleSided": true }
            ],
            "textures": [{ "source": 0 }],
            "images": [{ "bufferView": image, "mimeType": "image/png" }],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "uri": "scene.bin", "byteLength": self.bin.len() }]
        });
        let folder = tempfile::TempDir::new().unwrap();
        std::fs::write(folder.path().join("scene.gltf"), document.to_string()).unwrap();
        std::fs::write(folder.path().join("scene.bin"), &self.bin).unwrap();
        folder
    }
}

/// Bumpy balls, glass and leaves with holes under a lamp, two or more of each: turned, stretched, mirrored.
fn crowd() -> tempfile::TempDir {
    let v = DVec3::new;
    let ball = |u: f64, v: f64| {
        // Equal angles have equal points, also at the seam.
        let (phi, theta) = (std::f64::consts::TAU * (u % 1.0), std::f64::consts::PI * v);
        let ring = if v == 0.0 || v == 1.0 { 0.0 } else { theta.sin() };
        DVec3::new(ring * phi.cos(), theta.cos(), -ring * phi.sin())
    };
    let leaf = |u: f64, v: f64| DVec3::new(u - 0.5, 0.2 * (3.0 * u).sin(), v - 0.5);
    let sheet = |size: f64, height: f64, up: f64| {
        move |u: f64, v: f64| DVec3::new(size * (u - 0.5), height, up * size * (v - 0.5))
    };
    let mut writer = Writer::default();
    let floor = writer.surface([1, 1], 0, sheet(12.0, 0.0, 1.0), false);
    let lamp = writer.surface([1, 1], 1, sheet(3.0, 5.0, -1.0), false);
    let [bumpy, glass] = [2, 3].map(|material| writer.surface([8, 12], material, ball, true));
    let leaf = writer.surface([2, 3], 4, leaf, false);
    let place = |position: DVec3, scale: DVec3, turn: f64| {
        let turned = DMat4::from_rotation_z(0.4 * turn) * DMat4::from_rotation_y(turn);
        DMat4::from_translation(position) * turned * DMat4::from_scale(scale)
    };
    writer.place(floor, DMat4::IDENTITY);
    writer.place(lamp, DMat4::IDENTITY);
    writer.place(bumpy, place(v(-1.6, 0.7, 0.0), v(0.7, 0.7, 0.7), 0.5));
    writer.place(bumpy, place(v(-0.3, 0.5, -1.0), v(-0.7, 0.4, 0.6), 1.0));
    writer.place(glass, place(v(0.6, 0.5, 1.0), v(0.5, 0.5, 0.5), 0.3));
    writer.place(glass, place(v(1.7, 0.8, 0.0), v(0.6, -0.8, 0.4), -0.4));
    writer.place(leaf, place(v(0.2, 1.9, 0.2), v(1.6, 1.0, 1.2), 0.6));
    writer.place(leaf, place(v(-1.2, 2.0, 0.4), v(-1.3, 1.0, 1.0), -0.3));
    writer.place(leaf, place(v(1.3, 2.2, -0.5), v(1.4, 2.0, 1.0), 2.0));
    let pixel = |x: u32, y: u32| {
        let lean = [128, 200, 128, 60][(x + y) as usize % 4];
        Rgba([lean, 255 - lean, 220, if (x / 2 + y / 2).is_multiple_of(3) { 0 } else { 255 }])
    };
    let mut texture = Cursor::new(Vec::new());
    RgbaImage::from_fn(8, 8, pixel).write_to(&mut texture, ImageFormat::Png).unwrap();
    writer.write(&texture.into_inner())
}

fn held(folder: &tempfile::TempDir, copies: Copies) -> SceneDescription {
    let options = LoadOptions { copies, ..LoadOptions::default() };
    let loaded = open_within(folder.path().join("scene.gltf"), &options, &Memory::unlimited()).unwrap();
    let prototypes = if copies == Copies::Shared { 3 } else { 0 };
    assert_eq!(loaded.description.prototypes.len(), prototypes);
    loaded.description
}

/// The control: one bumpy copy hangs under the lamp.
#[test]
fn shared_and_baked_copies_look_the_same() {
    let folder = crowd();
    let baked = World::new(held(&folder, Copies::Baked));
    let shared = World::new(held(&folder, Copies::Shared));
    let mut wrong = held(&folder, Copies::Shared);
    wrong.prototypes[0].places[0].translation.y += 3.2;
    let wrong = World::new(wrong);

    // The same random numbers find the same paths, but for rounding.
    for method in [Method::Path, Method::Bidirectional] {
        let settings = settings(method, Whole, 4.0);
        let [baked, shared, wrong] =
            [&baked, &shared, &wrong].map(|world| replicas(world, SIZE, &settings, 0..4).images);
        let differing = |other: &[Vec<f64>]| {
            let pairs = || baked.iter().flatten().zip(other.iter().flatten());
            pairs().filter(|(a, b)| (*a - *b).abs() > 1e-3 * a.abs()).count() as f64 / pairs().count() as f64
        };
        let [same, control] = [&shared, &wrong].map(|other| differing(other));
        println!("{method:?}: {same} of the values differ, of the control's {control}");
        assert!(same < 0.02 && control > 0.05, "{method:?}: {same}, {control}");
    }

    let rounds = 0..32;
    // With fewer mutations a round's dark blocks are far from normal, as one chain in some shows the light of a glint.
    let reference = replicas(&baked, SIZE, &settings(Method::Bidirectional, Whole, 256.0), rounds.clone());
    for stratification in [Whole, Grid(2, 2)] {
        let chains = settings(Method::Metropolis, stratification, 1024.0);
        let [same, control] = [&shared, &wrong].map(|world| {
            let image = replicas(world, SIZE, &chains, rounds.clone()).in_blocks(SIZE, 4);
            image.p_value(&reference.in_blocks(SIZE, 4))
        });
        assert_same(same, &format!("Metropolis, {stratification:?}"));
        assert_different(control, &format!("Metropolis, {stratification:?}, a copy in the wrong place"));
    }
}
