//! Events that perturbations follow: reflections and refractions at specular vertices, and at microfacets of narrow lobes.

use super::log_uniform::LogUniform;
use crate::transport::bsdf::{Microfacet, NarrowLobe};
use crate::transport::paths::LightPath;
use crate::transport::scene::{Resolved, View};
use rand_pcg::rand_core::Rng;
use std::ops::Range;

/// Least and largest step of a microfacet's slope, in widths of its lobe.
const STEP: LogUniform = LogUniform::new(1e-2, 1.0);

/// Whether x_i is one whose event is followed: a specular one, or one whose neighbours a microfacet of a narrow lobe joins.
#[inline(always)]
pub(super) fn is_followed(view: &View, path: &LightPath, i: usize) -> bool {
    path.vertices[i].vertex.delta || (view.scene.needs().narrow && microfacet(view, path, i).is_some())
}

/// Whether the vertices of two paths are followed, or not, alike: a perturbation leads back only then.
#[inline(always)]
pub(super) fn same_events(view: &View, [x, y]: [&LightPath; 2], changed: Range<usize>) -> bool {
    !view.scene.needs().narrow || changed.into_iter().all(|i| is_followed(view, x, i) == is_followed(view, y, i))
}

/// The narrow lobe at x_i, and its microfacet that joins x_{i−1} and x_{i+1}; `None`: there is none, or x_i is a light.
#[inline(never)]
pub(super) fn microfacet(view: &View, path: &LightPath, i: usize) -> Option<(NarrowLobe, Microfacet)> {
    let to_light = -path.vertices[i.checked_sub(1)?].to_eye;
    let x = &path.vertices[i];
    let lobe = view.scene.surface(&x.vertex, &mut Resolved::default()).narrow_lobe()?;
    Some((lobe, lobe.microfacet(x.vertex.shading_normal, to_light, x.to_eye)?))
}

/// A microfacet with a slope some way from its own. The density of the way back is the same.
pub(super) fn moved(microfacet: Microfacet, rng: &mut impl Rng) -> Option<Microfacet> {
    let (distance, towards) = STEP.draw(rng);
    microfacet.with_slope(microfacet.slope + distance * towards)
}
