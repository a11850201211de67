//! Textured surfaces and lamps, alpha and unlit surfaces, each against what it must look like in every method.
//!
//! A quad of 2 × 2 pixels fills the view, a quarter of it each pixel. Around it is a furnace, radiance 1 from everywhere, in which a
//! surface of albedo ρ shows ρ and a hole shows 1.

use super::support::{Render, render};
use serde_json::{Value, json};
use std::{fs, path::Path};

const METHODS: [&str; 6] = [
    "pt --samples-per-pixel 64",
    "bdpt --samples-per-pixel 64",
    "mlt --mutations-per-pixel 256",
    "pssmlt --mutations-per-pixel 128",
    "mmlt --mutations-per-pixel 2048",
    "auto --samples-per-pixel 64",
];

/// sRGB's transfer function.
fn linear(byte: u8) -> f64 {
    let x = f64::from(byte) / 255.0;
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// A quad before the camera, its material, and the material of the walls around both.
struct Scene {
    material: Value,
    walls: Value,
    /// Pixels of each texture, RGBA.
    textures: Vec<[[u8; 4]; 4]>,
    colours: Option<[[f32; 4]; 4]>,
}

impl Scene {
    fn furnace(material: Value, textures: Vec<[[u8; 4]; 4]>) -> Self {
        let walls = json!({ "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] },
            "extensions": { "KHR_materials_specular": { "specularFactor": 0 } } });
        Self { material, walls, textures, colours: None }
    }

    fn write(&self, folder: &Path) -> String {
        let mut bin = Vec::new();
        let mut floats = |values: &[f32]| values.iter().for_each(|v| bin.extend(v.to_le_bytes()));
        let quad = [-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.];
        floats(&quad);
        floats(&[0., 1., 1., 1., 1., 0., 0., 0.]);
        let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|bit| if bit == 1 { 4.0f32 } else { -4.0 });
        (0..8).for_each(|i| floats(&corner(i)));
        floats(self.colours.unwrap_or([[1.0; 4]; 4]).as_flattened());
        // Seen from inside, counter-clockwise.
        let inside = [
            0u16, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7,
            5,
        ];
        for index in [0u16, 1, 2, 0, 2, 3]
            .into_iter()
            .chain(inside.into_iter().collect::<Vec<_>>().chunks(3).flat_map(|t| [t[0], t[2], t[1]]))
        {
            bin.extend(index.to_le_bytes());
        }
        fs::write(folder.join("scene.bin"), &bin).expect("written");
        for (i, pixels) in self.textures.iter().enumerate() {
            let image = image::RgbaImage::from_fn(2, 2, |x, y| image::Rgba(pixels[(2 * y + x) as usize]));
            image.save(folder.join(format!("{i}.png"))).expect("written");
        }
        let mut attributes = json!({ "POSITION": 0, "TEXCOORD_0": 1 });
        if self.colours.is_some() {
            attributes["COLOR_0"] = 3.into();
        }
        let view = |offset: usize, length: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": length });
        let document = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
            "nodes": [{ "mesh": 0 }, { "mesh": 1 }, { "camera": 0, "translation": [0, 0, 1] }],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": std::f64::consts::FRAC_PI_2, "znear": 0.1 } }],
            "materials": [self.material, self.walls],
            "meshes": [{ "primitives": [{ "attributes": attributes, "indices": 4, "material": 0 }] },
                       { "primitives": [{ "attributes": { "POSITION": 2 }, "indices": 5, "material": 1 }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
                { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
                { "bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC3" },
                { "bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4" },
                { "bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR" },
                { "bufferView": 4, "byteOffset": 12, "componentType": 5123, "count": 36, "type": "SCALAR" }
            ],
            "bufferViews": [view(0, 48), view(48, 32), view(80, 96), view(176, 64), view(240, 84)],
            "buffers": [{ "uri": "scene.bin", "byteLength": bin.len() }],
            "samplers": [{ "magFilter": 9728 }],
            "images": (0..self.textures.len()).map(|i| json!({ "uri": format!("{i}.png") })).collect::<Vec<_>>(),
            "textures": (0..self.textures.len()).map(|i| json!({ "source": i, "sampler": 0 })).collect::<Vec<_>>(),
        });
        fs::write(folder.join("scene.gltf"), document.to_string()).expect("written");
        folder.join("scene.gltf").display().to_string()
    }

    fn render(&self, method: &str) -> Render {
        let folder = tempfile::tempdir().expect("a folder");
        render(&self.write(folder.path()), &format!("--size 8x8 --threads 1 --method {method}"))
    }

    /// Fails unless every method gives this mean luminance.
    fn expect(&self, truth: f64) {
        for method in METHODS {
            let found = self.render(method);
            let (b, stderr) = found.b();
            assert!((b - truth).abs() < 2e-3 + 4.5 * stderr, "{method}: {b} ± {stderr}, not {truth}: {}", found.said);
        }
    }

    /// Fails if any method gives this mean luminance: the control.
    fn expect_not(&self, wrong: f64) {
        for method in METHODS {
            let (b, stderr) = self.render(method).b();
            assert!((b - wrong).abs() > 5e-3 + 4.5 * stderr, "{method}: {b} ± {stderr} is taken for {wrong}");
        }
    }
}

const GREYS: [u8; 4] = [0, 255, 90, 188];

/// A grey picture, opaque.
fn greys() -> [[u8; 4]; 4] {
    GREYS.map(|g| [g, g, g, 255])
}

fn diffuse(more: Value) -> Value {
    let mut material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicFactor": 0 },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } } });
    material.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
    material
}

fn mean_grey() -> f64 {
    GREYS.iter().map(|&g| linear(g)).sum::<f64>() / 4.0
}

#[test]
fn a_textured_surface_in_a_furnace_shows_the_mean_of_its_texture() {
    let scene = Scene::furnace(diffuse(json!({})), vec![greys()]);
    scene.expect(mean_grey());
    // Without the decoding of sRGB it would show this.
    scene.expect_not(GREYS.iter().map(|&g| f64::from(g) / 255.0).sum::<f64>() / 4.0);
}

#[test]
fn vertex_colours_are_a_factor() {
    let scene = Scene { colours: Some([[0.5, 0.5, 0.5, 1.0]; 4]), ..Scene::furnace(diffuse(json!({})), vec![greys()]) };
    scene.expect(0.5 * mean_grey());
}

/// Pixels of white, of which three are there by their alphas.
#[test]
fn a_mask_has_holes_in_every_method() {
    let alphas = [0u8, 128, 200, 255].map(|a| [0, 0, 0, a]);
    Scene::furnace(diffuse(json!({ "alphaMode": "MASK" })), vec![alphas]).expect(0.25);
    Scene::furnace(diffuse(json!({ "alphaMode": "MASK", "alphaCutoff": 0.6 })), vec![alphas]).expect(0.5);
    Scene::furnace(diffuse(json!({ "alphaMode": "OPAQUE" })), vec![alphas]).expect(0.0);
}

#[test]
fn blended_surfaces_let_pass_what_their_alpha_leaves() {
    let alphas = [0u8, 51, 204, 255].map(|a| [0, 0, 0, a]);
    let scene = Scene::furnace(diffuse(json!({ "alphaMode": "BLEND" })), vec![alphas]);
    scene.expect(0.5);
    let half = Scene { colours: Some([[1.0, 1.0, 1.0, 0.5]; 4]), ..scene };
    half.expect(0.75);
    half.expect_not(0.5);
}

/// Walls that reflect nothing: the lamp is all that is seen.
#[test]
fn a_lamp_shows_its_texture() {
    let dark = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } } });
    let glow = json!({ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 },
        "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } } });
    let scene = Scene { walls: dark.clone(), ..Scene::furnace(glow, vec![greys()]) };
    scene.expect(mean_grey());
    scene.expect_not(1.0);
    let unlit = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_unlit": {} } });
    let scene = Scene { walls: dark, colours: Some([[0.5, 0.5, 0.5, 1.0]; 4]), ..Scene::furnace(unlit, vec![greys()]) };
    scene.expect(0.5 * mean_grey());
}

/// The look of an unlit surface does not depend on light.
#[test]
fn an_unlit_surface_shows_its_colour_in_any_light() {
    let unlit = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_unlit": {} } });
    let scene = Scene::furnace(unlit, vec![greys()]);
    scene.expect(mean_grey());
}

/// A white base under a coat of any reflectance and gloss is white in a furnace.
#[test]
fn specular_and_gloss_vary_over_a_surface() {
    let old = json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": { "glossinessFactor": 0.8,
        "specularGlossinessTexture": { "index": 0 } } } });
    let scene =
        Scene::furnace(old, vec![[[0, 30, 90, 255], [255, 255, 255, 200], [40, 40, 40, 0], [90, 200, 255, 90]]]);
    scene.expect(1.0);
}

/// A solid of index 1 before the camera, of which the walls are seen through.
#[test]
fn a_solid_leaves_of_light_what_its_depth_says() {
    let glass = json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1 },
            "KHR_materials_volume": { "attenuationDistance": 2, "attenuationColor": [0.25, 0.25, 0.25] } },
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 } });
    // The walls are 4 from the quad's middle; it is the face of a solid that ends there.
    let scene = Scene::furnace(glass, Vec::new());
    let found = scene.render("pt --samples-per-pixel 256");
    // The mean over the view of 0.25^(d/2), by the midpoint rule; d to the first wall that is met.
    let share = |i: u32| f64::from(2 * i + 1) / 256.0 - 1.0;
    let depth = |x: f64, y: f64| [x, y].iter().map(|x| (4.0 - x.abs()) / x.abs()).fold(4.0, f64::min);
    let left = |x: f64, y: f64| 0.25f64.powf(0.5 * depth(x, y) * (1.0 + x * x + y * y).sqrt());
    let mean = (0..256).map(|i| (0..256).map(|j| left(share(i), share(j))).sum::<f64>()).sum::<f64>() / 65536.0;
    let (b, stderr) = found.b();
    assert!((b - mean).abs() < 1e-3 + 4.5 * stderr, "{b} ± {stderr}, not {mean}: {}", found.said);
    scene.expect(mean);
    scene.expect_not(1.0);
}

/// A metal in a furnace shows its colour whatever its roughness, and a dielectric white.
#[test]
fn metalness_and_roughness_vary_over_a_surface() {
    let metal = json!({ "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 1], "metallicRoughnessTexture": { "index": 0 } } });
    let scene =
        Scene::furnace(metal, vec![[[0, 30, 0, 255], [0, 90, 255, 255], [0, 255, 128, 255], [0, 200, 255, 255]]]);
    scene.expect(1.0);
}

/// A sheet with holes between a lamp and a floor, and a sheet that glows as its texture says: all methods agree.
#[test]
fn methods_agree_about_holes_and_textured_lamps() {
    for file in ["files/alpha-mask.gltf", "files/emissive-texture.gltf"] {
        let render = |method: &str| render(file, &format!("--size 16x16 --threads 1 --method {method}"));
        let (truth, stderr) = render("pt --samples-per-pixel 1024").b();
        for method in METHODS {
            render(method).expect_b(truth, 4.5 * stderr);
        }
    }
}

/// The control of the test above: a sheet without its holes, and one that glows all over, are told apart.
#[test]
fn a_forgotten_texture_is_seen() {
    for (file, from, to) in
        [("alpha-mask", "\"MASK\"", "\"OPAQUE\""), ("emissive-texture", "\"emissiveTexture\"", "\"normalTexture\"")]
    {
        let text = fs::read_to_string(super::support::data(&format!("files/{file}.gltf"))).expect("a scene");
        let folder = tempfile::tempdir().expect("a folder");
        let changed = folder.path().join("scene.gltf");
        assert!(text.contains(from), "{file}");
        fs::write(&changed, text.replace(from, to)).expect("written");
        let method = "--size 16x16 --threads 1 --method pt --samples-per-pixel 256";
        let (right, wrong) =
            (render(&format!("files/{file}.gltf"), method), render(&changed.to_string_lossy(), method));
        let ((a, sa), (b, sb)) = (right.b(), wrong.b());
        assert!((a - b).abs() > 9.0 * (sa + sb), "{file}: {a} ± {sa} and {b} ± {sb}");
    }
}
