//! Renders that are killed at random moments, again and again: the bits of one that was let alone.

use std::{env, fs, process::Stdio, thread::sleep, time::Duration};

use rand_pcg::{
    Pcg64Mcg,
    rand_core::{Rng, SeedableRng},
};

use crate::resume::{METHODS, SCENE, command, folder, held, made};

/// Kills in all; the variable MLT_KILLS asks for more of them, for a study.
const KILLS: usize = 102;
/// Longest life of a process that is killed, ms, at first; longer where no process comes to its first checkpoint.
const LONGEST: u32 = 60;

#[test]
fn kills_at_random_moments_change_no_bit() {
    let kills = env::var("MLT_KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(KILLS) / METHODS.len();
    let (mut ends, mut checkpoints) = (0, 0);
    for (seed, method) in METHODS.iter().enumerate() {
        let (folder, line, mut rng) =
            (folder(), format!("{SCENE} {method} --rounds 50"), Pcg64Mcg::seed_from_u64(seed as u64));
        made(&folder, &format!("{line} -o whole.mltp"));
        let whole = held(&folder, "whole.mltp").sums.to_bytes();
        let kept = folder.path().join("kept.mltp");
        let (mut killed, mut finished, mut longest) = (0, 0, LONGEST);
        while killed < kills || finished == 0 {
            let keep = if kept.exists() { "--resume" } else { "--checkpoint" };
            let mut life = command(folder.path(), &format!("{line} {keep} kept.mltp --checkpoint-every 1ms -o a.mltp"));
            let mut life = life.stderr(Stdio::null()).spawn().expect("mlt starts");
            if killed < kills {
                sleep(Duration::from_millis((rng.next_u32() % longest).into()));
                life.kill().expect("killed");
            }
            if life.wait().expect("ended").success() {
                assert!(held(&folder, "a.mltp").sums.to_bytes() == whole, "{method}: after {killed} kills");
                finished += 1;
                fs::remove_file(&kept).expect("removed");
            } else {
                killed += 1;
                // Whatever was written is whole.
                match kept.exists() && held(&folder, "kept.mltp").sums.rounds().count() > 0 {
                    true => checkpoints += 1,
                    false => longest += LONGEST / 3,
                }
            }
        }
        ends += finished;
    }
    assert!(checkpoints > 0, "no process lived long enough");
    println!(
        "{} kills, {checkpoints} of them behind a checkpoint; {ends} renders came to their end, all alike",
        kills * METHODS.len()
    );
}
