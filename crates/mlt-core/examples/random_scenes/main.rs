//! Random rooms, each rendered by every method: they have to agree, on any number of threads.
//!
//!     cargo run --release -p mlt-core --example random_scenes -- FIRST COUNT
//!     cargo run --release -p mlt-core --example random_scenes -- ROOM         # describes one, and shows what each method sees
//!     cargo run --release -p mlt-core --example random_scenes -- seeds FIRST COUNT   # the default method's errors over seeds
//!
//! Rooms have numbers, which decide all of them. Images of 8×8 pixels are compared by the means of the whole and of its quarters, channel
//! by channel. Where two methods differ by more than 5 standard errors both are rendered anew with eight times the samples, and so on up to
//! 32768 times; those that then still differ as much are reported. So is what is negative or not finite, a sign of a wrong
//! image in the counts, a panic, and an image of other bits on two threads. A report ends the study with an error.
//!
//! At the end stands, for each method, the mean over all rooms of its difference from bidirectional path tracing: of faults that are too
//! small to show in one room.

mod contest;
mod dice;
mod rooms;
mod seeds;
mod shapes;
mod surfaces;

use contest::{Contest, Outcome};
use std::{env, ops::Range, panic, process::ExitCode, time::Instant};

/// How many times the samples a room that is shown gets.
const SHOWN: f64 = 64.0;
/// Rooms between two lines of progress.
const PROGRESS: u64 = 1000;

fn main() -> ExitCode {
    let numbers: Vec<u64> = env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let seeds = env::args().nth(1).is_some_and(|word| word == "seeds");
    match numbers[..] {
        [first, count] if seeds => seeds::study(first..first + count),
        [room] if !seeds => Contest::new().show(room, SHOWN),
        [first, count] if study(first..first + count) > 0 => return ExitCode::FAILURE,
        [_, _] => {}
        _ => {
            eprintln!("usage: random_scenes FIRST COUNT, random_scenes ROOM, or random_scenes seeds FIRST COUNT");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

/// Renders rooms, prints their faults, and returns the number of rooms that have one.
fn study(numbers: Range<u64>) -> u64 {
    let (start, mut contest) = (Instant::now(), Contest::new());
    let (mut refused, mut faulty) = (0, 0);
    for number in numbers.clone() {
        let outcome = panic::catch_unwind(panic::AssertUnwindSafe(|| contest.hold(number)));
        match outcome.unwrap_or_else(|_| Outcome::Faults(vec!["a panic".into()])) {
            Outcome::Agreement => {}
            Outcome::Refused => refused += 1,
            Outcome::Faults(faults) => {
                faulty += 1;
                faults.iter().for_each(|fault| println!("room {number}: {fault}"));
            }
        }
        let done = number + 1 - numbers.start;
        if done.is_multiple_of(PROGRESS) {
            println!("{done} rooms, {faulty} with faults, {refused} without light, {:.0?}", start.elapsed());
        }
    }
    println!("{contest}");
    println!("{} rooms, {faulty} with faults, {refused} without light", numbers.end - numbers.start);
    faulty
}

#[test]
fn random_rooms_have_no_faults() {
    assert_eq!(study(0..12), 0);
}
