//! A merge of many parts.

use std::{env, fs, ops::ControlFlow, path::Path, process::Command, time::Instant};

use mlt_cli::kept::{self, Kept};
use mlt_core::transport::{
    render::{Method, Renderer, Settings},
    scene::{Scene, View},
};

use crate::resume::{folder, held, made};

/// Parts; the variable MLT_PARTS asks for more of them, for a study.
const PARTS: u64 = 100;

/// Writes parts of one round each, as processes of their own would.
fn write_parts(folder: &Path, count: u64, Kept { about, pilot, sums: first, .. }: &Kept) {
    let loaded = mlt_scene::open("cornell").expect("built in");
    let pose = loaded.description.cameras[0].clone();
    let scene = Scene::new(loaded.description).expect("a scene");
    let camera = scene.camera(&pose, first.film().size());
    let renderer = Renderer::new(View { scene: &scene, camera: &camera }, Settings::new(Method::Path, 1.0));
    let mut sums = renderer.sums().with_key(first.key().clone());
    for round in 0..count {
        sums.clear();
        renderer.render(round..round + 1, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        let bytes = kept::encode(about, pilot.as_deref(), &sums).expect("encoded");
        fs::write(folder.join(format!("part-{round:07}.mltp")), bytes).expect("written");
    }
}

/// Merges the parts below a number, and tells seconds and, where the system's `time` is, the peak of memory in MB.
fn merge(folder: &Path, count: u64) -> (f64, Option<f64>) {
    let (time, start) = (Path::new("/usr/bin/time"), Instant::now());
    let program = env!("CARGO_BIN_EXE_mlt");
    let mut command = if time.exists() { Command::new(time) } else { Command::new(program) };
    if time.exists() {
        command.args(["-f", "%M", program]);
    }
    let parts = (0..count).map(|round| format!("part-{round:07}.mltp"));
    let output = command.current_dir(folder).arg("merge").args(parts).args(["-o", "sum.mltp", "-q"]).output();
    let output = output.expect("mlt starts");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{text}");
    let peak = text.lines().last().and_then(|line| line.parse::<f64>().ok()).map(|kilobytes| kilobytes / 1000.0);
    (start.elapsed().as_secs_f64(), peak)
}

#[test]
fn many_parts_are_merged_in_flat_memory() {
    let count = env::var("MLT_PARTS").ok().and_then(|count| count.parse().ok()).unwrap_or(PARTS).max(2);
    let folder = folder();
    let render =
        format!("render cornell --size 32x32 --method pt --samples-per-pixel {count} --rounds {count} --threads 1 -q");
    made(&folder, &format!("{render} -o whole.mltp"));
    let whole = held(&folder, "whole.mltp");
    write_parts(folder.path(), count, &whole);
    let few = merge(folder.path(), count / 2);
    let all = merge(folder.path(), count);
    assert!(held(&folder, "sum.mltp").sums.to_bytes() == whole.sums.to_bytes());
    println!("{} parts: {few:?} s and MB; {count} parts: {all:?}", count / 2);
    if let (Some(few), Some(all)) = (few.1, all.1) {
        // The contribution of each round to blocks of the image, 7 KB with its name, is kept of up to 4096 rounds.
        let more = (count.min(4096) - (count / 2).min(4096)) as f64;
        assert!(all - few < 0.007 * more + 1.0, "{few} MB and {all} MB");
    }
}
