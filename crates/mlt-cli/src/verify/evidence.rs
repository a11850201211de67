//! Evidence for a verdict: independent replicas of a method and of a reference.

use mlt_core::engine::{Grid, HalfChains};
use mlt_core::transport::lights::Stratification;
use mlt_core::transport::{Rgb, luminance};

use crate::{
    args::transport::Method,
    image::Image,
    render::Rendered,
    report::{Report, StratumReport},
};

/// Regions along each side of the image.
const SIDE: usize = 8;

/// One short render.
#[derive(Clone, Debug)]
pub struct Replica {
    /// Luminance of each pixel, row by row.
    pub pixels: Vec<f64>,
    /// Standard error that the render reports for each; empty where it reports none.
    pub stderr: Vec<f64>,
    /// Of each round: the mean luminance of the image that comes from each block.
    pub rounds: Vec<Vec<f64>>,
    /// b_j of the strata, or b of all together where each seed has strata of its own; empty for independent methods, and for
    /// `auto`, where each seed gives another share of the light to its chains.
    pub strata: Vec<StratumReport>,
    /// Longest run of proposals without an acceptance.
    pub longest_rejection: u64,
    /// Warnings of the render.
    pub warnings: Vec<String>,
    /// Whether it says itself that its error bars cannot be trusted.
    pub doubted: bool,
}

impl Replica {
    /// Of a render.
    pub(crate) fn new(rendered: Rendered) -> Self {
        let Rendered { image, stderr, report, blocks } = rendered;
        let grey = |rgb: &[f32; 3]| f64::from(luminance(Rgb::from_array(*rgb)));
        let longest_rejection = report.strata.iter().map(|s| s.longest_rejection).max().unwrap_or(0);
        let strata = match (report.method, report.transport.strata.lights) {
            (Method::Auto, _) => Vec::new(),
            (_, Stratification::Auto) => vec![together(&report)],
            _ => report.strata,
        };
        Self {
            pixels: pixels(&image),
            stderr: stderr.iter().flatten().map(grey).collect(),
            rounds: blocks.rounds,
            strata,
            longest_rejection,
            warnings: report.warnings,
            doubted: !report.trust.doubts().is_empty(),
        }
    }
}

/// All strata as one, which says nothing of how chains agree: those of different strata need not.
fn together(report: &Report) -> StratumReport {
    StratumReport {
        b: report.b,
        b_stderr: report.b_stderr,
        met_by_chance: false,
        mutations: report.mutations,
        longest_rejection: report.strata.iter().map(|s| s.longest_rejection).max().unwrap_or(0),
        r_hat: None,
        effective_states: None,
        halves: HalfChains::default(),
    }
}

/// Luminance of each pixel.
pub fn pixels(image: &Image) -> Vec<f64> {
    image.luminance().into_iter().map(f64::from).collect()
}

/// Replicas of the method that is judged, and of the one it is judged by.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Width and height of the images.
    pub size: [usize; 2],
    /// Independent renders.
    pub method: Vec<Replica>,
    /// Pixels of independent renders by the reference.
    pub reference: Vec<Vec<f64>>,
    /// Mean image of each group of lights on its own; together they are the reference.
    pub groups: Vec<Group>,
}

/// The image by some of the lights alone.
#[derive(Clone, Debug)]
pub struct Group {
    /// Name of the lights' material.
    pub name: String,
    /// Luminance of each pixel.
    pub pixels: Vec<f64>,
}

impl Evidence {
    /// The regions that are compared.
    pub fn regions(&self) -> Grid {
        Grid::new(self.size, SIDE)
    }

    /// Mean over replicas of each pixel, and the variance of that mean.
    pub fn pooled<'a>(images: impl Iterator<Item = &'a [f64]> + Clone) -> Vec<(f64, f64)> {
        let n = images.clone().count() as f64;
        let pixels = images.clone().next().map_or(0, <[f64]>::len);
        let (mut sums, mut squares) = (vec![0.0; pixels], vec![0.0; pixels]);
        for image in images.clone() {
            sums.iter_mut().zip(image).for_each(|(sum, x)| *sum += x / n);
        }
        for image in images {
            squares.iter_mut().zip(image).zip(&sums).for_each(|((square, x), mean)| *square += (x - mean).powi(2));
        }
        sums.into_iter().zip(squares).map(|(mean, square)| (mean, square / (n * (n - 1.0)))).collect()
    }

    /// Pixels of the method's replicas.
    pub fn images(&self) -> impl Iterator<Item = &[f64]> + Clone {
        self.method.iter().map(|replica| replica.pixels.as_slice())
    }

    /// Pixels of the reference's replicas.
    pub fn references(&self) -> impl Iterator<Item = &[f64]> + Clone {
        self.reference.iter().map(Vec::as_slice)
    }

    /// The best that is known of each pixel, with its variance: what has less noise of the method's mean and the
    /// reference's. That they agree is another check.
    pub fn truth(&self) -> Vec<(f64, f64)> {
        let noise = |pooled: &[(f64, f64)]| pooled.iter().map(|p| p.1).sum::<f64>();
        let (own, other) = (Self::pooled(self.images()), Self::pooled(self.references()));
        if noise(&own) < noise(&other) { own } else { other }
    }

    /// Whether no light arrives in any replica of either method.
    pub fn is_black(&self) -> bool {
        self.images().chain(self.references()).flatten().all(|&x| x == 0.0)
    }
}
