//! `mlt diff`: how far images are from a reference.

use std::path::Path;

use anyhow::{Context, bail};
use flip_rs::{DEFAULT_PPD, ErrorMap, FlipError, HdrOptions, RgbImage};
use mlt_core::measure::Measures;
use serde::Serialize;

use crate::{
    Failure,
    args::DiffOptions,
    image::Image,
    output::{self, Format},
    terminal,
};

/// One image against the reference; the definitions are [`Measures`]'.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// The image's path as given.
    pub image: String,
    /// mean (a − b)² / max(a, 10⁻³).
    pub relative_diff: f64,
    /// mean (a − b)² / (a² + 10⁻²).
    pub rel_mse: f64,
    /// mean |a − b| / max(a, 10⁻³), a fraction.
    pub mape: f64,
    /// mean b / mean a; `null` in JSON when the reference is black.
    pub mean_ratio: f64,
    /// Mean FLIP error, 0…1; `None` where it is not defined, with a warning.
    pub flip: Option<f32>,
    /// Same bits in every pixel.
    pub identical: bool,
}

/// An image, where it came from and what it was stored as.
struct Picture<'a> {
    path: &'a Path,
    image: Image,
    format: Format,
}

/// Measures every image and prints the result.
pub fn run(options: &DiffOptions) -> Result<(), Failure> {
    let reference = Picture::read(&options.reference)?;
    let differences =
        options.images.iter().map(|path| compare(&reference, &Picture::read(path)?)).collect::<Result<Vec<_>, _>>()?;
    let text = if options.json {
        serde_json::to_string_pretty(&differences).context("cannot print as JSON")? + "\n"
    } else {
        table(&differences)
    };
    Ok(terminal::print(&text)?)
}

impl<'a> Picture<'a> {
    fn read(path: &'a Path) -> anyhow::Result<Self> {
        let (image, format) = output::read_image(path)?;
        if let Some((x, y)) = image.first_non_finite() {
            bail!("{}: pixel ({x}, {y}) is NaN or infinite, so the image has no error", path.display());
        }
        Ok(Self { path, image, format })
    }
}

fn compare(reference: &Picture, picture: &Picture) -> anyhow::Result<Difference> {
    let (a, b) = (&reference.image, &picture.image);
    if (a.width, a.height) != (b.width, b.height) {
        bail!(
            "{}: {}x{} pixels, but the reference {} has {}x{}",
            picture.path.display(),
            b.width,
            b.height,
            reference.path.display(),
            a.width,
            a.height
        );
    }
    let measures = Measures::between(&a.luminance(), &b.luminance()).context("the images have no pixel")?;
    let flip = flip(reference, picture);
    if let Err(error) = &flip {
        terminal::warn(&format!("{}: no FLIP: {error}", picture.path.display()));
    }
    Ok(Difference {
        image: picture.path.display().to_string(),
        relative_diff: measures.relative_diff,
        rel_mse: measures.rel_mse,
        mape: measures.mape,
        mean_ratio: measures.mean_ratio,
        flip: flip.ok().map(|map| map.statistics().mean),
        identical: a.same_bits(b),
    })
}

/// LDR-FLIP of two PNG or JPEG files; HDR-FLIP as soon as one image is linear: the largest error over the exposures that the
/// reference's brightest and median luminance span, ACES tone curve.
///
/// Source: [Andersson20], [Andersson21]; 67 pixels per degree, as in the authors' program.
fn flip(reference: &Picture, picture: &Picture) -> Result<ErrorMap, FlipError> {
    if reference.format.is_for_screens() && picture.format.is_for_screens() {
        let encoded = |image: &Image| flip_image(image, output::srgb::srgb_from_linear);
        return flip_rs::ldr_flip(&encoded(&reference.image)?, &encoded(&picture.image)?, DEFAULT_PPD);
    }
    hdr_flip(&reference.image, &picture.image)
}

/// HDR-FLIP of two linear images.
pub(crate) fn hdr_flip(reference: &Image, image: &Image) -> Result<ErrorMap, FlipError> {
    let mut options = HdrOptions::default();
    options.return_exposure_map = false;
    if reference.luminance().iter().all(|&luminance| luminance <= 0.0) {
        // A black reference does not say how to expose it.
        (options.start_exposure, options.stop_exposure) = (Some(0.0), Some(0.0));
    }
    let linear = |image: &Image| flip_image(image, |value| value);
    Ok(flip_rs::hdr_flip(&linear(reference)?, &linear(image)?, options)?.error_map)
}

fn flip_image(image: &Image, curve: impl Fn(f32) -> f32) -> Result<RgbImage<f32>, FlipError> {
    let values = image.rgb.as_flattened().iter().map(|&value| curve(value)).collect();
    RgbImage::new(image.width, image.height, values)
}

/// One line an image, columns aligned.
fn table(differences: &[Difference]) -> String {
    let width = differences.iter().map(|difference| difference.image.chars().count()).max().unwrap_or(0).max(5);
    let mut text = format!(
        "{:width$}  {:>12}  {:>12}  {:>12}  {:>10}  {:>8}  identical\n",
        "image", "relativeDiff", "relMSE", "MAPE", "mean ratio", "FLIP"
    );
    for d in differences {
        let flip = d.flip.map_or("-".into(), |flip| format!("{flip:.5}"));
        let identical = if d.identical { "yes" } else { "no" };
        text += &format!(
            "{:width$}  {:>12.4e}  {:>12.4e}  {:>12.4e}  {:>10.6}  {flip:>8}  {identical}\n",
            d.image, d.relative_diff, d.rel_mse, d.mape, d.mean_ratio
        );
    }
    text
}
