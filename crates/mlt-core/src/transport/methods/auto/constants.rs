//! The numbers that the pilot is made with, and where each comes from.
//!
//! Sections and equations are those of docs/theory-auto.md. A number that is *chosen* was not fitted to anything: it bounds a cost or
//! rounds a law off, and the image is unbiased whatever it is.

use crate::engine::PILOT;

/// Time of a ray of chains, with all that comes with it, over that in path tracing; measured on the built-in scenes.
pub const TIME_OF_A_CHAINS_RAY: f64 = 1.2;
/// Time of a ray of a bidirectional sample, with all that comes with it, over that in path tracing; measured on the built-in scenes.
pub const TIME_OF_A_BIDIRECTIONAL_RAY: f64 = 1.2;

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
/// Samples of path tracing in the time of one of bidirectional path tracing, about; measured on the built-in scenes.
pub(super) const PATHS: f64 = 4.0;

/// Mutations a pixel and round of the pilot; chosen.
pub(super) const MUTATIONS: f64 = 8.0;
/// Mutations for each independent sample of the pilot; chosen.
pub(super) const MUTATIONS_PER_SAMPLE: u64 = 8;
/// Rounds of the pilot's chains; chosen, section 2, "Rounds".
pub(super) const ROUNDS: u64 = 4;
/// Most of them, where chains have a chance; chosen, section 2, "Rounds".
pub(super) const MOST_ROUNDS: u64 = 16;
/// Time of these over that of a round, at most; chosen, section 2, "Rounds".
pub(super) const CHAIN_ROUNDS_OF_TIME: f64 = 0.75;
/// Number of the first round of the pilot's chains: far from all others.
pub(super) const CHAIN_PILOT: u64 = PILOT + (1 << 40);
/// Chains in each part that tell what samples have not met; chosen, (U5).
pub(super) const CHAINS: u64 = 16;
/// Least quotient of a value and those that were met, so that rounding does not make it larger.
pub(super) const NEW: f64 = 1.01;

/// Most parts of the lights, unless they are asked for; chosen, section 1.
pub(super) const LIGHT_PARTS: usize = 8;
/// Least share of the power of a part that is asked for: the pilot measures each of them in every pixel; chosen.
pub(super) const LEAST_SHARE: f64 = 1.0 / 16.0;
/// Fewest and most edges of each class of paths; section 1.
pub(super) const LENGTHS: [[usize; 2]; 4] = [[1, 1], [2, 2], [3, 4], [5, usize::MAX]];

/// Points of one sequence for which two sequences a pixel, whose spread is the noise, are enough; shorter ones are four. Chosen.
pub(super) const LONG: u64 = 4;
/// Number of pixels with a value or a larger one that are enough to know how often these come; chosen, (U5) and (U7).
pub(super) const ENOUGH_PIXELS: usize = 10;
/// Squared relative noise of the smoothed image below which it needs no more smoothing; section 2, "Weights without noise".
pub(super) const SMOOTH: f64 = 0.05;
/// Largest radius of the smoothing, as a share of the image's longer side; section 2, "Weights without noise".
pub(super) const WIDEST: f64 = 0.125;

/// Share of a part's light that a method is to have met; (U7), between the shares of easy scenes and of hard ones there.
pub(super) const MET: f64 = 0.5;
/// Share of the image's light that matters; (U7).
pub(super) const NOTABLE: f64 = 0.03;
/// Standard deviations between a number of events and what may be expected: Cantelli's inequality, 90 %; section 3.
pub(super) const DEVIATIONS: f64 = 3.0;

/// A mixture is to be better than every single method by this factor, since it is chosen by noisy figures. Where light is
/// rare, it is enough that it is better. Section 3.
pub(super) const MIXTURE_GAIN: f64 = 0.6;
/// Least share of a round's work for chains; chosen, (U8).
pub(super) const LEAST_CHAINS: f64 = 0.125;
/// Work of a round over what was asked for, at most: numbers of samples are powers of two. (U8).
pub(super) const MOST_WORK: f64 = 1.25;
/// Work of chains over what they were promised, at least; section 3.
pub(super) const LEAST_OF_A_PROMISE: f64 = 0.5;
/// Numbers of branches that are tried; section 3, "Branches".
pub(super) const BRANCHES: [u32; 4] = [1, 2, 4, 8];
