//! Sends rays from inside closed meshes at their edges and vertices and counts those that get out: there must be none.
//!
//! `cargo run --release -p mlt-benches --example watertight -- 100000000`; the number of rays may be left out (a million).
//! Every ray is asked for its nearest hit and for any hit, on all cores; the same rays on any number of them. As a control, a
//! mesh without one of its triangles has to leak.

use glam::Vec3;
use mlt_benches::stage::{blob, cuboid};
use mlt_core::transport::accel::Accel;
use mlt_core::transport::geometry::Ray;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use std::process::ExitCode;

/// (scale, offset) of the meshes, which are of size 1 about the origin.
const PLACES: [(f32, f32); 5] = [(1e-4, 0.0), (1.0, 0.0), (1e5, 0.0), (1.0, 1e5), (1e5, 1e5)];
/// Rays from one random stream.
const CHUNK: u64 = 100_000;

/// A closed mesh somewhere.
struct Closed {
    triangles: Vec<[Vec3; 3]>,
    scale: f32,
    offset: f32,
}

impl Closed {
    fn new(mesh: &[[Vec3; 3]], (scale, offset): (f32, f32)) -> Self {
        let placed = mesh.iter().map(|t| t.map(|v| place(v, scale, offset))).collect();
        Self { triangles: placed, scale, offset }
    }

    /// From near the centre to a vertex or to a point of an edge.
    fn ray(&self, rng: &mut Pcg32) -> Ray {
        let [a, b, _] = self.triangles[rng.next_u32() as usize % self.triangles.len()];
        let target = if uniform(rng) < 0.5 { a } else { a.lerp(b, uniform(rng)) };
        let near_centre = Vec3::from_array([0; 3].map(|_| 0.2 * uniform(rng) - 0.1));
        let origin = place(near_centre, self.scale, self.offset);
        Ray::new(origin, target - origin)
    }

    /// Queries, of two a ray, that find nothing.
    fn leaks(&self, rays: u64) -> u64 {
        let accel = Accel::new(&self.triangles);
        let chunk = |chunk: u64| {
            let mut rng = Pcg32::seed_from_u64(chunk);
            let rays = CHUNK.min(rays - chunk * CHUNK);
            let leaks = |_| {
                let ray = self.ray(&mut rng);
                u64::from(accel.closest(&ray).is_none()) + u64::from(!accel.occluded(&ray))
            };
            (0..rays).map(leaks).sum::<u64>()
        };
        (0..rays.div_ceil(CHUNK)).into_par_iter().map(chunk).sum()
    }
}

fn place(v: Vec3, scale: f32, offset: f32) -> Vec3 {
    scale * v + Vec3::new(offset, -offset, offset)
}

fn uniform(rng: &mut Pcg32) -> f32 {
    (rng.next_u32() >> 8) as f32 / 16_777_216.0
}

fn main() -> ExitCode {
    let asked = std::env::args().nth(1).map_or(Ok(1_000_000), |text| text.parse::<u64>());
    let Ok(total) = asked else {
        eprintln!("the number of rays must be a whole number");
        return ExitCode::from(2);
    };
    let meshes = [
        ("box, 12 triangles", cuboid(Vec3::ZERO, Vec3::ONE, 0.3)),
        ("blob, 6,400 triangles", blob(40, Vec3::ZERO, 1.0)),
        ("blob, 160,000 triangles", blob(200, Vec3::ZERO, 1.0)),
    ];
    let rays = total.div_ceil((meshes.len() * PLACES.len()) as u64);
    let mut leaks = 0;
    for (name, mesh) in &meshes {
        for place in PLACES {
            let found = Closed::new(mesh, place).leaks(rays);
            println!("{name:24} scale {:e}, offset {:e}: {found} leaks of {rays} rays", place.0, place.1);
            leaks += found;
        }
    }
    let open = blob(40, Vec3::ZERO, 1.0).split_off(1);
    let control = Closed::new(&open, PLACES[1]).leaks(CHUNK);
    println!("control, one triangle left out: {control} leaks of {CHUNK} rays");
    println!("{leaks} leaks of {} rays", rays * (meshes.len() * PLACES.len()) as u64);
    ExitCode::from(u8::from(leaks > 0 || control == 0))
}
