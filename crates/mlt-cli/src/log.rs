//! Messages about the program's decisions, for those who ask by `-v`.

use std::{fmt, io::stderr, time::Instant};

use anstream::{AutoStream, ColorChoice};
use tracing::Level;
use tracing_subscriber::fmt::{format::Writer, time::FormatTime};

/// From here on decisions are told on standard error: with 1 those of a render as a whole, with 2 those of each round, too.
pub(crate) fn start(verbosity: u8) {
    let level = match verbosity {
        0 => return,
        1 => Level::INFO,
        _ => Level::DEBUG,
    };
    let coloured = AutoStream::choice(&stderr()) != ColorChoice::Never;
    let subscriber = tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(stderr)
        .with_ansi(coloured)
        .with_target(false)
        .with_timer(SinceStart(Instant::now()))
        .finish();
    // One that is there already stays.
    let _ = tracing::subscriber::set_global_default(subscriber);
}

/// Whether anything is told.
pub(crate) fn is_on() -> bool {
    tracing::enabled!(Level::INFO)
}

/// Seconds since the program began.
struct SinceStart(Instant);

impl FormatTime for SinceStart {
    fn format_time(&self, to: &mut Writer<'_>) -> fmt::Result {
        write!(to, "{:8.3} s", self.0.elapsed().as_secs_f64())
    }
}
