//! Frames of an animation, one after the other.

use std::collections::BTreeSet;

use anyhow::Context;
use mlt_scene::{MovingScene, printable};
use serde::Serialize;

use super::{Setup, Workshop, rendered};
use crate::{
    Failure,
    args::{frames::Frames, render::RenderOptions},
    memory, print,
    report::Report,
    warn,
};

/// The report of a frame.
#[derive(Debug, Serialize)]
struct FrameReport {
    /// Its number.
    frame: u32,
    /// Its time in the animations, s.
    time_in_animation: f64,
    /// All else.
    #[serde(flatten)]
    report: Report,
}

/// Renders and writes all frames, and reports each. What stays the same from frame to frame is read and built once.
pub(super) fn run(options: &RenderOptions, frames: &Frames) -> Result<(), Failure> {
    let numbers = frames.0.clone();
    numbers.clone().try_for_each(|number| options.of_frame(number).check())?;
    let workshop = Workshop::open(options)?;
    let mut scene = MovingScene::new(&options.scene, options.reading.load_options());
    let (mut geometry, mut told, mut reports) = (None, BTreeSet::new(), Vec::new());
    for number in numbers {
        let (options, time) = (&options.of_frame(number), options.frames.seconds(number));
        let memory = memory();
        let loaded = scene.at(time, &memory).map_err(|error| Failure::Usage(error.into()))?;
        let setup = workshop.pool.install(|| Setup::of(options, loaded, memory, geometry.take()))?;
        let report = rendered(options, &setup, &workshop, None)?;
        geometry = setup.scene.into_geometry();
        for warning in report.warnings.iter().filter(|&warning| told.insert(warning.clone())) {
            warn(&format!("frame {number}: {warning}"));
        }
        let stopped = report.interrupted || workshop.interrupt.requested();
        let frame = FrameReport { frame: number, time_in_animation: time, report };
        if !options.json && !options.quiet {
            print(&(printable(&frame.line(), usize::MAX) + "\n"))?;
        }
        reports.push(frame);
        if stopped {
            break;
        }
    }
    if options.json {
        print(&(serde_json::to_string_pretty(&reports).context("cannot encode the report")? + "\n"))?;
    }
    let all = reports.len() == frames.0.clone().count() && !reports.iter().any(|frame| frame.report.interrupted);
    if all { Ok(()) } else { Err(Failure::Interrupted) }
}

impl FrameReport {
    /// The part of the report that matters of a frame.
    fn line(&self) -> String {
        let Self { frame, time_in_animation, report } = self;
        let error =
            report.relative_error.map_or("error unknown".into(), |error| format!("error {:.2} %", 100.0 * error));
        let (rounds, seconds, outputs) = (report.rounds, report.seconds, report.outputs.join(" "));
        format!("frame {frame} at {time_in_animation:.3} s: {error}, {rounds} rounds, {seconds:.1} s: {outputs}")
    }
}
