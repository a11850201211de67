//! `mlt inspect`: what a scene holds, and what a render would make of it.

mod lights;
mod text;

use anyhow::Context;
use mlt_core::transport::scene::SceneDescription;
use mlt_scene::{Entry, printable};
use serde::Serialize;

use crate::{
    Failure,
    args::{contestant::Contestant, inspect::InspectOptions, render::RenderOptions},
    print,
    provenance::CameraUsed,
    render::{Setup, bytes_of_image},
    report::features::{Feature, features},
};
use lights::LightCounts;

/// The content of a scene; [`Display`](std::fmt::Display) is the same for reading.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// The scene as named on the command line.
    pub scene: String,
    /// The nodes of the file that are shown, depth first.
    pub nodes: Vec<Node>,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of materials.
    pub materials: usize,
    /// Number of images on surfaces.
    pub textures: usize,
    /// Cameras of the file.
    pub cameras: Vec<CameraUsed>,
    /// The camera that a render would take, and why.
    pub camera: CameraUsed,
    /// Width and height of its image, pixels.
    pub size: [u32; 2],
    /// Lights by kind, and those that give no light.
    pub lights: LightCounts,
    /// Features that the scene has or lacks.
    pub features: Vec<Feature>,
    /// Memory, bytes.
    pub memory: MemoryUse,
    /// Parts that could not be taken over, and the remedies.
    pub warnings: Vec<String>,
}

/// A node of the scene's file.
#[derive(Debug, Serialize)]
pub struct Node {
    /// Number of nodes above it.
    pub depth: usize,
    /// Its name.
    pub name: String,
    /// The thing that stands there, in words.
    pub parts: Vec<String>,
}

/// Memory, bytes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MemoryUse {
    /// Triangles with their normals and texture coordinates.
    pub geometry: usize,
    /// The bounding-volume hierarchy.
    pub acceleration: usize,
    /// Images on surfaces.
    pub textures: usize,
    /// The image and its error bars, while it is rendered and written.
    pub image: u64,
    /// All of it while the scene is set up, at most.
    pub peak: u64,
    /// Memory that the machine had left before.
    pub available: u64,
}

/// Reads the scene and prints what is in it.
pub fn run(options: &InspectOptions) -> Result<(), Failure> {
    let inspection = inspect(options)?;
    let text = match options.json {
        true => serde_json::to_string_pretty(&inspection).context("cannot encode the answer")? + "\n",
        false => inspection.to_string().lines().map(|line| printable(line, usize::MAX) + "\n").collect(),
    };
    Ok(print(&text)?)
}

fn inspect(options: &InspectOptions) -> Result<Inspection, Failure> {
    let usual = Contestant::default().render_options(&options.scene, &[]);
    let usual = usual.map_err(|reason| Failure::Usage(anyhow::anyhow!(reason)))?;
    let options = RenderOptions { view: options.view.clone(), reading: options.reading.clone(), ..usual };
    let mut found = InFile::default();
    let setup = Setup::edited(&options, |description| found = InFile::of(description))?;
    let (scene, size) = (&setup.scene, setup.size);
    let (footprint, lens) = (scene.footprint(), setup.pose.lens);
    Ok(Inspection {
        scene: setup.provenance.scene,
        nodes: setup.outline.into_iter().map(Node::from).collect(),
        triangles: scene.triangles(),
        materials: found.materials,
        textures: found.textures,
        cameras: found.cameras,
        camera: setup.provenance.camera,
        size,
        lights: found.lights.among(scene.lights()),
        features: features(scene.needs(), &lens),
        memory: MemoryUse {
            geometry: footprint.geometry,
            acceleration: footprint.acceleration,
            textures: footprint.textures,
            image: bytes_of_image(&options, setup.camera.size()),
            peak: setup.memory.taken(),
            available: setup.memory.total(),
        },
        warnings: setup.provenance.warnings,
    })
}

/// Facts of a scene's file that are gone from the scene that is made of it.
#[derive(Default)]
struct InFile {
    cameras: Vec<CameraUsed>,
    materials: usize,
    textures: usize,
    lights: LightCounts,
}

impl InFile {
    fn of(scene: &SceneDescription) -> Self {
        Self {
            cameras: scene.cameras.iter().map(|pose| CameraUsed::new(pose, "in the file")).collect(),
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            lights: LightCounts::of(scene),
        }
    }
}

impl From<Entry> for Node {
    fn from(Entry { depth, name, parts }: Entry) -> Self {
        Self { depth, name, parts }
    }
}
