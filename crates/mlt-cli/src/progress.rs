//! Progress on the terminal.

use std::{
    io::{IsTerminal, stderr},
    time::Duration,
};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A progress bar on standard error; silent when that is no terminal or the user wants quiet.
///
/// Gone from the screen when dropped, so that an error message stands alone.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    unit: &'static str,
}

impl Progress {
    /// `total`: [`update`](Self::update)'s `done` when all is done; `unit`: what the rate counts.
    pub fn new(total: u64, unit: &'static str, quiet: bool) -> Self {
        if quiet || !stderr().is_terminal() {
            return Self { bar: None, unit };
        }
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr_with_hz(5));
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar: Some(bar), unit }
    }

    /// Whether anybody sees it.
    pub fn is_shown(&self) -> bool {
        self.bar.is_some()
    }

    /// Says that what comes first, such as a pilot, is not done.
    pub fn prepare(&self) {
        if let Some(bar) = &self.bar {
            bar.set_message("measuring");
        }
    }

    /// `rate`: units per second; `error`: relative error so far, once there is one.
    pub fn update(&self, done: u64, rate: f64, error: Option<f64>) {
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            let left = (done > 0).then(|| bar.eta());
            bar.set_message(message(left, &format!("{} {}/s", short(rate), self.unit), error));
        }
    }

    /// Takes the bar off the screen.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

/// The figures known so far, side by side.
fn message(left: Option<Duration>, rate: &str, error: Option<f64>) -> String {
    let left = left.map(|left| format!("{:#} left", HumanDuration(left)));
    let error = error.map(|error| format!("error {:.2} %", error * 100.0));
    [left, Some(rate.to_owned()), error].into_iter().flatten().collect::<Vec<_>>().join("  ")
}

/// A count for reading: `1.23 million`.
pub(crate) fn short(count: f64) -> String {
    match count {
        n if n >= 1e9 => format!("{:.2} billion", n / 1e9),
        n if n >= 1e6 => format!("{:.2} million", n / 1e6),
        n => format!("{n:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_short() {
        assert_eq!(short(4_234_567_890.0), "4.23 billion");
        assert_eq!(short(1_234_567.0), "1.23 million");
        assert_eq!(short(12.0), "12");
    }

    #[test]
    fn remaining_time_and_error_show_once_they_are_known() {
        assert_eq!(message(None, "3 samples/s", None), "3 samples/s");
        let left = Some(Duration::from_secs(12));
        assert_eq!(message(left, "3 samples/s", Some(0.0213)), "12s left  3 samples/s  error 2.13 %");
    }

    #[test]
    fn quiet_progress_does_nothing() {
        let progress = Progress::new(10, "samples", true);
        progress.update(3, 1.0, None);
        progress.finish();
        assert!(!progress.is_shown());
    }
}
