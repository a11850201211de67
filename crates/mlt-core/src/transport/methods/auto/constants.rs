//! The numbers that the pilot is made with, and where each comes from.
//!
//! Sections and equations are those of docs/theory-auto.md. A number that is *chosen* was not fitted to anything: it bounds a cost or
//! rounds a law off, and the image is unbiased whatever it is.

use crate::engine::PILOT;

/// Time of a ray of chains, with all that comes with it, over that in path tracing; measured on the built-in scenes.
pub const TIME_OF_A_CHAINS_RAY: f64 = 1.2;

/// Pixels of the image for each of the pilot's, but no fewer than [`USUAL_PIXELS`]; chosen, section 2.
pub(super) const REDUCTION: f64 = 16.0;
/// Pixels of the pilot's image, unless that takes too long; chosen, section 2.
pub(super) const USUAL_PIXELS: f64 = 4096.0;
/// Fewest and most of them; chosen.
pub(super) const PIXELS: [f64; 2] = [256.0, 16_384.0];
/// Time of the pilot over that of a round, at most; chosen, section 2.
pub(super) const ROUNDS_OF_TIME: f64 = 1.5;
/// Time of the pilot's chains for one of its pixels, in samples of path tracing, about; measured on the built-in scenes.
pub(super) const TIME_OF_CHAINS: f64 = 30.0;

/// Shares of the pilot's time at which its steps begin, about: levels, path tracing, chains, and what these tell; chosen.
pub(super) const STEPS: [f64; 5] = [0.0, 0.1, 0.3, 0.7, 1.0];

/// Bidirectional samples of each pixel for the levels, in two halves; chosen, section 1.
pub(super) const LEVEL_SAMPLES: u64 = 4;
/// Radius of the squares that they are averaged over, as a share of the image's longer side; chosen, section 1.
pub(super) const LEVEL_RADIUS: f64 = 1.0 / 16.0;
/// Least level, as a share of the image's mean; chosen, section 1.
pub(super) const LEVEL_FLOOR: f64 = 1.0;
/// c over the level of a pixel; measured, section 1.
pub(super) const HALF_OF_LEVEL: f64 = 4.0;
/// Points of one sequence for which two sequences a pixel, whose spread is the noise, are enough; shorter ones are four. Chosen.
pub(super) const LONG_SEQUENCE: u64 = 4;

/// Mutations a pixel and round of the pilot; chosen.
pub(super) const MUTATIONS: f64 = 8.0;
/// Mutations for each independent sample of the pilot; chosen.
pub(super) const PILOT_MUTATIONS_PER_SAMPLE: u64 = 8;
/// Camera subpaths for each pixel and round of the pilot, for what is met by chance; chosen.
pub(super) const PILOT_WALKS: u64 = 2;
/// The same for a render, as a share of its chains' work: such light is met once in many renders. docs/log/auto.md.
pub(super) const WALKS: f64 = 0.25;
/// Most of these in a round, or the image's pixels if there are more; bounds memory.
pub(super) const MOST_WALKS: u64 = 1 << 22;
/// Rounds of the pilot's chains; chosen.
pub(super) const ROUNDS: u64 = 4;
/// Number of the first round of the pilot's chains: far from all others.
pub(super) const CHAIN_PILOT: u64 = PILOT + (1 << 40);

/// Chains in each stratum that tell the tail; section 2.
pub(super) const TOLD_CHAINS: u64 = 16;

/// Least share of the power of a part of the lights that is asked for; chosen.
pub(super) const LEAST_SHARE: f64 = 1.0 / 16.0;
/// Least share of a round's work for chains; chosen, section 3.
pub(super) const LEAST_CHAIN_WORK: f64 = 0.2;
/// Work of a round over what was asked for, at least and at most: numbers of samples are powers of two. Section 3.
pub(super) const WORK: [f64; 2] = [0.75, 1.25];
/// Error × work of both together over that of path tracing alone, at most: it is chosen by noisy figures. Section 3.
pub(super) const GAIN: f64 = 0.85;
/// The same where most of path tracing's error is what chains tell and samples hardly meet: their absence may cost far more than their
/// presence. Section 3.
pub(super) const DOUBT: f64 = 3.0;
/// Times that samples of a round have to meet that, so that nothing is in doubt; measured on random rooms, section 3.
pub(super) const FEW: f64 = 3.0;
/// Share of the light, lamps in view left out, from which on chains may take all of it; section 3.
pub(super) const MOSTLY_HARD: f64 = 0.5;
/// Numbers of branches that are tried; section 3.
pub(super) const BRANCHES: [u32; 4] = [1, 2, 4, 8];
/// Samples of each pixel in a round that are read from a file, at most, over those that were asked for; bounds memory.
pub(super) const MOST_SAMPLES: f64 = 256.0;
