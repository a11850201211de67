//! Absorption inside of solids.
//!
//! Of light that goes a distance d through a solid the share T = exp(−σ d) is left (Beer–Lambert). An edge of a path lies inside of a solid if it
//! leaves the back of the solid's surface at either of its ends; where both ends say so and disagree, the end towards the eye decides. T is a
//! factor of f alone: no density knows of it.

use super::Scene;
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;

impl Scene {
    /// The part of `light` that solids let pass between a vertex and the next one towards the eye.
    #[inline(always)]
    pub(crate) fn attenuated(&self, light: Rgb, x: &Vertex, y: &Vertex) -> Rgb {
        if self.needs.absorbs { light * self.attenuation(*x, *y) } else { light }
    }

    /// T of that edge.
    #[inline(never)]
    fn attenuation(&self, x: Vertex, y: Vertex) -> Rgb {
        if x.is_distant() || y.is_distant() || y.is_parallel() {
            return Rgb::ONE;
        }
        let (x, y) = (&x, &y.opposite(&x));
        let step = x.position - y.position;
        let inside = |end: &Vertex, sign: f32| {
            let leaves_back = !end.is_camera() && sign * end.geometric_normal.dot(step) < 0.0;
            Some(self.material(end).absorption).filter(|&sigma| leaves_back && sigma != Rgb::ZERO)
        };
        let Some(sigma) = inside(y, 1.0).or_else(|| inside(x, -1.0)) else { return Rgb::ONE };
        let distance = step.length();
        Rgb::from_array(sigma.to_array().map(|sigma| libm::expf(-sigma * distance)))
    }
}
