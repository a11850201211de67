//! Progress on standard error: a bar on a terminal, elsewhere a line now and then.

mod bar;
mod lines;

use std::{
    io::{IsTerminal, stderr},
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::Duration,
};

use bar::Bar;
use lines::Lines;
use mlt_core::engine::Standing;

use crate::log;

/// Tells how far a render is; silent when the user wants quiet.
///
/// A bar is gone from the screen when dropped, so that an error message stands alone.
#[derive(Debug)]
pub struct Progress {
    shown: Shown,
    unit: &'static str,
    /// Percent of the preparation that are told.
    prepared: AtomicU64,
}

#[derive(Debug)]
enum Shown {
    Nothing,
    Bar(Bar),
    Lines(Mutex<Lines>),
}

impl Progress {
    /// `unit`: what the rate counts.
    pub fn new(unit: &'static str, quiet: bool) -> Self {
        let shown = match quiet {
            true => Shown::Nothing,
            // What else is told would run into a bar.
            false if stderr().is_terminal() && !log::is_on() => Shown::Bar(Bar::new()),
            false => Shown::Lines(Mutex::new(Lines::new())),
        };
        Self { shown, unit, prepared: AtomicU64::new(0) }
    }

    /// Whether anybody sees it.
    pub fn is_shown(&self) -> bool {
        !matches!(self.shown, Shown::Nothing)
    }

    /// Says which share of what comes first, such as a pilot, is done; it never goes back.
    pub fn prepare(&self, share: f64) {
        let percent = (100.0 * share) as u64;
        if self.prepared.fetch_max(percent, Relaxed) < percent || percent == 0 {
            self.show(0.0, &[format!("measuring {percent} %")]);
        }
    }

    /// `rate`: units per second.
    pub fn update(&self, at: &Standing, rate: f64) {
        let left = at.left.map(left);
        let error = at.error.map(|error| format!("error {:.2} %", error * 100.0));
        let rate = (rate > 0.0).then(|| format!("{} {}/s", short(rate), self.unit));
        let percent = format!("{:.0} %", 100.0 * at.share);
        let parts: Vec<_> = [Some(percent), left, error, rate].into_iter().flatten().collect();
        self.show(at.share, &parts);
    }

    /// `parts`: what is known, the most important first.
    fn show(&self, share: f64, parts: &[String]) {
        match &self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar) => bar.show(share, parts),
            // A line that another thread is writing makes this one needless.
            Shown::Lines(lines) => drop(lines.try_lock().map(|mut lines| lines.show(share, parts))),
        }
    }

    /// Takes a bar off the screen.
    pub fn finish(&self) {
        if let Shown::Bar(bar) = &self.shown {
            bar.finish();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Time that is left, in two units at most.
fn left(time: Duration) -> String {
    let seconds = time.as_secs_f64().ceil() as u64;
    let [minutes, hours, days] = [60, 3600, 86_400].map(|unit| seconds / unit);
    match (days, hours, minutes) {
        (0, 0, 0) if seconds == 0 => "finishing".into(),
        (0, 0, 0) => format!("{seconds}s left"),
        (0, 0, _) => format!("{minutes}m{:02}s left", seconds % 60),
        (0, ..) => format!("{hours}h{:02}m left", minutes % 60),
        _ => format!("{days}d{:02}h left", hours % 24),
    }
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
    fn time_left_is_for_reading() {
        let of = |seconds| left(Duration::from_secs_f64(seconds));
        assert_eq!(
            [0.0, 11.4, 200.0, 7500.0, 100_000.0].map(of),
            ["finishing", "12s left", "3m20s left", "2h05m left", "1d03h left"]
        );
    }

    #[test]
    fn quiet_progress_does_nothing() {
        let progress = Progress::new("samples", true);
        progress.update(&Standing { rounds: 1.0, error: None, share: 0.5, left: None }, 1.0);
        progress.finish();
        assert!(!progress.is_shown());
    }
}
