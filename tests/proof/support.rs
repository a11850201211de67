//! Scenes, replicas and comparisons for the statistical tests.

use glam::{DVec3, Vec3};
use mlt_core::engine::{Accumulated, Estimator, Film, Metropolis, Mixture, Share, render};
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::Bsdf;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::lights::{LightStrata, Stratification};
use mlt_core::transport::methods::MOST_EDGES;
use mlt_core::transport::methods::metropolis::{LightStratum, PathMutation};
use mlt_core::transport::paths::Luminance;
use mlt_core::transport::render::{Method, Renderer, Settings, film_unit};
use mlt_core::transport::scene::{Camera, CameraPose, Lens, Material, Scene, SceneDescription, View, rays_traced};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::ops::{ControlFlow, Range};

/// Chance that a right estimator is found wrong, for each comparison.
const SIGNIFICANCE: f64 = 1e-3;
/// Error of values that rounding in single precision may cause, relative.
const ROUNDING: f64 = 1e-5;

/// A scene and where it is seen from.
pub(crate) struct World {
    pub scene: Scene,
    pub pose: CameraPose,
}

impl World {
    pub(crate) fn new(mut description: SceneDescription) -> Self {
        let pose = description.cameras.remove(0);
        Self { scene: Scene::new(description).unwrap(), pose }
    }

    pub(crate) fn builtin(name: &str) -> Self {
        Self::new(mlt_scene::open(name).unwrap().description)
    }

    pub(crate) fn camera(&self, size: [u32; 2]) -> Camera {
        self.scene.camera(&self.pose, size)
    }
}

pub(crate) fn add(description: &mut SceneDescription, mesh: Mesh, bsdf: Bsdf, emission: Rgb) {
    description.meshes.push(Mesh { material: description.materials.len() as u32, ..mesh });
    description.materials.push(Material { bsdf, emission, ..Material::default() });
}

pub(crate) fn pose(position: DVec3, target: DVec3, degrees: f32) -> CameraPose {
    let forward = (target - position).as_vec3().normalize();
    let side = forward.cross(if forward.y.abs() < 0.9 { Vec3::Y } else { Vec3::NEG_Z }).normalize();
    CameraPose {
        name: String::new(),
        position,
        forward,
        up: side.cross(forward),
        lens: Lens::Pinhole { vertical_fov: degrees.to_radians() },
        aspect_ratio: None,
    }
}

/// Counter-clockwise seen from the front.
pub(crate) fn quad(corners: [[f64; 3]; 4]) -> Mesh {
    Mesh::quad(corners.map(DVec3::from_array))
}

/// Independent estimates of one small image.
#[derive(Clone)]
pub(crate) struct Replicas {
    /// Of each: all pixels' channels.
    pub images: Vec<Vec<f64>>,
}

pub(crate) fn settings(method: Method, stratification: Stratification, per_pixel: f64) -> Settings {
    Settings::new(method, per_pixel).with(|s| (s.stratification, s.seed) = (stratification, 1))
}

/// Every round is a replica.
pub(crate) fn replicas(world: &World, size: [u32; 2], settings: &Settings, rounds: Range<u64>) -> Replicas {
    let camera = world.camera(size);
    let renderer = Renderer::new(View { scene: &world.scene, camera: &camera }, settings.clone());
    let black = renderer.sums();
    let one = |round| {
        let mut sums = black.clone();
        renderer.render(round..round + 1, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        image(sums.film())
    };
    Replicas { images: rounds.into_par_iter().map(one).collect() }
}

/// Every round of an estimator is a replica.
pub(crate) fn replicas_of<E: Estimator<3>>(estimator: &E, pixels: u32, unit: f64, rounds: Range<u64>) -> Replicas {
    let one = |round| {
        let mut sums = Accumulated::new(Film::new(pixels, unit));
        render(estimator, round..round + 1, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        image(sums.film())
    };
    Replicas { images: rounds.into_par_iter().map(one).collect() }
}

/// Replicas by Metropolis, with equal shares for all strata and a sample for every four of the mutations.
pub(crate) fn metropolis(
    world: &World,
    size: [u32; 2],
    cut: Stratification,
    per_pixel: f64,
    rounds: Range<u64>,
) -> Replicas {
    metropolis_in(world, size, (cut, |_| true), per_pixel, rounds)
}

/// Contribution of some of the strata to [`metropolis`], replica by replica.
pub(crate) fn metropolis_in(
    world: &World,
    size: [u32; 2],
    (cut, included): (Stratification, impl Fn(usize) -> bool),
    per_pixel: f64,
    rounds: Range<u64>,
) -> Replicas {
    let camera = world.camera(size);
    let view = View { scene: &world.scene, camera: &camera };
    let strata = LightStrata::new(world.scene.lights(), cut);
    let strata = LightStratum::all(&strata, view, MOST_EDGES);
    let mutations = (per_pixel * f64::from(camera.pixels()) / strata.len() as f64).max(4.0) as u64;
    let share = Share { mutations, samples: mutations / 4 };
    let strata: Vec<_> =
        strata.into_iter().enumerate().filter(|(j, _)| included(*j)).map(|(_, s)| (s, share)).collect();
    let mixture = Mixture::new(PathMutation::all(view));
    let estimator = Metropolis::new(&strata, &mixture, &Luminance, 2).unwrap().counting(rays_traced);
    replicas_of(&estimator, camera.pixels(), film_unit(view), rounds)
}

fn image(film: &Film<3>) -> Vec<f64> {
    assert_eq!(film.lost().count, 0);
    (0..film.sites() as usize).flat_map(|i| film.pixel(i).map(|c| c.mean)).collect()
}

/// Values with their variances.
pub(crate) struct Known {
    pub values: Vec<f64>,
    pub variances: Vec<f64>,
}

impl Known {
    /// Values that are known but for rounding.
    pub(crate) fn exactly(values: Vec<f64>) -> Self {
        let variances = values.iter().map(|v| (v * ROUNDING).powi(2)).collect();
        Self { values, variances }
    }
}

impl Replicas {
    /// Adds `factor` × another estimate, replica by replica.
    pub(crate) fn plus(&self, factor: f64, other: &Self) -> Self {
        let add = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a + factor * b).collect();
        Self { images: self.images.iter().zip(&other.images).map(add).collect() }
    }

    /// Means over blocks of `side` × `side` pixels. A pixel that few replicas light has a mean that is not normal.
    pub(crate) fn in_blocks(&self, [width, height]: [u32; 2], side: u32) -> Self {
        let channels = 3;
        let block = |x: &Vec<f64>, column: u32, row: u32, channel: usize| {
            let pixels = (row..row + side).flat_map(|y| (column..column + side).map(move |x| (y * width + x) as usize));
            pixels.map(|pixel| x[channels * pixel + channel]).sum::<f64>() / f64::from(side * side)
        };
        let corners =
            || (0..height).step_by(side as usize).flat_map(|y| (0..width).step_by(side as usize).map(move |x| (x, y)));
        let pooled = |x: &Vec<f64>| {
            corners().flat_map(|(column, row)| (0..channels).map(move |c| block(x, column, row, c))).collect()
        };
        Self { images: self.images.iter().map(pooled).collect() }
    }

    /// Value and squared standard error of each of the image's numbers, and of their mean.
    fn estimates(&self) -> Vec<(f64, f64)> {
        let pixels = self.images[0].len();
        let mean_of = |x: &Vec<f64>| x.iter().sum::<f64>() / pixels as f64;
        let mut estimates: Vec<_> =
            (0..pixels).map(|i| moments(&self.images.iter().map(|x| x[i]).collect::<Vec<_>>())).collect();
        estimates.push(moments(&self.images.iter().map(mean_of).collect::<Vec<_>>()));
        estimates
    }

    /// p-value, corrected for the number of pixels and channels, of the hypothesis that both have one expectation.
    pub(crate) fn p_value(&self, other: &Self) -> f64 {
        let (n, m) = (self.images.len() as f64 - 1.0, other.images.len() as f64 - 1.0);
        let welch = |(a, va): (f64, f64), (b, vb): (f64, f64)| {
            let variance = va + vb;
            let freedom = variance * variance / (va * va / n + vb * vb / m);
            two_sided(a - b, variance, freedom)
        };
        corrected(self.estimates().into_iter().zip(other.estimates()).map(|(a, b)| welch(a, b)).collect())
    }

    /// The same against known values.
    pub(crate) fn p_value_of(&self, known: &Known) -> f64 {
        let n = known.values.len() as f64;
        let mean = known.values.iter().sum::<f64>() / n;
        let mean_variance = (mean * ROUNDING).powi(2).max(known.variances.iter().sum::<f64>() / (n * n));
        let values = known.values.iter().copied().chain([mean]);
        let variances = known.variances.iter().copied().chain([mean_variance]);
        let freedom = self.images.len() as f64 - 1.0;
        let p = |((a, va), (b, vb)): ((f64, f64), (f64, f64))| two_sided(a - b, va + vb, freedom);
        corrected(self.estimates().into_iter().zip(values.zip(variances)).map(p).collect())
    }

    /// Standard error of the image's mean, relative.
    pub(crate) fn relative_error(&self) -> f64 {
        let estimates = self.estimates();
        let (mean, square) = estimates[estimates.len() - 1];
        square.sqrt() / mean
    }
}

pub(crate) fn assert_same(p: f64, what: &str) {
    println!("{what}: p = {p:.2e}");
    assert!(p > SIGNIFICANCE, "{what}: p = {p:e}");
}

pub(crate) fn assert_different(p: f64, what: &str) {
    println!("{what}: p = {p:.2e}, as it must be");
    assert!(p < SIGNIFICANCE, "{what}: an error that has to be seen has p = {p:e}");
}

/// Mean and its squared standard error.
fn moments(x: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    (mean, x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}

fn two_sided(difference: f64, variance: f64, freedom: f64) -> f64 {
    if difference == 0.0 {
        return 1.0;
    }
    let t = difference.abs() / variance.sqrt();
    if t.is_infinite() {
        return 0.0;
    }
    2.0 * StudentsT::new(0.0, 1.0, freedom).unwrap().sf(t)
}

/// Bonferroni: half of the significance for the last test, the image's mean, half for the others together.
fn corrected(mut p: Vec<f64>) -> f64 {
    let mean = p.pop().unwrap();
    let least = p.iter().copied().fold(1.0, f64::min);
    (2.0 * mean.min(least * p.len() as f64)).min(1.0)
}
