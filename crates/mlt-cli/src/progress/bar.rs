//! One line of a terminal that is written again and again.

use std::{io::stderr, time::Duration};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use terminal_size::{Width, terminal_size_of};

/// Columns of a terminal that does not tell.
const USUAL_COLUMNS: usize = 80;
/// Columns of the bar, at most and at least.
const BAR: [usize; 2] = [30, 10];

/// A bar with what is known beside it; as much of both as one line has room for.
#[derive(Debug)]
pub(super) struct Bar(ProgressBar);

impl Bar {
    pub(super) fn new() -> Self {
        let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr_with_hz(5));
        if let Ok(style) = ProgressStyle::with_template("{msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    pub(super) fn show(&self, share: f64, parts: &[String]) {
        let columns = terminal_size_of(stderr()).map(|(Width(columns), _)| usize::from(columns));
        self.0.set_message(line(columns.filter(|&n| n > 0).unwrap_or(USUAL_COLUMNS), share, parts));
    }

    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// A line that is shorter than the terminal, since some wrap a full one: the first parts, as many as fit, after a bar if that fits, too.
fn line(columns: usize, share: f64, parts: &[String]) -> String {
    let mut room = columns.saturating_sub(1);
    let mut text = String::new();
    for part in parts {
        let apart = if text.is_empty() { "" } else { "  " };
        let needed = apart.len() + part.chars().count();
        if needed > room {
            break;
        }
        room -= needed;
        text += apart;
        text += part;
    }
    let width = room.saturating_sub(2).min(BAR[0]);
    if width < BAR[1] || share == 0.0 {
        return text;
    }
    let done = (share * width as f64).round() as usize;
    format!("{}{}  {text}", "█".repeat(done), "░".repeat(width - done.min(width)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_shorter_than_the_terminal() {
        let parts = ["43 %", "3m20s left", "error 2.13 %", "1.23 million samples/s"].map(str::to_owned);
        for columns in 0..120 {
            let line = line(columns, 0.43, &parts);
            assert!(line.chars().count() < columns.max(1), "{columns}: {line}");
        }
        assert_eq!(line(20, 0.43, &parts), "43 %  3m20s left");
        assert_eq!(line(40, 0.5, &parts), "43 %  3m20s left  error 2.13 %");
        assert!(line(120, 0.5, &parts).starts_with(&("█".repeat(15) + &"░".repeat(15) + "  43 %")));
    }
}
