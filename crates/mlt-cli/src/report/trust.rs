//! Whether the error bars of an image can be trusted, in figures and in words.

use serde::Serialize;

/// Share of the light in a part of the image that is too much for one round.
const MOST_OF_ROUND: f64 = 1.0 / 3.0;
/// Fewest independent samples of equal weight that chains should start from.
const LEAST_STARTS: f64 = 50.0;
/// Share of the image's light that samples may have missed, where the error of b does not tell, before b is called a lower bound.
const MOST_UNMET: f64 = 0.02;
/// The remedy, in words.
const REMEDY: &str = "render longer, or by another method";

/// Figures that tell whether the bars of an image can be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Trust {
    /// Share of the squared relative error, as estimated, that lies in the worst hundredth of the pixels; `None` without any, and with
    /// too few rounds.
    pub worst_pixels: Option<f64>,
    /// Largest share that one round has of the light in a part of the image; `None` with too few rounds.
    pub largest_round: Option<f64>,
    /// Independent samples of equal weight that chains start from; `None` without chains.
    pub starts: Option<f64>,
    /// Share of the image's light that chains found on paths which all independent samples were to meet fewer than ten times; `None`
    /// without chains.
    pub unmet_light: Option<f64>,
    /// Standard error of b over b; `None` where it is not known.
    pub b_error: Option<f64>,
}

impl Trust {
    /// Share of the image's squared relative error that is too much for the worst hundredth of its pixels.
    pub const MOST_OF_WORST: f64 = 0.7;

    /// Why the bars are not to be trusted, and why b is a lower bound.
    pub fn doubts(&self) -> Vec<String> {
        let Self { worst_pixels, largest_round, starts, unmet_light, b_error } = *self;
        let above =
            |figure: Option<f64>, most: f64| figure.filter(|&figure| figure > most).map(|figure| 100.0 * figure);
        let reasons: Vec<String> = [
            above(worst_pixels, Self::MOST_OF_WORST)
                .map(|share| format!("one pixel in a hundred holds {share:.0} % of the error")),
            above(largest_round, MOST_OF_ROUND)
                .map(|share| format!("one round brought {share:.0} % of the light in a part of the image")),
            starts
                .filter(|&starts| starts < LEAST_STARTS)
                .map(|starts| format!("the chains start from what {starts:.0} independent samples are worth")),
        ]
        .into_iter()
        .flatten()
        .collect();
        let bars = (!reasons.is_empty())
            .then(|| format!("the error bars cannot be trusted: {}; {REMEDY}", reasons.join(", and ")));
        let told = b_error.unwrap_or(f64::INFINITY);
        let b = above(unmet_light, MOST_UNMET.max(told)).map(|share| {
            format!(
                "b is a lower bound, and the image may be too dark: {share:.0} % of the light comes by paths that the samples at which \
                 chains start were to find fewer than ten times; {REMEDY}"
            )
        });
        bars.into_iter().chain(b).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubts_name_their_figures() {
        let sound = Trust {
            worst_pixels: Some(0.3),
            largest_round: Some(0.2),
            starts: Some(900.0),
            unmet_light: Some(0.01),
            b_error: Some(0.001),
        };
        assert!(sound.doubts().is_empty() && Trust::default().doubts().is_empty());
        // What the error of b tells is no news.
        assert!(Trust { unmet_light: Some(0.05), b_error: Some(0.06), ..sound }.doubts().is_empty());
        let doubts = Trust {
            worst_pixels: Some(0.93),
            largest_round: Some(0.5),
            starts: Some(12.0),
            unmet_light: Some(0.34),
            b_error: Some(0.06),
        }
        .doubts();
        let [bars, b] = &doubts[..] else { panic!("{doubts:?}") };
        assert!(["93 %", "50 %", "what 12 independent samples"].iter().all(|figure| bars.contains(figure)), "{bars}");
        assert!(b.starts_with("b is a lower bound") && b.contains("34 % of the light"), "{b}");
    }
}
