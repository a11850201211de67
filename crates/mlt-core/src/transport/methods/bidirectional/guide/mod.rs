//! Knowledge of light that only chance meets, from before the first round: where it comes from, and where it is seen.
//!
//! Both are found once, by random numbers of their own, so rounds stay independent and unbiased whatever they tell.

mod aim;
mod clusters;
mod events;
mod fit;
mod glimpses;
mod lobe;
mod photons;
mod place;
mod tree;
mod walk;

use crate::transport::lights::LightRegion;
use crate::transport::methods::settings::Settings;
use crate::transport::scene::View;

pub(super) use events::Events;
pub(super) use glimpses::Glimpses;
pub(super) use photons::Photons;

/// Directions and film points for light that only chance meets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Guide {
    pub(super) photons: Photons,
    pub(super) glimpses: Glimpses,
}

impl Guide {
    /// For a render, and the rays that it took; empty if the scene has no paths that only chance meets.
    pub(crate) fn new(view: &View, settings: &Settings, lights: &LightRegion) -> (Self, u64) {
        if !view.scene.needs().met_by_chance {
            return (Self::default(), 0);
        }
        let (photons, of_photons) = Photons::new(view, settings, lights);
        let (glimpses, of_glimpses) = Glimpses::new(view, settings, lights, &photons);
        (Self { photons, glimpses }, of_photons + of_glimpses)
    }
}
