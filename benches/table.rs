//! The figures of docs/performance.md in one go, as Markdown: rays, builds, methods, threads, start-up.
//!
//! `cargo build --release && cargo bench -p mlt-benches --bench table`, a few minutes; name sections to leave out the others,
//! `… -- rays build methods start`. What is compared takes turns in short slices; figures are medians over them.

use mlt_benches::Loaded;
use mlt_benches::contest::{Time, median, median_ratio, take_turns};
use mlt_benches::embree::{Embree, EmbreeScene};
use mlt_benches::rays::{Kind, compare, geometric_mean};
use mlt_benches::stage::Stage;
use mlt_benches::tracer::Tracer;
use mlt_core::transport::accel::Accel;
use mlt_core::transport::render::{Counts, Method, Renderer};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::fmt::Write as _;
use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with('-')).collect();
    let sections: [(&str, fn()); 4] = [("rays", rays), ("build", build), ("methods", methods), ("start", start)];
    for (_, section) in sections.iter().filter(|(name, _)| wanted.is_empty() || wanted.iter().any(|w| w == name)) {
        section();
    }
}

fn threads(number: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(number).build().expect("threads")
}

/// Rays per CPU-second by scene and kind, and over Embree's.
fn rays() {
    let embree = Embree::load();
    let name = embree.map_or_else(|| "Embree (absent)".into(), Embree::name);
    println!("\n| scene | triangles | rays | ours, M/s | ÷ {name} robust | ÷ {name} fast |\n|---|---|---|---|---|---|");
    let mut ratios = [Vec::new(), Vec::new()];
    for stage in Stage::all().map(|stage| stage()) {
        let ours = Accel::new(&stage.triangles);
        let scene = |robust| embree.map(|embree| EmbreeScene::new(embree, &stage.triangles, robust));
        let others: Vec<_> = [true, false].into_iter().filter_map(scene).collect();
        let tracers: Vec<_> = others.iter().map(|scene| scene as &dyn Tracer).collect();
        for kind in Kind::ALL {
            let cell = compare(kind, &kind.rays(&stage, &ours), &ours, &tracers);
            let mut row = format!("| {} | {} | {} ", stage.name, stage.triangles.len(), kind.name());
            _ = write!(row, "| {:.2} |", cell.rate / 1e6);
            cell.ratios.iter().for_each(|ratio| _ = write!(row, " {ratio:.2} |"));
            println!("{row}{}", " – |".repeat(2 - cell.ratios.len()));
            ratios.iter_mut().zip(&cell.ratios).for_each(|(of, &ratio)| of.push(ratio));
        }
    }
    for (mode, ratios) in ["robust", "fast"].into_iter().zip(&ratios).filter(|(_, ratios)| !ratios.is_empty()) {
        let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        println!("\n{name} {mode}: geometric mean {:.2}, least {least:.2}.", geometric_mean(ratios));
    }
}

/// Seconds to build the acceleration structure of a million triangles.
fn build() {
    let triangles = Stage::million().triangles;
    let pools = [threads(1), threads(2)];
    let times = take_turns(2, 5, |i| drop(pools[i].install(|| Accel::new(&triangles))));
    println!("\n| build, {} triangles | seconds |\n|---|---|", triangles.len());
    for (label, times) in ["1 thread", "2 threads"].into_iter().zip(&times) {
        println!("| {label} | {:.2} |", median(times.iter().map(|time| time.wall)));
    }
}

/// Methods, their samples or mutations per pixel in a round, and rounds of a slice: enough for two threads to share.
const METHODS: [(&str, Method, f64, u64); 4] = [
    ("pt, samples", Method::Path, 8.0, 2),
    ("bdpt, samples", Method::Bidirectional, 4.0, 2),
    ("mlt, mutations", Method::Metropolis, 4.0, 16),
    ("mmlt, mutations", Method::Multiplexed, 2.0, 16),
];

/// Samples or mutations per CPU-second on the Cornell box, and over the rays per CPU-second of the bare accelerator.
fn methods() {
    let loaded = Loaded::builtin("cornell", [256, 256]);
    let renderers = METHODS.map(|(_, method, per_pixel, _)| {
        Renderer::new(loaded.view(), loaded.settings(method, per_pixel).with(|s| s.max_edges = Some(6)))
    });
    let render = |k: usize| {
        let renderer = &renderers[k];
        let mut sums = renderer.sums();
        renderer.render(0..METHODS[k].3, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        sums.into_parts().1
    };
    let stage = Stage::all()[0]();
    let accel = Accel::new(&stage.triangles);
    let bare_rays = Kind::Bounced.rays(&stage, &accel);
    let pools = [threads(1), threads(2)];
    let mut counts = vec![Counts::default(); METHODS.len()];
    let times = take_turns(1 + 2 * METHODS.len(), 5, |i| match i.checked_sub(1) {
        None => (0..20).for_each(|_| _ = std::hint::black_box(accel.count_nearest(&bare_rays))),
        Some(k) => counts[k / 2] = pools[k % 2].install(|| render(k / 2)),
    });
    let rate = |amount: f64, times: &[Time]| amount / median(times.iter().map(|time| time.cpu));
    let bare = 20.0 * bare_rays.len() as f64;
    println!("\nBare accelerator: {:.2} M bounced rays per CPU-second.", rate(bare, &times[0]) / 1e6);
    println!(
        "\n| cornell, 1 thread | M per CPU-second | ÷ bare rays | rays, M/s | ÷ bare rays | 2 threads ÷ 1 | processors they got |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (k, (label, ..)) in METHODS.iter().enumerate() {
        let (one, two, counts) = (&times[1 + 2 * k], &times[2 + 2 * k], &counts[k]);
        let (work, rays) = ((counts.samples() + counts.steps()) as f64, counts.rays() as f64);
        let over_bare = median_ratio(&times[0], one, |time| time.cpu) / bare;
        let scaling = median_ratio(one, two, |time| time.wall);
        let got = median(two.iter().map(|time| time.cpu / time.wall));
        let [work_rate, rays_rate] = [work, rays].map(|amount| rate(amount, one) / 1e6);
        let [work_ratio, rays_ratio] = [work, rays].map(|amount| amount * over_bare);
        print!("| {label} | {work_rate:.2} | {work_ratio:.3} | {rays_rate:.2} | {rays_ratio:.2} ");
        println!("| {scaling:.2} | {got:.2} |");
    }
}

/// Seconds from starting the program to an image of one sample a pixel.
fn start() {
    let Some(program) = program() else {
        eprintln!("START-UP SKIPPED: the program mlt is not beside this one; `cargo build --release` makes it.");
        return;
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let million = folder.path().join("million.gltf");
    write_gltf(&Stage::million(), &million).expect("room for 50 MB in the temporary folder");
    println!("\n| program, first image written | seconds |\n|---|---|");
    let scenes: [(&str, &Path, usize); 2] =
        [("cornell", Path::new("cornell"), 21), ("million triangles from glTF", &million, 5)];
    for (label, scene, slices) in scenes {
        let times = take_turns(1, slices, |_| first_image(&program, scene, folder.path()));
        println!("| {label} | {:.3} |", median(times[0].iter().map(|time| time.wall)));
    }
}

/// The program, which cargo puts beside the folder of benchmarks.
fn program() -> Option<PathBuf> {
    let here = std::env::current_exe().ok()?;
    let program = here.parent()?.parent()?.join(format!("mlt{}", std::env::consts::EXE_SUFFIX));
    program.exists().then_some(program)
}

fn first_image(program: &Path, scene: &Path, folder: &Path) {
    let options = "--size 16x16 --method pt --samples-per-pixel 1 --rounds 1 --quiet --output";
    let mut command = Command::new(program);
    command.arg("render").arg(scene).args(options.split(' ')).arg(folder.join("first.exr"));
    let status = command.stderr(Stdio::null()).status().expect("the program starts");
    assert!(status.success(), "{} failed", program.display());
}

/// Writes a stage as glTF, each triangle with corners of its own and one flat material, with its lamp.
fn write_gltf(stage: &Stage, path: &Path) -> io::Result<()> {
    let [triangles, lamp] = [&stage.triangles, &stage.lamp].map(|list| 3 * list.len());
    let corners = stage.triangles.iter().chain(&stage.lamp).flatten();
    let bytes: Vec<u8> = corners.flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes).collect();
    std::fs::write(path.with_extension("bin"), &bytes)?;
    let accessor = |view: usize, count: usize| {
        format!(
            r#"{{"bufferView":{view},"componentType":5126,"count":{count},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}}"#
        )
    };
    let view = |start: usize, count: usize| {
        format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, 12 * start, 12 * count)
    };
    let mesh =
        |index: usize| format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{index}}},"material":{index}}}]}}"#);
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,2]}}],
"nodes":[{{"mesh":0}},{{"mesh":1}},{{"camera":0,"translation":[0,0,0.95]}}],
"cameras":[{{"type":"perspective","perspective":{{"aspectRatio":1,"yfov":1.2,"znear":0.01}}}}],
"materials":[{{}},{{"emissiveFactor":[1,1,1],"doubleSided":true}}],"meshes":[{},{}],
"accessors":[{},{}],"bufferViews":[{},{}],"buffers":[{{"byteLength":{},"uri":"{}"}}]}}"#,
        mesh(0),
        mesh(1),
        accessor(0, triangles),
        accessor(1, lamp),
        view(0, triangles),
        view(triangles, lamp),
        bytes.len(),
        path.with_extension("bin").file_name().unwrap_or_default().display(),
    );
    std::fs::write(path, text)
}
