//! The image files of a render.

use mlt_core::engine::Film;
use mlt_core::transport::image::standard_errors;
use rayon::prelude::*;

use super::{Plan, Setup, session::Finished};
use crate::{
    Failure,
    args::render::RenderOptions,
    image::Image,
    output::{Format, OutputFile, atomic, exr, png},
    report::Report,
};

/// Writes all files, on the current rayon pool, and names them in the report. One that cannot be written does not stop the others.
pub fn write(options: &RenderOptions, setup: &Setup, finished: Finished) -> Result<Report, Failure> {
    let Finished { film, mut report, per_pixel, .. } = finished;
    let (image, stderr) = develop(film, setup)?;
    let attributes = attributes(options, &report, per_pixel);
    let write = |output: &OutputFile| -> anyhow::Result<String> {
        let bytes = match output.format {
            Format::Exr => exr::encode(&image, stderr.as_deref(), &attributes)?,
            Format::Png => png::encode(&image, options.exposure)?,
        };
        atomic::write(&output.path, &bytes)?;
        Ok(output.path.display().to_string())
    };
    let mut failure = None;
    for output in options.targets() {
        match write(&output) {
            Ok(name) => report.outputs.push(name),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    failure.map_or(Ok(report), |error| Err(error.into()))
}

/// The image and its standard errors; `None` where one round tells nothing of them.
#[allow(clippy::type_complexity)]
pub fn develop(mut film: Film<3>, setup: &Setup) -> anyhow::Result<(Image, Option<Vec<[f32; 3]>>)> {
    film.finish();
    let [width, height] = setup.camera.size().map(|n| n as usize);
    let pixels = (0..film.sites() as usize).into_par_iter().map(|i| film.pixel(i).map(|c| c.mean as f32));
    let image = Image::new(width, height, pixels.collect())?;
    let errors = || standard_errors(&film, setup.camera.size()).into_iter().map(|e| e.map(|x| x as f32)).collect();
    let stderr = (film.rounds() > 1).then(errors);
    Ok((image, stderr))
}

/// The options that make the file again.
fn attributes(options: &RenderOptions, report: &Report, per_pixel: f64) -> Vec<(String, String)> {
    let mut command = vec![
        "mlt render".to_owned(),
        shell_word(&report.scene),
        format!("--method {}", report.method),
        format!("--strata {} --weights {}", report.strata_option, report.weights),
        format!("--rounds-pilot {} --variant {}", report.rounds_pilot, report.variant),
        format!("--perturbations {} --importance {}", report.perturbations, report.importance),
        Plan::budget_option(options.method(), per_pixel, report.rounds),
        format!("--rounds {} --first-round {} --seed {}", report.rounds, report.first_round, report.seed),
        format!("--size {}x{}", report.width, report.height),
    ];
    command.extend(options.max_length.map(|edges| format!("--max-length {edges}")));
    command.extend(options.camera.as_ref().map(|name| format!("--camera={}", shell_word(name))));
    let point = |[x, y, z]: [f64; 3]| format!("{x},{y},{z}");
    command.extend(options.camera_from.map(|from| format!("--camera-from {}", point(from))));
    command.extend(options.camera_to.map(|to| format!("--camera-to {}", point(to))));
    command.extend(options.fov.map(|fov| format!("--fov {fov}")));
    let text = |name: &str, value: String| (format!("mlt.{name}"), value);
    vec![
        text("version", report.version.clone()),
        text("scene", report.scene.clone()),
        text("command", command.join(" ")),
        text("method", report.method.clone()),
        text("strata", report.strata_option.clone()),
        text("weights", report.weights.clone()),
        text("rounds_pilot", report.rounds_pilot.to_string()),
        text("variant", report.variant.clone()),
        text("perturbations", report.perturbations.clone()),
        text("importance", report.importance.clone()),
        text("seed", report.seed.to_string()),
        text("rounds", report.rounds.to_string()),
        text("first_round", report.first_round.to_string()),
        text("per_pixel_per_round", per_pixel.to_string()),
        text("b", report.b.to_string()),
        text("b_stderr", known(Some(report.b_stderr))),
        text("seconds", report.seconds.to_string()),
        text("relative_error", known(report.relative_error)),
        text("r_hat", known(report.agreement.map(|agreement| agreement.r_hat))),
        text("warnings", report.warnings.join("\n")),
    ]
}

/// A figure, if it is one.
fn known(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or_else(|| "unknown".into(), |value| value.to_string())
}

/// `text` as one word for a POSIX shell.
fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./:,+=@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text.into() } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::shell_word;

    #[test]
    fn words_survive_the_shell() {
        let words = [("a/b-1.glb", "a/b-1.glb"), ("", "''"), ("my room.glb", "'my room.glb'"), ("it's", r"'it'\''s'")];
        for (text, word) in words {
            assert_eq!(shell_word(text), word);
        }
    }
}
