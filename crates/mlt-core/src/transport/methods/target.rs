//! The importance that a render's settings choose.

use super::bidirectional::BidirectionalTracing;
use super::film_unit::film_of;
use super::run::{Run, Sums};
use super::settings::{Method, Settings};
use crate::engine::{Outcome, PILOT, Watch};
use crate::transport::image::{PixelImportance, Target, luminance_and_error};
use crate::transport::scene::View;

/// Samples a pixel of the image that a relative importance is made from.
const SAMPLES_OF_LEVEL: f64 = 4.0;

/// The importance of a render. A relative one is made from a quick image. Nothing if that is stopped.
pub(super) fn importance(view: View, settings: &Settings, watch: Watch) -> Option<PixelImportance> {
    match settings.target {
        Target::Luminance => Some(PixelImportance::default()),
        Target::Relative => {
            let image = quick_image(view, settings, watch)?;
            Some(PixelImportance::relative(&image, view.camera.size()))
        }
    }
}

/// Luminance of each pixel, with noise.
fn quick_image(view: View, settings: &Settings, watch: Watch) -> Option<Vec<f64>> {
    let &Settings { max_edges, seed, .. } = settings;
    let quick = Settings { max_edges, seed, ..Settings::new(Method::Bidirectional, SAMPLES_OF_LEVEL) };
    let mut sums = Sums::new(film_of(view));
    let outcome = BidirectionalTracing::new(view, quick).render(Run {
        rounds: PILOT..PILOT + 1,
        sums: &mut sums,
        observe: &mut |_, _| watch.go_on(),
    });
    if outcome == Outcome::Stopped {
        return None;
    }
    let film = sums.film();
    Some((0..film.sites() as usize).map(|i| luminance_and_error(film, i).0).collect())
}
