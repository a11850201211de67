//! Light from all around that a file brings: EXT_lights_image_based.
//!
//! Of its prefiltered images the sharpest ones are the environment; what they send, and what is seen of them in mirrors, light itself finds, so
//! the blurred ones and the coefficients of irradiance are not needed.

use super::texture::Files;
use crate::{SceneError, images::Images};
use glam::{DVec2, DVec3, DVec4};
use gltf::Scene;
use mlt_core::transport::Rgb;
use mlt_core::transport::scene::{Environment, Pixels, srgb_to_linear};
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// The extension's name.
pub(super) const NAME: &str = "EXT_lights_image_based";

/// Most rows of the environment that is made of the cube.
const MOST_ROWS: u32 = 1024;
/// Memory for one of its pixels, bytes: those of the image, and the sums that directions are drawn by.
const BYTES_PER_PIXEL: u64 = 48;
/// Largest factor of its radiance: products with others stay finite in f32.
const BRIGHTEST: f64 = 1e6;
/// Samples along a side of a pixel.
const SAMPLES: u32 = 2;

/// Six square images that are the directions ±x, ±y, ±z.
struct Cube<'a> {
    faces: Vec<&'a Pixels>,
    /// Turns a direction of the scene into one of the cube: a unit quaternion.
    turn: DVec4,
}

/// The environment of a scene; `None`: it has none, or one that cannot be read, of which a warning tells.
pub(super) fn environment(
    files: &Files,
    scene: Option<&Scene>,
    warnings: &mut Vec<String>,
) -> Result<Option<Environment>, SceneError> {
    let Some(light) = scene.and_then(|scene| light(files, scene)) else { return Ok(None) };
    let left_out = |reason: &str| {
        format!("{NAME}: {reason}; the light is left out, and --environment FILE gives the scene another")
    };
    let faces: Option<Vec<usize>> = light.get("specularImages").and_then(|mips| {
        mips.get(0)?.as_array()?.iter().map(|image| image.as_u64().map(|image| image as usize)).collect()
    });
    let Some(faces) = faces.filter(|faces| faces.len() == 6) else {
        warnings.push(left_out("there are no six images of its first level"));
        return Ok(None);
    };
    let contents: BTreeMap<_, _> =
        faces.iter().map(|&face| (files.name_of_image(face), files.content_of_image(face))).collect();
    let images = Images::decode(files.source, contents, warnings)?;
    let pixels: Option<Vec<_>> = faces.iter().map(|&face| images.pixels(&files.name_of_image(face))).collect();
    let Some(pixels) = pixels.filter(|pixels| pixels.iter().all(|face| face.size().x == face.size().y)) else {
        warnings.push(left_out("one of its images cannot be read or is not square"));
        return Ok(None);
    };
    let number = |value: Option<&Value>, default: f64| value.and_then(Value::as_f64).unwrap_or(default);
    let part = |i: usize| number(light.get("rotation").and_then(|q| q.get(i)), if i == 3 { 1.0 } else { 0.0 });
    let turn = DVec4::new(-part(0), -part(1), -part(2), part(3)).try_normalize().unwrap_or(DVec4::W);
    let rows = (2 * pixels[0].size().x).clamp(4, MOST_ROWS);
    files.source.take(u64::from(2 * rows) * u64::from(rows) * BYTES_PER_PIXEL, "the environment".to_owned())?;
    let cube = Cube { faces: pixels, turn };
    let mut environment = cube.environment(rows);
    if let Some(environment) = &mut environment {
        environment.strength = number(light.get("intensity"), 1.0).clamp(0.0, BRIGHTEST) as f32;
    }
    Ok(environment)
}

/// The light that a scene names, as JSON.
fn light<'a>(files: &'a Files, scene: &Scene) -> Option<&'a Value> {
    let root = files.parsed.document.as_json();
    let named = root.scenes.get(scene.index())?.extensions.as_ref()?.others.get(NAME)?;
    let index = named.get("light")?.as_u64()? as usize;
    root.extensions.as_ref()?.others.get(NAME)?.get("lights")?.get(index)
}

impl Cube<'_> {
    /// As an equirectangular image of so many rows.
    fn environment(&self, rows: u32) -> Option<Environment> {
        let size = [2 * rows, rows];
        let share = |i: u32, sample: u32, of: u32| {
            (f64::from(i) + (f64::from(sample) + 0.5) / f64::from(SAMPLES)) / f64::from(of)
        };
        let samples = || (0..SAMPLES).flat_map(|a| (0..SAMPLES).map(move |b| [a, b]));
        let pixel = |i: u32, j: u32| -> Rgb {
            let at = |[a, b]: [u32; 2]| {
                let (azimuth, polar) = (TAU * share(i, a, size[0]) - PI, PI * share(j, b, rows));
                let (sin, cos) = (libm::sin(polar), libm::cos(polar));
                self.radiance(DVec3::new(sin * libm::cos(azimuth), cos, sin * libm::sin(azimuth)))
            };
            samples().map(at).sum::<Rgb>() / (SAMPLES * SAMPLES) as f32
        };
        let pixels = (0..rows).flat_map(|j| (0..size[0]).map(move |i| (i, j))).map(|(i, j)| pixel(i, j)).collect();
        Environment::image(size, pixels).map(|(environment, _)| environment)
    }

    /// From a direction of the scene, interpolated within a face.
    fn radiance(&self, direction: DVec3) -> Rgb {
        let (axis, w) = (self.turn.truncate(), self.turn.w);
        let d = direction + 2.0 * axis.cross(axis.cross(direction) + w * direction);
        let (face, place) = on_face(d);
        let pixels = self.faces[face];
        let last = f64::from(pixels.size().x - 1);
        let at = (place * f64::from(pixels.size().x) - 0.5).clamp(DVec2::ZERO, DVec2::splat(last));
        let (low, share) = (at.floor(), (at - at.floor()).as_vec2());
        let high = (low + 1.0).min(DVec2::splat(last));
        let read = |x: f64, y: f64| decoded(pixels.at(DVec2::new(x, y).as_uvec2()));
        let row = |y: f64| read(low.x, y).lerp(read(high.x, y), share.x);
        row(low.y).lerp(row(high.y), share.y)
    }
}

/// The face that a direction points at, and where, from its upper left corner. Each face is seen as from the middle of the cube, ±x and ±z with +y
/// upwards: mirrored to how graphics interfaces keep cubes, as the extension asks for.
fn on_face(d: DVec3) -> (usize, DVec2) {
    let a = d.abs();
    let (face, across, down, depth) = if a.x >= a.y && a.x >= a.z {
        if d.x > 0.0 { (0, d.z, -d.y, a.x) } else { (1, -d.z, -d.y, a.x) }
    } else if a.y >= a.z {
        if d.y > 0.0 { (2, -d.x, d.z, a.y) } else { (3, -d.x, -d.z, a.y) }
    } else if d.z > 0.0 {
        (4, -d.x, -d.y, a.z)
    } else {
        (5, d.x, -d.y, a.z)
    };
    (face, 0.5 * (DVec2::new(across, down) / depth + 1.0))
}

/// Radiance of a pixel: sRGB colours, in PNG with alpha (RGBD) divided by that.
fn decoded([r, g, b, divisor]: [u8; 4]) -> Rgb {
    let share = |x: u8| f32::from(x) / 255.0;
    Rgb::new(share(r), share(g), share(b)).map(srgb_to_linear) / share(divisor.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces of one colour each, the first with a bright pixel in its upper right corner.
    fn faces() -> Vec<Pixels> {
        let face = |i: u8| {
            let mut bytes = [20 * (i + 1), 0, 0, 255].repeat(16);
            if i == 0 {
                bytes[12..16].copy_from_slice(&[255, 255, 255, 51]);
            }
            Pixels::new([4, 4], 4, bytes).expect("as many bytes as pixels")
        };
        (0..6).map(face).collect()
    }

    #[test]
    fn faces_lie_where_the_extension_puts_them() {
        let faces = faces();
        let still = Cube { faces: faces.iter().collect(), turn: DVec4::W };
        for (i, direction) in
            [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].into_iter().enumerate()
        {
            let expected = srgb_to_linear(20.0 * (i + 1) as f32 / 255.0);
            assert!((still.radiance(direction).x - expected).abs() < 1e-6, "{direction}");
        }
        // Seen along +x, +z is to the right: white over an alpha of a fifth.
        let corner = still.radiance(DVec3::new(1.0, 0.99, 0.99));
        assert!(corner.distance(Rgb::splat(5.0)) < 1e-3, "{corner}");
        assert!(still.radiance(DVec3::new(1.0, 0.99, -0.99)).y < 1e-6);
        // A quarter turn about +y takes +z to +x.
        let half = 0.5f64.sqrt();
        let turned = Cube { faces: faces.iter().collect(), turn: DVec4::new(0.0, -half, 0.0, half) };
        assert!(turned.radiance(DVec3::X).distance(still.radiance(DVec3::Z)) < 1e-6);
    }
}
