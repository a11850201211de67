//! From options to a scene and a camera.

use std::time::Instant;

use anyhow::{Context, anyhow};
use mlt_core::memory::Memory;
use mlt_core::transport::scene::{
    Camera, CameraPose, Scene, SceneDescription, SceneGeometry, SurfaceName, UnusableScene,
};
use mlt_scene::{Entry, Loaded};
use tracing::info;

use super::pose::pose;
use crate::{
    Failure,
    args::{crop::Window, render::RenderOptions, values::Size},
    memory,
    provenance::{CameraUsed, Provenance},
    report::features,
    take_memory, warn_all,
};

/// Bytes a pixel, as a bound. The film's sums take 45 in most renders and 60 after a million samples a pixel; the current round takes 12, and once
/// that is freed the image as many; a file in the making takes up to 16. The rest is for pixels far brighter than the image, around which sums are wider.
const BYTES_PER_PIXEL: u64 = 96;
/// The same for further channels: as they are found, as they are kept, and in a file in the making.
const BYTES_PER_PIXEL_FEATURES: u64 = 180;
/// The same for sums that are read from a file or written to one.
const BYTES_PER_PIXEL_KEPT: u64 = 160;

/// The scene and the camera to render.
#[derive(Debug)]
pub(crate) struct Setup {
    /// Where the image comes from.
    pub provenance: Provenance,
    /// A hash of the scene's files.
    pub digest: String,
    /// Surfaces and lights.
    pub scene: Scene,
    /// Where it is seen from, with the image's size.
    pub camera: Camera,
    /// Size of the image that this one is, or is a part of.
    pub size: [u32; 2],
    /// The same camera as its file or the options say it.
    pub pose: CameraPose,
    /// The nodes of its file.
    pub outline: Vec<Entry>,
    /// The memory that the scene and the film leave for the rounds.
    pub memory: Memory,
}

impl Setup {
    /// Loads the scene and finds the camera.
    pub(crate) fn new(options: &RenderOptions) -> Result<Self, Failure> {
        Self::edited(options, |_| ())
    }

    /// The same of a scene that is changed once it is loaded.
    pub(crate) fn edited(options: &RenderOptions, edit: impl FnOnce(&mut SceneDescription)) -> Result<Self, Failure> {
        let (memory, start) = (memory(), Instant::now());
        let loaded = mlt_scene::open_within(&options.scene, &options.reading.load_options(), &memory);
        let mut loaded = loaded.map_err(|error| Failure::Usage(error.into()))?;
        edit(&mut loaded.description);
        info!("{} is read after {:.3} s", options.scene.display(), start.elapsed().as_secs_f64());
        Self::of(options, loaded, memory, None)
    }

    /// The same of a scene that is loaded, within what is left of its memory; `geometry`: of a scene before it, which may have the same.
    pub(crate) fn of(
        options: &RenderOptions,
        mut loaded: Loaded,
        memory: Memory,
        geometry: Option<SceneGeometry>,
    ) -> Result<Self, Failure> {
        let start = Instant::now();
        let (digest, mut warnings) = (loaded.digest.clone(), std::mem::take(&mut loaded.warnings));
        if loaded.neutral_sky {
            let words = "nothing in the file gives light, so a neutral sky does";
            warnings.push(format!("{words}; --environment chooses another, or none"));
        }
        let outline = std::mem::take(&mut loaded.outline);
        let Seen { scene, camera, size, pose, used } = seen(options, loaded, (&memory, geometry), &mut warnings)?;
        let (triangles, lights) = (scene.triangles(), scene.lights().lights.len());
        info!("{triangles} triangles and {lights} lights are set up in {:.3} s", start.elapsed().as_secs_f64());
        info!("camera {used}; the scene has {}", features::names(&features::features(scene.needs(), &pose.lens)));
        let provenance = Provenance { scene: options.scene.display().to_string(), camera: used, warnings };
        Ok(Self { provenance, digest, scene, camera, size, pose, outline, memory })
    }
}

/// A scene and the camera that sees it.
struct Seen {
    scene: Scene,
    camera: Camera,
    size: [u32; 2],
    pose: CameraPose,
    used: CameraUsed,
}

/// Memory for an image and the files in the making, bytes.
pub(crate) fn bytes_of_image(options: &RenderOptions, size: [u32; 2]) -> u64 {
    let kept = if options.keeps_sums() { BYTES_PER_PIXEL_KEPT } else { 0 };
    let features = if options.show.features() || options.show.denoise { BYTES_PER_PIXEL_FEATURES } else { 0 };
    u64::from(size[0]) * u64::from(size[1]) * (BYTES_PER_PIXEL + kept + features)
}

/// The scene and the camera, and memory taken for the film.
fn seen(
    options: &RenderOptions,
    loaded: Loaded,
    (memory, geometry): (&Memory, Option<SceneGeometry>),
    warnings: &mut Vec<String>,
) -> Result<Seen, Failure> {
    let framed = options.view.camera_from.is_none() && loaded.description.cameras.is_empty();
    let framing = || mlt_scene::bounds(&loaded.description).map(mlt_scene::camera_framing);
    let (pose, used) = pose(options, &loaded.description, framing)?;
    let Size { width, height } = options.view.size_for(pose.aspect_ratio.map_or(1.0, f64::from));
    let size = [width as u32, height as u32];
    let whole = Window { corner: [0, 0], size };
    let window = options.view.crop.map_or(Ok(whole), |crop| crop.window(size)).map_err(Failure::Usage)?;
    let [width, height] = window.size;
    take_memory(memory, bytes_of_image(options, window.size), &format!("an image of {width}x{height}"))?;
    let scene = Scene::with_geometry(loaded.description, geometry);
    // What was left out may be why it fails.
    let scene = scene
        .map_err(unusable)
        .with_context(|| options.scene.display().to_string())
        .inspect_err(|_| warn_all(warnings))?;
    let camera = scene.camera(&pose, size);
    let camera = if window == whole { camera } else { camera.part(window.corner, window.size) };
    if scene.dropped() > 0 {
        warnings.push(format!("{} triangles have a corner that is not finite; they are left out", scene.dropped()));
    }
    warnings.extend(overlaps(scene.overlaps()));
    if framed {
        let words = "no camera in the file can be used, so the scene is framed whole";
        warnings.push(format!("{words}; --camera-from and --camera-to choose a view"));
    }
    Ok(Seen { scene, camera, size, pose, used })
}

/// The error for a scene that cannot be rendered, with a word on how a file comes by its lights.
fn unusable(error: UnusableScene) -> anyhow::Error {
    match error {
        UnusableScene::NoLight => {
            anyhow!("{error}; a file by Blender's glTF export has its lamps if Include > Punctual Lights was ticked")
        }
        _ => error.into(),
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
