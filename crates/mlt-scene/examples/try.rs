//! try
use mlt_core::{
    engine::*,
    transport::{bdpt::*, independent::*, mutate::*, path::*, pt::*, region::*, scene::*, strata::*, stratum::*, *},
};
use std::ops::ControlFlow;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let loaded = mlt_scene::open(&a[1]).unwrap();
    let pose = loaded.description.cameras[0].clone();
    let scene = Scene::new(loaded.description).unwrap();
    let n: u32 = 256;
    let camera = scene.camera(&pose, [n, n]);
    let view = View { scene: &scene, camera: &camera };
    let mut film = Film::<3>::new(n * n, scene.typical_radiance());
    let budget: f64 = a[3].parse().unwrap();
    let max: usize = a.get(5).map(|x| x.parse().unwrap()).unwrap_or(MOST_EDGES);
    let rounds = 8;
    let t = std::time::Instant::now();
    let region = LightRegion::whole(scene.lights());
    let spp = (budget / rounds as f64).max(1.0) as u64;
    match a[2].as_str() {
        "pt" => {
            let s = PathTracer { view, region: &region, max_edges: max };
            let mut tl = SampleTally::default();
            render(
                &Independent { sampler: &s, samples_per_pixel: spp, seed: 1 },
                0..rounds,
                &mut film,
                &mut tl,
                &mut |_, _, _| ControlFlow::Continue(()),
            );
            let dt = t.elapsed().as_secs_f64();
            println!(
                "{:?} {:.3}s {:.3}M samples/s {:.2}M rays/s",
                tl,
                dt,
                tl.samples as f64 / dt / 1e6,
                tl.rays as f64 / dt / 1e6
            );
        }
        "bdpt" => {
            let s = Bidirectional { view, region: &region, max_edges: max };
            let mut tl = SampleTally::default();
            render(
                &Independent { sampler: &s, samples_per_pixel: spp, seed: 1 },
                0..rounds,
                &mut film,
                &mut tl,
                &mut |_, _, _| ControlFlow::Continue(()),
            );
            let dt = t.elapsed().as_secs_f64();
            println!(
                "{:?} {:.3}s {:.3}M samples/s {:.2}M rays/s",
                tl,
                dt,
                tl.samples as f64 / dt / 1e6,
                tl.rays as f64 / dt / 1e6
            );
        }
        m => {
            let strat = if m == "mlt" {
                Stratification::None
            } else {
                let (x, y) = m.split_once('x').unwrap();
                Stratification::Grid(x.parse().unwrap(), y.parse().unwrap())
            };
            let strata = LightStrata::new(scene.lights(), strat);
            let strata = LightStratum::all(&strata, view, max);
            let total: f64 = strata.iter().map(|s| s.power()).sum();
            let per_round = budget / rounds as f64 * (n * n) as f64;
            let shares: Vec<_> = strata
                .iter()
                .map(|s| Share {
                    mutations: (per_round * s.power() / total) as u64,
                    samples: (per_round * s.power() / total / 32.0) as u64,
                })
                .collect();
            let mixture = Mixture::new(PathMutation::all(view));
            let est = Metropolis {
                strata: &strata,
                shares: &shares,
                mixture: &mixture,
                importance: &Luminance,
                seed: 1,
                work: rays_traced,
            };
            let mut tl = Tally::default();
            render(&est, 0..rounds, &mut film, &mut tl, &mut |_, _, _| ControlFlow::Continue(()));
            let dt = t.elapsed().as_secs_f64();
            let tot = tl.total();
            println!("{:.3}s {:.3}M mut/s {:.2}M rays/s", dt, tot.steps() as f64 / dt / 1e6, tl.work as f64 / dt / 1e6);
            for m in &tot.mutations {
                println!("{:?} acc {:.3}", m, m.acceptance());
            }
            println!("longest {} idle {}", tot.longest_rejection, tot.idle);
            println!("b = {}", tl.strata.iter().map(|s| s.b()).sum::<f64>());
        }
    }
    let lum = |p: &[Pixel; 3]| 0.2126 * p[0].mean + 0.7152 * p[1].mean + 0.0722 * p[2].mean;
    println!(
        "mean {} lost {}",
        (0..(n * n) as usize).map(|i| lum(&film.pixel(i))).sum::<f64>() / (n * n) as f64,
        film.lost()
    );
    let mut f = Vec::new();
    for i in 0..(n * n) as usize {
        for c in film.pixel(i) {
            f.push((c.mean.max(0.0).powf(1.0 / 2.2) * 255.0).min(255.0) as u8);
        }
    }
    let mut out = format!("P6 {n} {n} 255\n").into_bytes();
    out.extend(f);
    std::fs::write(&a[4], out).unwrap();
}
