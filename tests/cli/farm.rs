//! Renders in parts on farms: their jobs and tasks.

use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

use serde_json::Value;
use tempfile::TempDir;

use crate::frames::with_animation;
use crate::resume::{command, folder, held, made, refused, run, same};

const RENDER: &str =
    "cornell --size 16x16 --threads 1 --quiet --method mlt --strata 2x2 --mutations-per-pixel 200 --rounds 40";

fn task(shard: &str) -> String {
    format!("farm task --parts parts --shard {shard} -- {RENDER}")
}

fn bytes(folder: &TempDir, name: &str) -> Vec<u8> {
    fs::read(folder.path().join(name)).expect("there")
}

/// Runs a shell script in a folder, with the program of this build and the folder's own on the PATH.
fn shell(folder: &TempDir, script: &str) {
    let program = Path::new(env!("CARGO_BIN_EXE_mlt")).parent().expect("a folder");
    let path = [folder.path(), program].map(|path| path.display().to_string()).join(":");
    let path = format!("{path}:{}", std::env::var("PATH").expect("set"));
    let status = Command::new("sh").args(["-c", script]).current_dir(folder.path()).env("PATH", path).status();
    assert!(status.expect("sh starts").success(), "{script}");
}

#[test]
fn a_task_that_is_done_does_nothing() {
    let folder = folder();
    made(&folder, &task("2/4"));
    let part = bytes(&folder, "parts/part-2.mltp");
    let again = command(folder.path(), &task("2/4")).stdout(Stdio::piped()).output().expect("mlt starts");
    assert_eq!(String::from_utf8_lossy(&again.stdout), "parts/part-2.mltp is there and whole\n");
    assert!(bytes(&folder, "parts/part-2.mltp") == part && !folder.path().join("parts/checkpoint-2.mltp").exists());
    // The control: without its part, it makes one, which differs in the time alone.
    fs::remove_file(folder.path().join("parts/part-2.mltp")).expect("removed");
    made(&folder, &task("2/4"));
    assert!(bytes(&folder, "parts/part-2.mltp") != part);
    // Another render's part is refused, and a damaged one is made again.
    let message = refused(&folder, &format!("{} --seed 3", task("2/4")));
    assert!(message.contains("parts/part-2.mltp: seed is 0 in it and 3 here"), "{message}");
    fs::write(folder.path().join("parts/part-2.mltp"), &part[..part.len() - 1]).expect("written");
    let warned = run(&folder, &task("2/4"));
    let message = String::from_utf8_lossy(&warned.stderr).into_owned();
    assert!(
        warned.status.success() && message.contains("damaged or cut off") && message.contains("made again"),
        "{message}"
    );
    assert_eq!(held(&folder, "parts/part-2.mltp").sums.rounds().to_string(), "10 to 19");
}

#[test]
fn copies_of_a_task_and_killed_ones_do_no_harm() {
    let folder = folder();
    made(&folder, &format!("render {RENDER} -o whole.exr"));
    for shard in ["1/2", "2/2"] {
        let line = format!("{} --checkpoint-every 1ms", task(shard));
        let start = || command(folder.path(), &line).stderr(Stdio::null()).spawn().expect("mlt starts");
        for wait in [20, 60] {
            let mut killed = start();
            sleep(Duration::from_millis(wait));
            killed.kill().expect("killed");
            killed.wait().expect("ended");
        }
        let copies = [start(), start(), start()];
        copies.into_iter().for_each(|mut copy| assert!(copy.wait().expect("ended").success(), "{shard}"));
    }
    made(&folder, "merge parts/part-2.mltp parts/part-1.mltp -o merged.exr -q");
    assert!(same(&folder, "whole.exr", "merged.exr"));
}

/// Words that a shell or a scheduler would take for something else.
const HOSTILE: &str = "it's {{Task.Param.Number}} $(touch harm) `touch harm` %a \"x\";touch harm # *";

/// A copy of a scene under a hostile name, the job of its render, and the same render in one.
fn job(folder: &TempDir, scheduler: &str) -> String {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mlt-scene/scenes/cornell");
    for (from, to) in [("cornell.bin", "cornell.bin"), ("cornell.gltf", &format!("{HOSTILE}.gltf"))] {
        fs::copy(scenes.join(from), folder.path().join(to)).expect("copied");
    }
    let words = ["--shards", "3", "--parts", &format!("parts {HOSTILE}"), "--"].map(str::to_owned);
    let mut job = command(folder.path(), &format!("farm {scheduler}"));
    job.args(words).arg(format!("{HOSTILE}.gltf")).args(VIEW.split(' ')).args(["-o", &format!("{HOSTILE}.exr")]);
    let output = job.stdout(Stdio::piped()).output().expect("mlt starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut whole = command(folder.path(), "render -o whole.exr");
    assert!(whole.arg(format!("{HOSTILE}.gltf")).args(VIEW.split(' ')).status().expect("mlt starts").success());
    String::from_utf8(output.stdout).expect("text")
}

const VIEW: &str = "--camera-from 2.78,2.73,-8 --camera-to 2.78,2.73,0 --size 8x8 --samples-per-pixel 4 --method pt --rounds 4 --threads 1 -q";

fn no_harm(folder: &TempDir) {
    assert!(same(folder, "whole.exr", &format!("{HOSTILE}.exr")));
    assert!(!folder.path().join("harm").exists());
}

/// A stand-in for sbatch that runs what it is given at once: here the question is what is submitted. tests/farms has Slurm itself.
const SBATCH: &str = r#"#!/bin/sh
cat > job.sh
last=
for word in "$@"; do case $word in --array=*) array=${word#--array=} first=${array%-*} last=${array#*-};; esac; done
if [ -n "$last" ]; then
    for i in $(seq "$first" "$last"); do SLURM_ARRAY_TASK_ID=$i sh job.sh >&2 || exit 1; done
    echo 7
else
    case "$*" in *--dependency=afterok:7\ *) sh job.sh >&2 && echo 8;; *) exit 1;; esac
fi
"#;

/// Submits a job to the stand-in, which has to say this.
#[cfg(unix)]
fn submit(folder: &TempDir, script: &str, said: &str) {
    use std::os::unix::fs::PermissionsExt;
    fs::write(folder.path().join("sbatch"), SBATCH).expect("written");
    fs::set_permissions(folder.path().join("sbatch"), fs::Permissions::from_mode(0o755)).expect("set");
    fs::write(folder.path().join("submit.sh"), script).expect("written");
    shell(folder, &format!("test \"$(sh submit.sh)\" = '{said}'"));
}

#[test]
fn a_job_of_more_parts_than_rounds_makes_a_round_for_each() {
    let folder = folder();
    let script = |line: &str| {
        let output = command(folder.path(), &format!("farm slurm {line}")).stdout(Stdio::piped()).output();
        String::from_utf8(output.expect("mlt starts").stdout).expect("text")
    };
    let job = script("--shards 100 -- cornell --samples-per-pixel 1024");
    assert!(job.contains("cornell --samples-per-pixel 1024 --rounds=100"), "{job}");
    let job = script("--shards 4 -- cornell --samples-per-pixel 1024");
    assert!(job.contains("1024") && !job.contains("--rounds"), "{job}");
}

#[cfg(unix)]
#[test]
fn a_slurm_job_renders_the_bits_of_one_machine() {
    let folder = folder();
    let script = job(&folder, "slurm");
    submit(&folder, &script, "parts: job 7; merge: job 8");
    no_harm(&folder);
}

/// Frames are tasks: those of an array, and those of a template.
#[cfg(unix)]
#[test]
fn frames_of_a_farm_have_the_bits_of_one_machine() {
    let folder = folder();
    with_animation(folder.path(), 0, 1.0);
    let frames = "room.gltf --size 16x12 --method mlt --mutations-per-pixel 64 --threads 1 -q --frames 2-3 --fps 4 --frame-seeds own";
    made(&folder, &format!("render {frames} -o whole.#.exr"));
    let job = |scheduler: &str| {
        let line = format!("farm {scheduler} -- {frames} --aov depth -o {scheduler}.##.exr");
        let output = command(folder.path(), &line).stdout(Stdio::piped()).output().expect("mlt starts");
        String::from_utf8(output.stdout).expect("text")
    };
    submit(&folder, &job("slurm"), "frames: job 7");
    let template: Value = serde_json::from_str(&job("openjd")).expect("JSON");
    let [step] = &template["steps"].as_array().expect("steps")[..] else { panic!("{template}") };
    assert_eq!(step["parameterSpace"]["taskParameterDefinitions"][0]["range"], "2-3");
    let task = step["script"]["embeddedFiles"][0]["data"].as_str().expect("text");
    [2, 3].iter().for_each(|i| shell(&folder, &task.replace("{{Task.Param.Number}}", &i.to_string())));
    for (whole, frame) in [("whole.2.exr", "02"), ("whole.3.exr", "03")] {
        ["slurm", "openjd"].iter().for_each(|name| assert!(same(&folder, whole, &format!("{name}.{frame}.exr"))));
    }
    assert!(!same(&folder, "whole.2.exr", "slurm.03.exr"), "nothing moves");
}

/// A frame's sums are kept: its images are made from them again, and those of another render are refused.
#[test]
fn a_frame_that_is_done_is_not_rendered_again() {
    let folder = folder();
    let task = "farm task --parts frames --frame 1 -- cornell --size 16x16 --threads 1 --method pt --samples-per-pixel 16 --frames 1-2 -o f.#.exr";
    made(&folder, task);
    let sums = held(&folder, "frames/frame-1.mltp").sums.to_bytes();
    fs::rename(folder.path().join("f.1.exr"), folder.path().join("first.exr")).expect("renamed");
    made(&folder, task);
    assert!(same(&folder, "first.exr", "f.1.exr") && held(&folder, "frames/frame-1.mltp").sums.to_bytes() == sums);
    let message = refused(&folder, &format!("{task} --seed 3"));
    assert!(message.contains("frames/frame-1.mltp: seed is 0 in it and 3 here"), "{message}");
}

#[cfg(unix)]
#[test]
fn an_open_job_description_renders_the_bits_of_one_machine() {
    let folder = folder();
    let template: Value = serde_json::from_str(&job(&folder, "openjd")).expect("JSON");
    let data =
        |step: usize| template["steps"][step]["script"]["embeddedFiles"][0]["data"].as_str().expect("text").to_owned();
    let (parts, merge) = (data(0), data(1));
    // The parameter is the only reference.
    assert_eq!((parts.matches("{{").count(), merge.matches("{{").count()), (1, 0), "{parts}");
    (1..=3).for_each(|i| shell(&folder, &parts.replace("{{Task.Param.Number}}", &i.to_string())));
    shell(&folder, &merge);
    no_harm(&folder);
}

#[test]
fn a_job_that_cannot_run_is_refused_before_it_is_submitted() {
    let folder = folder();
    for (line, part) in [
        ("farm slurm --shards 5 -- cornell --method pt --samples-per-pixel 4 --rounds 4", "there are only 4 rounds"),
        ("farm slurm --shards 4 -- cornell --time 1h", "--time"),
        ("farm slurm --shards 4 -- cornell --sise 1x1", "unexpected argument '--sise'"),
        ("farm openjd --shards 4 -- cornell --shard 1/2", "--shard"),
        ("farm openjd --shards 4 -- cornell --checkpoint a.mltp", "name their .mltp files themselves"),
        ("farm openjd --shards 4 -- cornell -o a.mltp", "name their .mltp files themselves"),
        ("farm openjd --shards 4 -- cornell -o none/a.exr", "the folder none does not exist"),
        ("farm slurm --shards 0 -- cornell", "--shards"),
        ("farm slurm -- cornell", "--shards"),
        ("farm slurm --shards 4 -- cornell --frames 1-3 -o a.#.exr", "makes a task of each frame"),
        ("farm slurm -- cornell --frames 1-3 -o a.exr", "a file of its own"),
        ("farm openjd -- cornell --frames 1-3 --time 1m", "--samples-per-pixel"),
        ("farm task --frame 4 -- cornell --frames 1-3", "none of the render's --frames"),
        ("farm task -- cornell", "--shard"),
        ("farm slurm --shards 4 cornell", "unexpected argument"),
        ("farm slurm --shards 4 -- --help", "not options of a farm's render"),
        ("farm task --shard 5/4 -- cornell", "as in 1/4 to 4/4"),
    ] {
        let message = refused(&folder, line);
        assert!(message.contains(part), "{line}: {message}");
    }
    let refused = command(folder.path(), "farm slurm --shards 4 --").arg("a\nb.glb").output().expect("mlt starts");
    assert!(String::from_utf8_lossy(&refused.stderr).contains("a job cannot hold this name"));
}
