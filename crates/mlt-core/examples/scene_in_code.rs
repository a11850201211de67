//! A scene without a file: a lamp over a floor, rendered by Metropolis light transport with the lamp cut into 2×2 strata.
//!
//!     cargo run --release -p mlt-core --example scene_in_code

use mlt_core::glam::DVec3;
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::{Bsdf, Lambert};
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::image::mean_luminance;
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::render::{Method, Renderer, Settings};
use mlt_core::transport::scene::{CameraPose, Material, Scene, SceneDescription, UnusableScene, View};
use std::ops::ControlFlow;

fn main() -> Result<(), UnusableScene> {
    let description = SceneDescription {
        meshes: vec![
            // Counter-clockwise seen from the front: the floor faces up, the lamp down.
            square(0, 2.0, 0.0, [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]),
            square(1, 0.5, 2.0, [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
        ],
        materials: vec![material("floor", 0.7, 0.0), material("lamp", 0.0, 8.0)],
        ..SceneDescription::default()
    };
    let pose = CameraPose::look_at(DVec3::new(0.0, 1.8, 3.0), DVec3::new(0.0, 0.0, -0.06), 50f32.to_radians());
    let scene = Scene::new(description)?;
    let camera = scene.camera(&pose, [32, 24]);
    let settings = Settings::new(Method::Metropolis, 16.0).with(|s| s.stratification = Stratification::Grid(2, 2));
    let renderer = Renderer::new(View { scene: &scene, camera: &camera }, settings);
    let mut sums = renderer.sums();
    renderer.render(0..16, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let mean = mean_luminance(sums.film());
    println!("mean luminance {:.4} ± {:.4} from {} mutations", mean.mean, mean.stderr, sums.tally().steps());
    Ok(())
}

/// A square of half the side `half` at the height `y`, its corners in the order given.
fn square(material: u32, half: f64, y: f64, corners: [[f64; 2]; 4]) -> Mesh {
    Mesh { material, ..Mesh::quad(corners.map(|[x, z]| DVec3::new(half * x, y, half * z))) }
}

/// A diffuse surface that reflects and emits alike in all channels.
fn material(name: &str, reflectance: f32, emission: f32) -> Material {
    let bsdf = Bsdf::Lambert(Lambert { reflectance: Rgb::splat(reflectance) });
    Material { name: name.into(), bsdf, emission: Rgb::splat(emission), ..Material::default() }
}

#[test]
fn it_runs() {
    main().expect("a scene that can be rendered");
}
