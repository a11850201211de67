//! From options to a scene and a camera.

use anyhow::{Context, anyhow};
use glam::DVec3;
use mlt_core::transport::{
    camera::{Camera, CameraPose},
    description::SceneDescription,
    scene::{Scene, SurfaceName},
};

use crate::{Failure, args::render::RenderOptions, require_memory, warn};

/// Side of an image whose size is not given, pixels.
const USUAL_SIDE: f64 = 512.0;
/// Bytes a pixel: the film's sums and current round, and the image.
const BYTES_PER_PIXEL: u64 = 2 * 3 * 16 + 3 * 8 + 2 * 12;

/// What is rendered.
pub struct Setup {
    /// Name for the report.
    pub name: String,
    /// Surfaces and lights.
    pub scene: Scene,
    /// Where it is seen from, with the image's size.
    pub camera: Camera,
    /// What the loader left out.
    pub warnings: Vec<String>,
}

impl Setup {
    /// Loads the scene and finds the camera.
    pub fn new(options: &RenderOptions) -> Result<Self, Failure> {
        Self::edited(options, |_| ())
    }

    /// The same of a scene that is changed once it is loaded.
    pub fn edited(options: &RenderOptions, edit: impl FnOnce(&mut SceneDescription)) -> Result<Self, Failure> {
        let mut loaded = mlt_scene::open(&options.scene).map_err(|error| Failure::Usage(error.into()))?;
        edit(&mut loaded.description);
        let name = options.scene.display().to_string();
        let pose = pose(options, &loaded.description)?;
        let size = size(options, &pose);
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        require_memory(pixels * BYTES_PER_PIXEL, &format!("an image of {}x{}", size[0], size[1]))?;
        let scene = Scene::new(loaded.description).with_context(|| name.clone()).inspect_err(|_| {
            // What was left out may be why.
            loaded.warnings.iter().for_each(|warning| warn(warning));
        })?;
        let camera = scene.camera(&pose, size);
        let mut warnings = loaded.warnings;
        if scene.dropped() > 0 {
            warnings.push(format!("{} triangles have a corner that is not finite; they are left out", scene.dropped()));
        }
        warnings.extend(overlaps(scene.overlaps()));
        Ok(Self { name, scene, camera, warnings })
    }
}

/// Overlaps that are named one by one.
const NAMED: usize = 4;

/// Warnings of surfaces that lie in one plane, a light among them.
fn overlaps(pairs: &[[SurfaceName; 2]]) -> Vec<String> {
    let name = |surface: &SurfaceName| format!("mesh \"{}\" (material \"{}\")", surface.mesh, surface.material);
    let sentence = |[seen, hidden]: &[SurfaceName; 2]| {
        let [seen, hidden] = [seen, hidden].map(name);
        format!(
            "{seen} and {hidden} overlap in one plane; there only the first is seen, by every method: move one of them"
        )
    };
    let more = pairs.len().saturating_sub(NAMED);
    let rest = (more > 0).then(|| format!("{more} more pairs of meshes overlap in one plane, a light among each"));
    pairs.iter().take(NAMED).map(sentence).chain(rest).collect()
}

fn pose(options: &RenderOptions, scene: &SceneDescription) -> Result<CameraPose, Failure> {
    let fov = options.fov.map(|degrees| degrees.to_radians() as f32);
    if let (Some(from), Some(to)) = (options.camera_from, options.camera_to) {
        let [from, to] = [from, to].map(DVec3::from_array);
        return Ok(mlt_scene::camera_look_at(from, to, fov.unwrap_or(40f32.to_radians())));
    }
    let pose = match &options.camera {
        Some(name) => scene.cameras.iter().find(|camera| camera.name == *name).cloned().ok_or_else(|| {
            let names: Vec<_> = scene.cameras.iter().map(|camera| format!("\"{}\"", camera.name)).collect();
            let there = if names.is_empty() { "it has none".into() } else { format!("it has {}", names.join(", ")) };
            Failure::Usage(anyhow!("{}: there is no camera \"{name}\"; {there}", options.scene.display()))
        })?,
        None => match scene.cameras.first() {
            Some(camera) => camera.clone(),
            None => {
                let bounds = mlt_scene::bounds(scene)
                    .with_context(|| format!("{}: the scene has no triangle", options.scene.display()))?;
                mlt_scene::camera_framing(bounds)
            }
        },
    };
    Ok(CameraPose { vertical_fov: fov.unwrap_or(pose.vertical_fov), ..pose })
}

/// The size asked for, or one of the camera's aspect ratio.
fn size(options: &RenderOptions, pose: &CameraPose) -> [u32; 2] {
    match options.size {
        Some(size) => [size.width as u32, size.height as u32],
        None => {
            let aspect = f64::from(pose.aspect_ratio.unwrap_or(1.0)).clamp(1.0 / 16.0, 16.0);
            let (width, height) = (USUAL_SIDE * aspect.min(1.0), USUAL_SIDE / aspect.max(1.0));
            [width, height].map(|side| side.round() as u32)
        }
    }
}
