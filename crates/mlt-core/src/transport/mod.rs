//! The renderer: scenes of triangles, bidirectional path tracing, path-space mutations.
//!
//! # Rooms
//!
//! Each depends on those below it alone.
//!
//! | room | what it holds |
//! |---|---|
//! | [`render`] | A whole render: a method and what it counts. |
//! | [`methods`] | How light transport is computed: path tracing, bidirectional path tracing, Metropolis, and what chooses between them. |
//! | [`image`] | Arrays over pixels: errors, weights, the importance of a pixel. |
//! | [`paths`] | Light paths, their vertices, the densities of every way of making them, their classes. |
//! | [`lights`] | Parts of the lights: regions, cuts, strata, and the sampler that chooses a light for a vertex. |
//! | [`scene`] | Surfaces, materials, lights and cameras. |
//! | [`bsdf`] | Scattering functions. |
//! | [`accel`] | What a ray meets first. |
//! | [`geometry`] | Vertices, rays, meshes. |
//! | [`colour`] | Radiance and reflectance. |
//!
//! # A render
//!
//! ```
//! use mlt_core::glam::DVec3;
//! use mlt_core::transport::bsdf::{Bsdf, Lambert};
//! use mlt_core::transport::geometry::Mesh;
//! use mlt_core::transport::render::{Method, Renderer, Settings};
//! use mlt_core::transport::scene::{CameraPose, Material, Scene, SceneDescription, View};
//! use mlt_core::transport::{Rgb, image};
//! use std::ops::ControlFlow;
//!
//! // A floor that faces up, and above it a lamp that faces down.
//! let at = |y, z| [[-1.0, z], [1.0, z], [1.0, -z], [-1.0, -z]].map(|[x, z]| DVec3::new(x, y, z));
//! let meshes = vec![Mesh::quad(at(0.0, 1.0)), Mesh { material: 1, ..Mesh::quad(at(2.0, -1.0)) }];
//! let grey = Bsdf::Lambert(Lambert { reflectance: Rgb::splat(0.5) });
//! let floor = Material { bsdf: grey, ..Material::default() };
//! let lamp = Material { emission: Rgb::splat(3.0), ..Material::default() };
//! let scene = Scene::new(SceneDescription { meshes, materials: vec![floor, lamp], ..SceneDescription::default() })?;
//! let camera = scene.camera(&CameraPose::look_at(DVec3::Y, DVec3::ZERO, 1.0), [8, 8]);
//! let renderer = Renderer::new(View { scene: &scene, camera: &camera }, Settings::new(Method::Path, 16.0));
//! let mut sums = renderer.sums();
//! renderer.render(0..8, &mut sums, &mut |_, _| ControlFlow::Continue(()));
//! // Form factor of parallel squares at a distance of their side, in the middle: about 0.24; the floor shows 0.5 × 3 × that.
//! assert!((image::mean_luminance(sums.film()).mean - 0.34).abs() < 0.05);
//! # Ok::<(), mlt_core::transport::scene::UnusableScene>(())
//! ```

pub mod accel;
pub mod bsdf;
pub mod colour;
pub mod geometry;
pub mod image;
pub mod lights;
pub mod methods;
pub mod paths;
pub mod render;
pub mod scene;
#[cfg(test)]
mod tests;

pub use colour::{LUMINANCE, Rgb, luminance};
