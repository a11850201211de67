//! Features of the surfaces that are seen.

use super::albedo::albedo;
use crate::engine::mixed;
use crate::transport::colour::Rgb;
use crate::transport::methods::{OwenSobol, point_in_pixel};
use crate::transport::scene::View;
use glam::Vec3A;
use rand_pcg::rand_core::TryRng;
use rayon::prelude::*;
use std::convert::Infallible;

/// Rays through each pixel whose mean is taken.
const RAYS: u64 = 16;
/// Key of their sequences.
const KEY: u64 = 0x5ee1;

/// Depth where nothing is seen, as Cycles has it.
pub const NOWHERE: f32 = 1e10;

/// The surface that is seen through a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceFeatures {
    /// Mean reflectance over the pixel, 0…1; 0 where nothing is seen. A mirror or smooth glass has that of what is seen in it, by
    /// Fresnel's shares of both ways, and 1 where that is the sky.
    pub albedo: [f32; 3],
    /// Mean over the pixel of the unit shading normals in world space, turned to the camera; 0 where nothing is seen.
    pub normal: [f32; 3],
    /// World position of the first surface at the pixel's centre; 0 where nothing is seen.
    pub position: [f32; 3],
    /// Its distance from the camera along the viewing direction, world units; [`NOWHERE`] where nothing is seen.
    pub depth: f32,
}

/// Features of all pixels, row by row, on the current rayon pool.
///
/// The first surface counts, glass too. Of surfaces that are not opaque means take each as often as it is there, and a pixel's centre shows the
/// first whose opacity is above ½. An environment is no surface.
pub fn surfaces(view: View) -> Vec<SurfaceFeatures> {
    (0..u64::from(view.camera.pixels())).into_par_iter().map(|pixel| of_pixel(view, pixel)).collect()
}

fn of_pixel(view: View, pixel: u64) -> SurfaceFeatures {
    let View { scene, camera } = view;
    let (mut albedo_sum, mut normal_sum) = (Rgb::ZERO, Vec3A::ZERO);
    let mut rng = OwenSobol::new(mixed(KEY ^ pixel));
    for index in 0..RAYS {
        rng.go_to(index);
        let film = point_in_pixel(pixel, camera.size(), &mut rng);
        let lens = camera.sample_lens(&mut rng);
        let ray = camera.sample(film, &lens);
        let Some((vertex, _)) = scene.follow_camera_ray(ray.origin, ray.step, &mut rng) else { continue };
        if !vertex.is_distant() {
            let to_eye = -ray.direction();
            albedo_sum += albedo(scene, &vertex, to_eye, &mut rng);
            normal_sum += vertex.shading_normal * 1f32.copysign(vertex.shading_normal.dot(to_eye));
        }
    }
    let (position, depth) = centre(view, pixel).unwrap_or(([0.0; 3], NOWHERE));
    SurfaceFeatures {
        albedo: (albedo_sum / RAYS as f32).clamp(Rgb::ZERO, Rgb::ONE).to_array(),
        normal: (normal_sum / RAYS as f32).to_array(),
        position,
        depth,
    }
}

/// World position and depth of what the middle of the lens sees at a pixel's centre.
fn centre(View { scene, camera }: View, pixel: u64) -> Option<([f32; 3], f32)> {
    let (lens, film) = (camera.vertex(), point_in_pixel(pixel, camera.size(), &mut Halves));
    let ray = camera.sample(film, &lens);
    let (vertex, _) = scene.follow_camera_ray(ray.origin, ray.step, &mut Halves)?;
    let position = scene.world_position(&vertex);
    let depth = (position - scene.world_position(&lens)).dot(lens.geometric_normal.as_dvec3());
    (!vertex.is_distant()).then(|| (position.as_vec3().to_array(), depth as f32))
}

/// Numbers that are all ½.
struct Halves;

impl TryRng for Halves {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(1 << 31)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(1 << 63)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.fill(1 << 7);
        Ok(())
    }
}
