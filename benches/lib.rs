//! Code that the benchmarks share.
#![allow(missing_debug_implementations, reason = "nobody prints what benchmarks share")]

pub mod contest;
pub mod embree;
pub mod rays;
pub mod stage;
pub mod tracer;

use mlt_core::transport::render::{Method, Settings};
use mlt_core::transport::scene::{Camera, Scene, View};

/// A built-in scene, ready to render.
pub struct Loaded {
    /// Surfaces and lights.
    pub scene: Scene,
    /// The scene's first camera.
    pub camera: Camera,
}

impl Loaded {
    /// The built-in scene `name`, for images of `size` pixels.
    ///
    /// # Panics
    /// If there is no such scene.
    pub fn builtin(name: &str, size: [u32; 2]) -> Self {
        let description = mlt_scene::open(name).expect("a built-in scene").description;
        let pose = description.cameras[0].clone();
        let scene = Scene::new(description).expect("a usable scene");
        let camera = scene.camera(&pose, size);
        Self { scene, camera }
    }

    /// Scene and camera.
    pub fn view(&self) -> View<'_> {
        View { scene: &self.scene, camera: &self.camera }
    }

    /// Settings without strata and without a limit on lengths.
    pub fn settings(&self, method: Method, per_pixel: f64) -> Settings {
        Settings::new(method, per_pixel).with(|s| s.seed = 1)
    }
}
