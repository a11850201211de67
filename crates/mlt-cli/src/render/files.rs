//! The image files of a render.

use std::path::PathBuf;

use mlt_core::engine::Film;

use super::{Plan, Setup, session::Finished};
use crate::{
    Failure,
    args::render::RenderOptions,
    image::Image,
    output::{Format, OutputFile, atomic, exr, png},
    report::Report,
};

/// Writes all files and names them in the report.
pub fn write(options: &RenderOptions, setup: &Setup, finished: Finished) -> Result<Report, Failure> {
    let Finished { film, mut report, per_pixel } = finished;
    let (image, stderr) = develop(film, setup)?;
    for output in targets(options, setup) {
        report.outputs.push(output.path.display().to_string());
        let bytes = match output.format {
            Format::Exr => exr::encode(&image, stderr.as_deref(), &attributes(options, &report, per_pixel))?,
            Format::Png => png::encode(&image, options.exposure)?,
        };
        atomic::write(&output.path, &bytes)?;
    }
    Ok(report)
}

/// The files asked for, or SCENE.exr and SCENE.png here.
fn targets(options: &RenderOptions, setup: &Setup) -> Vec<OutputFile> {
    if !options.outputs.is_empty() {
        return options.outputs.clone();
    }
    let file = |extension: &str, format| OutputFile { path: PathBuf::from(setup.stem() + extension), format };
    vec![file(".exr", Format::Exr), file(".png", Format::Png)]
}

/// The image and its standard errors; `None` where one round tells nothing of them.
#[allow(clippy::type_complexity)]
pub fn develop(mut film: Film<3>, setup: &Setup) -> anyhow::Result<(Image, Option<Vec<[f32; 3]>>)> {
    film.finish();
    let [width, height] = setup.camera.size().map(|n| n as usize);
    let pixels = || (0..film.sites() as usize).map(|i| film.pixel(i));
    let image = Image::new(width, height, pixels().map(|p| p.map(|c| c.mean as f32)).collect())?;
    let stderr = (film.rounds() > 1).then(|| pixels().map(|p| p.map(|c| c.stderr as f32)).collect());
    Ok((image, stderr))
}

/// What makes the file again.
fn attributes(options: &RenderOptions, report: &Report, per_pixel: f64) -> Vec<(String, String)> {
    let mut command = vec![
        "mlt render".to_owned(),
        report.scene.clone(),
        format!("--method {}", report.method),
        format!("--strata {}", report.strata_option),
        Plan::budget_option(options.method, per_pixel, report.rounds),
        format!("--rounds {} --first-round {} --seed {}", report.rounds, report.first_round, report.seed),
        format!("--size {}x{}", report.width, report.height),
    ];
    command.extend(options.max_length.map(|edges| format!("--max-length {edges}")));
    command.extend(options.camera.as_ref().map(|name| format!("--camera {name}")));
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
        text("importance", report.importance.clone()),
        text("seed", report.seed.to_string()),
        text("rounds", report.rounds.to_string()),
        text("first_round", report.first_round.to_string()),
        text("per_pixel_per_round", per_pixel.to_string()),
        text("b", report.b.to_string()),
        text("b_stderr", report.b_stderr.to_string()),
        text("seconds", report.seconds.to_string()),
        text("relative_error", report.relative_error.map_or_else(|| "unknown".into(), |error| error.to_string())),
        text("warnings", report.warnings.join("\n")),
    ]
}
