//! The image files of a render.

use mlt_core::engine::Film;
use rayon::prelude::*;

use super::{Plan, key::view, session::Finished};
use crate::{
    Failure,
    args::{
        render::RenderOptions,
        written::{command_line, shell_word, written},
    },
    atomic,
    image::Image,
    kept,
    output::{Format, OutputFile, exr, png},
    report::Report,
};

/// Writes all files, on the current rayon pool, and names them in the report. One that cannot be written does not stop the others.
pub(crate) fn write(options: &RenderOptions, finished: Finished) -> Result<Report, Failure> {
    let Finished { sums, pilot, about, mut report, per_pixel } = finished;
    let attributes = attributes(options, &report, per_pixel)?;
    let save = |output: &OutputFile, bytes: anyhow::Result<Vec<u8>>| -> anyhow::Result<String> {
        atomic::write(&output.path, &bytes?)?;
        tracing::info!("{} is written", output.path.display());
        Ok(output.path.display().to_string())
    };
    let (parts, images): (Vec<_>, Vec<_>) = options.targets().into_iter().partition(OutputFile::holds_sums);
    let mut saved: Vec<_> =
        parts.iter().map(|output| save(output, kept::encode(&about, pilot.as_deref(), &sums))).collect();
    if !images.is_empty() {
        let with_errors = images.iter().any(|output| output.format == Format::Exr);
        let (image, stderr) = develop(sums.into_parts().0, with_errors)?;
        let encode = |output: &OutputFile| match output.format == Format::Exr {
            true => exr::encode(&image, stderr.as_deref(), &attributes),
            false => png::encode(&image, options.exposure),
        };
        saved.par_extend(images.par_iter().map(|output| save(output, encode(output))));
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

/// Standard errors of the channels of all pixels.
type Errors = Vec<[f32; 3]>;

/// The image and, if they are asked for, its standard errors; `None` where one round tells nothing of them.
pub(super) fn develop(mut film: Film<3>, with_errors: bool) -> anyhow::Result<(Image, Option<Errors>)> {
    film.finish();
    let [width, height] = film.size().map(|n| n as usize);
    let image = Image::new(width, height, film.means())?;
    let errors = || film.standard_errors().into_iter().map(|e| e.map(|x| x as f32)).collect();
    let stderr = (with_errors && film.rounds() > 1).then(errors);
    Ok((image, stderr))
}

/// The options that make the file again, and the figures of the render.
fn attributes(options: &RenderOptions, report: &Report, per_pixel: f64) -> anyhow::Result<Vec<(String, String)>> {
    let transport = written(&report.transport)?;
    let view = written(&view(options, [report.width, report.height]))?;
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
