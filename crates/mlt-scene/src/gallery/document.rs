//! A glTF document in the making: few materials, few triangles, one camera, everything in one text file.

use base64::{Engine, prelude::BASE64_STANDARD};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

/// Index of a material.
pub(super) type Paint = usize;

/// Triangles with corners of their own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    /// Corners, scene units.
    pub positions: Vec<DVec3>,
    /// Shading normals, one a corner; empty: flat.
    pub normals: Vec<Vec3>,
    /// Counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Both together; the other's corners come behind. Both have normals or none has.
    pub(crate) fn and(mut self, other: Self) -> Self {
        let first = self.positions.len() as u32;
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self
    }

    /// Each corner moved.
    pub(crate) fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        self.positions.iter_mut().for_each(|p| *p = f(*p));
        self
    }
}

/// Where the camera stands, what it looks at, and its vertical opening angle in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    pub from: DVec3,
    pub to: DVec3,
    pub fov: f32,
}

/// A glTF 2.0 document.
pub(super) struct Document {
    materials: Vec<Value>,
    meshes: Vec<(String, Paint, Shape)>,
    eye: Eye,
    /// Column-major matrix above all nodes.
    pub root: Option<[f32; 16]>,
}

impl Document {
    /// Nothing but a camera.
    pub(super) fn new(eye: Eye) -> Self {
        Self { materials: Vec::new(), meshes: Vec::new(), eye, root: None }
    }

    /// Moves the camera.
    pub(super) fn look(&mut self, eye: Eye) {
        self.eye = eye;
    }

    /// A diffuse surface without a coat.
    pub(super) fn diffuse(&mut self, name: &str, [r, g, b]: [f32; 3]) -> Paint {
        self.material(json!({
            "name": name,
            "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0, "roughnessFactor": 1 },
            "doubleSided": true,
            "extensions": { "KHR_materials_specular": { "specularFactor": 0 } }
        }))
    }

    /// A metal of this roughness.
    pub(super) fn metal(&mut self, name: &str, [r, g, b]: [f32; 3], roughness: f32) -> Paint {
        self.material(json!({
            "name": name,
            "pbrMetallicRoughness":
                { "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 1, "roughnessFactor": roughness },
            "doubleSided": true
        }))
    }

    /// The smooth boundary of a solid.
    pub(super) fn glass(&mut self, name: &str, ior: f32) -> Paint {
        self.material(json!({
            "name": name,
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
            "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": 1 },
                "KHR_materials_ior": { "ior": ior },
                "KHR_materials_volume": { "thicknessFactor": 1 }
            }
        }))
    }

    /// A black surface with this radiance from its front.
    pub(super) fn light(&mut self, name: &str, radiance: [f32; 3]) -> Paint {
        let strength = radiance.into_iter().fold(0.0, f32::max);
        self.material(json!({
            "name": name,
            "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1 },
            "emissiveFactor": radiance.map(|r| r / strength),
            "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": strength },
                "KHR_materials_specular": { "specularFactor": 0 }
            }
        }))
    }

    fn material(&mut self, material: Value) -> Paint {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Adds a mesh.
    pub(super) fn add(&mut self, name: &str, paint: Paint, shape: Shape) {
        self.meshes.push((name.to_owned(), paint, shape));
    }

    /// The file, with its geometry in a data URI.
    pub(super) fn text(&self) -> String {
        let mut buffer = Buffer::default();
        let mesh = |(name, paint, shape): &(String, Paint, Shape)| {
            let positions: Vec<_> = shape.positions.iter().map(|p| p.as_vec3()).collect();
            let mut attributes = json!({ "POSITION": buffer.vectors(&positions, true) });
            if !shape.normals.is_empty() {
                attributes["NORMAL"] = buffer.vectors(&shape.normals, false).into();
            }
            let indices = buffer.indices(&shape.triangles);
            json!({ "name": name, "primitives": [{ "attributes": attributes, "indices": indices, "material": paint }] })
        };
        let meshes: Vec<_> = self.meshes.iter().map(mesh).collect();
        let mut nodes = vec![camera_node(&self.eye)];
        let node = |(index, (name, ..)): (usize, &(String, Paint, Shape))| json!({ "name": name, "mesh": index });
        nodes.extend(self.meshes.iter().enumerate().map(node));
        let mut roots: Vec<usize> = (0..nodes.len()).collect();
        if let Some(matrix) = self.root {
            nodes.push(json!({ "name": "root", "children": roots, "matrix": matrix }));
            roots = vec![nodes.len() - 1];
        }
        let lens = json!({ "aspectRatio": 1, "yfov": self.eye.fov, "znear": 0.01 });
        let data = BASE64_STANDARD.encode(&buffer.bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        let document = json!({
            "asset": { "version": "2.0", "generator": "mlt" },
            "extensionsUsed": self.extensions(),
            "scene": 0,
            "scenes": [{ "nodes": roots }],
            "nodes": nodes,
            "cameras": [{ "type": "perspective", "perspective": lens }],
            "materials": self.materials,
            "meshes": meshes,
            "accessors": buffer.accessors,
            "bufferViews": buffer.views,
            "buffers": [{ "byteLength": buffer.bytes.len(), "uri": uri }]
        });
        format!("{document:#}\n")
    }

    fn extensions(&self) -> Vec<String> {
        let of = |material: &Value| -> Vec<String> {
            material["extensions"].as_object().map_or_else(Vec::new, |map| map.keys().cloned().collect())
        };
        let mut names: Vec<_> = self.materials.iter().flat_map(of).collect();
        names.sort_unstable();
        names.dedup();
        names
    }
}

fn camera_node(eye: &Eye) -> Value {
    let back = (eye.from - eye.to).normalize();
    let up = if back.y.abs() < 0.999 { DVec3::Y } else { DVec3::NEG_Z };
    let right = up.cross(back).normalize();
    let columns = [right.extend(0.0), back.cross(right).extend(0.0), back.extend(0.0), eye.from.extend(1.0)];
    let matrix: Vec<f32> = columns.iter().flat_map(|c| c.as_vec4().to_array()).collect();
    json!({ "name": "camera", "camera": 0, "matrix": matrix })
}

/// The binary part.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Index of a new accessor for these vectors.
    fn vectors(&mut self, vectors: &[Vec3], bounded: bool) -> usize {
        let bytes = vectors.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect();
        let mut accessor = json!({ "componentType": 5126, "count": vectors.len(), "type": "VEC3" });
        if bounded {
            let bound = |f: fn(Vec3, Vec3) -> Vec3| vectors.iter().copied().reduce(f).unwrap_or_default().to_array();
            accessor["min"] = bound(Vec3::min).to_vec().into();
            accessor["max"] = bound(Vec3::max).to_vec().into();
        }
        self.push(bytes, accessor)
    }

    fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        self.push(bytes, json!({ "componentType": 5125, "count": 3 * triangles.len(), "type": "SCALAR" }))
    }

    fn push(&mut self, bytes: Vec<u8>, mut accessor: Value) -> usize {
        accessor["bufferView"] = self.views.len().into();
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}
