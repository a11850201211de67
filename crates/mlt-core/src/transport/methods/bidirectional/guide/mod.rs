//! What is known of light that only chance meets before the first round: where it comes from, and where it is seen.
//!
//! Both are found once, by random numbers of their own, so rounds stay independent and unbiased whatever they tell.

mod aim;
mod events;
mod images;
mod lobe;
mod photons;
mod tree;

use crate::transport::lights::LightRegion;
use crate::transport::methods::settings::Settings;
use crate::transport::scene::View;

pub(super) use events::Events;
pub(super) use images::Images;
pub(super) use photons::Photons;

/// Directions and film points for light that only chance meets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Guide {
    pub(super) photons: Photons,
    pub(super) images: Images,
}

impl Guide {
    /// For a render, and the rays that it took; empty if the scene has no paths that only chance meets.
    pub(crate) fn new(view: &View, settings: &Settings, lights: &LightRegion) -> (Self, u64) {
        if !view.scene.needs().met_by_chance {
            return (Self::default(), 0);
        }
        let (photons, of_photons) = Photons::new(view, settings, lights);
        let (images, of_images) = Images::new(view, settings, lights, &photons);
        (Self { photons, images }, of_photons + of_images)
    }
}
