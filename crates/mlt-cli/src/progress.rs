//! Progress on the terminal.

use std::{
    io::{IsTerminal, stderr},
    time::Duration,
};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A progress bar on standard error; silent when that is no terminal or the user wants quiet.
///
/// Gone from the screen when dropped, so that an error message stands alone.
pub struct Progress(Option<ProgressBar>);

impl Progress {
    /// `total`: when [`update`](Self::update)'s `done` is complete, in any unit; `None` when nobody knows beforehand.
    pub fn new(total: Option<u64>, quiet: bool) -> Self {
        if quiet || !stderr().is_terminal() {
            return Self(None);
        }
        let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr_with_hz(5));
        let template = match total {
            Some(_) => "{bar:30} {percent:>3} %  {msg}  {eta} left",
            None => "{spinner}  {elapsed}  {msg}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(Some(bar))
    }

    /// `rate`: mutations (or samples) per second; `error`: relative error so far, once there is one.
    pub fn update(&self, done: u64, rate: f64, error: Option<f64>) {
        if let Some(bar) = &self.0 {
            bar.set_position(done);
            bar.set_message(message(rate, error));
        }
    }

    /// Takes the bar off the screen.
    pub fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

fn message(rate: f64, error: Option<f64>) -> String {
    let rate = per_second(rate);
    error.map_or(rate.clone(), |error| format!("{rate}  error {:.2} %", error * 100.0))
}

/// A rate for reading: `1.23 M/s`.
pub(crate) fn per_second(rate: f64) -> String {
    let (divisor, unit) = match rate {
        r if r >= 1e6 => (1e6, " M"),
        r if r >= 1e3 => (1e3, " k"),
        _ => (1.0, " "),
    };
    format!("{:.2}{unit}/s", rate / divisor).replace(" /s", "/s")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_short() {
        assert_eq!(per_second(1_234_567.0), "1.23 M/s");
        assert_eq!(per_second(2_500.0), "2.50 k/s");
        assert_eq!(per_second(12.0), "12.00/s");
    }

    #[test]
    fn the_error_shows_once_there_is_one() {
        assert_eq!(message(1e6, None), "1.00 M/s");
        assert_eq!(message(1e6, Some(0.0213)), "1.00 M/s  error 2.13 %");
    }

    #[test]
    fn quiet_progress_does_nothing() {
        let progress = Progress::new(Some(10), true);
        progress.update(3, 1.0, None);
        progress.finish();
        assert!(progress.0.is_none());
    }
}
