//! The image files of a render.

use mlt_core::{engine::Film, transport::render::Sums};
use rayon::prelude::*;

use super::{Features, Plan, exposure, made::Made};
use crate::{
    Failure,
    args::{
        render::RenderOptions,
        written::{command_line, shell_word, written},
    },
    denoise::{Denoiser, Guides},
    image::Image,
    kept,
    output::{Frame, Medium, OutputFile, Picture},
    report::Report,
};

/// Writes all files, on the current rayon pool, and names them in the report. One that cannot be written does not stop the others.
pub(crate) fn write(options: &RenderOptions, made: Made, sums: &Sums) -> Result<Report, Failure> {
    let attributes = attributes(options, &made.report, made.per_pixel)?;
    let Made { about, pilot, mut report, features: Features { channels, guides }, .. } = made;
    let (parts, images): (Vec<_>, Vec<_>) = options.targets().into_iter().partition(OutputFile::holds_sums);
    let mut saved: Vec<_> = parts
        .iter()
        .map(|output| {
            let bytes = kept::encode(&about, pilot.as_deref(), sums)?;
            save(output, |to| Ok(to.write_all(&bytes)?))
        })
        .collect();
    if !images.is_empty() {
        let image = developed(sums.film())?;
        let shown = images.iter().any(|output| output.format.is_for_screens());
        report.warnings.extend(shown.then(|| exposure::advice(&image, options.exposure)).flatten());
        let frame = options.view.frame()?.unwrap_or(Frame::whole(&image));
        let errors = Some(sums.film()).filter(|film| film.rounds() > 1);
        let picture = Picture { image, errors, channels, frame, attributes, exposure: options.exposure };
        saved.par_extend(images.par_iter().map(|output| save(output, |to| picture.write(output.format, to))));
        if let Some(guides) = guides {
            let picture = denoised(picture, &guides)?;
            let beside = images.iter().filter_map(OutputFile::denoised);
            saved.extend(beside.map(|output| save(&output, |to| picture.write(output.format, to))));
        }
    }
    let mut failure = None;
    for name in saved {
        match name {
            Ok(name) => report.outputs.push(name),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    failure.map_or(Ok(report), |error| Err(error.into()))
}

/// Writes a file, and gives its name.
fn save(output: &OutputFile, content: impl FnOnce(&mut dyn Medium) -> anyhow::Result<()>) -> anyhow::Result<String> {
    output.write(content)?;
    tracing::info!("{} is written", output.path.display());
    Ok(output.path.display().to_string())
}

/// The picture with its noise filtered out, and marked as biased; its other channels are left out.
fn denoised<'a>(picture: Picture<'a>, guides: &Guides) -> anyhow::Result<Picture<'a>> {
    let (image, version) = Denoiser::load()?.denoise(&picture.image, guides)?;
    let words =
        format!("biased: filtered by Open Image Denoise {version}; b and errors are those of the image before it");
    let mark = ("mlt.denoised".to_owned(), words);
    let attributes = picture.attributes.into_iter().chain([mark]).collect();
    Ok(Picture { image, errors: None, channels: Vec::new(), attributes, ..picture })
}

/// The image of a film.
pub(super) fn developed(film: &Film<3>) -> anyhow::Result<Image> {
    let [width, height] = film.size().map(|n| n as usize);
    Image::new(width, height, film.means())
}

/// The options that make the file again, and the figures of the render.
fn attributes(options: &RenderOptions, report: &Report, per_pixel: f64) -> anyhow::Result<Vec<(String, String)>> {
    let transport = written(&report.transport)?;
    let view = written(&options.view)?;
    let command = [
        vec!["mlt render".to_owned(), shell_word(&report.scene), format!("--method={}", report.method)],
        command_line(&transport),
        vec![
            Plan::budget_option(report.method, per_pixel, report.rounds),
            format!("--rounds={} --first-round={}", report.rounds, report.first_round),
        ],
        command_line(&written(&options.reading)?),
        command_line(&view),
    ];
    let of_render = [
        ("version", report.version.clone()),
        ("scene", report.scene.clone()),
        ("command", command.concat().join(" ")),
        ("method", report.method.to_string()),
        ("rounds", report.rounds.to_string()),
        ("first_round", report.first_round.to_string()),
        ("per_pixel_per_round", per_pixel.to_string()),
        ("b", report.b.to_string()),
        ("b_stderr", known(Some(report.b_stderr))),
        ("seconds", report.seconds.to_string()),
        ("relative_error", known(report.relative_error)),
        ("r_hat", known(report.agreement.map(|agreement| agreement.r_hat))),
        ("warnings", report.warnings.join("\n")),
    ];
    let all = of_render.map(|(name, value)| (name.to_owned(), value)).into_iter().chain(transport);
    Ok(all.map(|(name, value)| (format!("mlt.{name}"), value)).collect())
}

/// A figure, if it is one.
fn known(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or_else(|| "unknown".into(), |value| value.to_string())
}
