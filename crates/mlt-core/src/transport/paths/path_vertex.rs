//! Vertices of a path with the densities of every way of making them.

use super::edge::Edge;
use crate::transport::bsdf::Evaluation;
use crate::transport::colour::Rgb;
use crate::transport::geometry::Vertex;
use crate::transport::scene::{Resolved, View};
use glam::Vec3A;
use std::sync::atomic::{Ordering, compiler_fence};

/// A vertex x_i of a path with what depends on it and its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct PathVertex {
    /// Where it is.
    pub vertex: Vertex,
    /// Unit direction to x_{i+1}, the next vertex towards the camera.
    pub to_eye: Vec3A,
    /// τ/|x_{i+1} − x_i|², τ what surfaces that are not opaque let pass.
    pub inverse_square: f32,
    /// |cosθ| of the edge to x_{i+1}, at x_i and at x_{i+1}, to the geometric normals.
    pub cosines: [f32; 2],
    /// G(x_i, x_{i+1}) τ = |cosθ_i cosθ_{i+1}| τ / |x_i − x_{i+1}|², geometric normals.
    pub geometric_term: f64,
    /// x_0: emitted radiance; x_k: W_e; between them f_s(x_{i−1} → x_i → x_{i+1}) |ω·N_s|/|ω·N_g|, ω towards x_{i−1};
    /// the latter two times what solids leave of light from x_{i−1}.
    pub scatter: Rgb,
    /// Density per area of x_i, drawn from x_{i−1}; of x_0, in its light's measure: M, to be divided by the power of the region it is
    /// drawn from.
    pub forward: f64,
    /// Density per area of x_i, drawn from x_{i+1}, of a distant x_0 per solid angle; of x_k: 1.
    pub reverse: f64,
}

impl PathVertex {
    /// A vertex whose neighbours are not known yet.
    pub fn new(vertex: Vertex) -> Self {
        Self {
            vertex,
            to_eye: Vec3A::ZERO,
            inverse_square: 0.0,
            cosines: [0.0; 2],
            geometric_term: 0.0,
            scatter: Rgb::ZERO,
            forward: 0.0,
            reverse: 0.0,
        }
    }

    /// A density per solid angle along the edge to x_{i+1} as a density per area at x_i.
    #[inline]
    pub(crate) fn per_area_here(&self, pdf: f32) -> f64 {
        f64::from(pdf) * f64::from(self.cosines[0]) * f64::from(self.inverse_square)
    }

    /// The same as a density per area at x_{i+1}.
    #[inline]
    pub(crate) fn per_area_there(&self, pdf: f32) -> f64 {
        f64::from(pdf) * f64::from(self.cosines[1]) * f64::from(self.inverse_square)
    }
}

/// x_i's factor in g.
#[inline]
pub(crate) fn reference(vertices: &[PathVertex], i: usize) -> f64 {
    if i == 0 { 1.0 } else { vertices[i].reverse }
}

/// Whether x_{s−1} and x_s may be connected; for s = 0, whether x_0 may be met by chance.
#[inline(always)]
pub(crate) fn connectible(vertices: &[PathVertex], s: usize) -> bool {
    if s == 0 {
        return vertices[0].vertex.can_be_met();
    }
    !(vertices[s - 1].vertex.delta || vertices[s].vertex.delta)
}

/// Copies a few vertices. One after the other: what the branches of a general copy do, whose length varies, is hard to foresee.
#[inline(always)]
pub(crate) fn copy_vertices(to: &mut [PathVertex], from: &[PathVertex]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
        // No instruction; it keeps the compiler from calling that copy.
        compiler_fence(Ordering::SeqCst);
    }
}

/// Sets the edge from x_i to x_{i+1}.
#[inline(always)]
pub(crate) fn set_edge(x: &mut PathVertex, edge: Edge) {
    x.geometric_term = edge.geometric_term();
    Edge { direction: x.to_eye, inverse_square: x.inverse_square, cosines: x.cosines } = edge;
}

/// Sets the scattering at x_i, whose edges are set, and the densities of its two neighbours, drawn from it.
/// `None` if it scatters nothing.
#[inline(always)]
pub(crate) fn set_scattering(vertices: &mut [PathVertex], i: usize, view: &View) -> Option<()> {
    if i == 0 {
        set_emission(vertices, view)
    } else if i + 1 == vertices.len() {
        set_sensitivity(vertices, view)
    } else {
        set_reflection(vertices, i, view)
    }
}

/// x_0, on a light: L_e, M, and the density of x_1.
#[inline(always)]
pub(super) fn set_emission(vertices: &mut [PathVertex], view: &View) -> Option<()> {
    let [x, to_eye, ..] = vertices else { return None };
    let found = emission(view, &x.vertex, x.to_eye)?;
    x.scatter = found.value;
    let light = view.scene.lights().of(x.vertex.primitive)?;
    x.forward = light.mean_exitance() * view.scene.relative_exitance(light, &x.vertex, found.value);
    to_eye.forward = x.per_area_there(found.pdf_to_eye);
    Some(())
}

/// x_i, a surface between two others: f_s, and the densities of both neighbours.
#[inline(always)]
pub(super) fn set_reflection(vertices: &mut [PathVertex], i: usize, view: &View) -> Option<()> {
    let [to_light, x, to_eye] = vertices.get_mut(i - 1..i + 2)? else { return None };
    let found = scattering(view, &x.vertex, -to_light.to_eye, x.to_eye)?;
    x.scatter = view.scene.attenuated(found.value, &to_light.vertex, &x.vertex);
    to_eye.forward = x.per_area_there(found.pdf_to_eye);
    to_light.reverse = to_light.per_area_here(found.pdf_to_light);
    Some(())
}

/// x_k, the camera: W_e, and the density of x_{k−1}.
#[inline(always)]
pub(super) fn set_sensitivity(vertices: &mut [PathVertex], view: &View) -> Option<()> {
    let [.., to_light, x] = vertices else { return None };
    let found = sensitivity(view, &x.vertex, -to_light.to_eye)?;
    x.scatter = view.scene.attenuated(found.value, &to_light.vertex, &x.vertex);
    x.reverse = 1.0;
    to_light.reverse = to_light.per_area_here(found.pdf_to_light);
    Some(())
}

/// Emitted radiance at x_0, and the density, per solid angle, of the direction that a light subpath starts into.
/// `None`: nothing, or in the plane of the light, where rounding puts a direction drawn in some ten million: cosθ = 0 there.
#[inline(always)]
pub(crate) fn emission(view: &View, x: &Vertex, to_eye: Vec3A) -> Option<Evaluation> {
    if !x.emits {
        return None;
    }
    let (value, pdf_to_eye) = (view.scene.emitted(x, to_eye), view.scene.pdf_emission(x, to_eye));
    (value != Rgb::ZERO && pdf_to_eye > 0.0).then_some(Evaluation { value, pdf_to_eye, pdf_to_light: 0.0 })
}

/// f_s and densities at a surface; `None`: nothing.
#[inline(always)]
pub(crate) fn scattering(view: &View, x: &Vertex, to_light: Vec3A, to_eye: Vec3A) -> Option<Evaluation> {
    view.scene.surface(x, &mut Resolved::default()).evaluate(to_light, to_eye)
}

/// W_e, and the density of a direction to the light through a uniform film point; `None` behind the image.
#[inline(always)]
pub(crate) fn sensitivity(view: &View, lens: &Vertex, to_light: Vec3A) -> Option<Evaluation> {
    let camera = view.camera;
    let (value, pdf_to_light) = (Rgb::splat(camera.w_e(to_light)), camera.pdf(to_light));
    (lens.geometric_normal.dot(to_light) > 0.0).then_some(Evaluation { value, pdf_to_eye: 0.0, pdf_to_light })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::lights::LightRegion;
    use crate::transport::tests::worlds::{Builder, quad};
    use glam::DVec3;

    /// Whether a lamp at height 0 that emits upwards, and downwards too or not, emits into a direction.
    fn emits(both_sides: bool, direction: Vec3A) -> bool {
        let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| DVec3::new(x, 0.0, z));
        let lamp = Builder::default().light(quad(corners), Rgb::ONE, both_sides);
        let world = lamp.seen(DVec3::new(0.0, 1.0, 3.0), DVec3::ZERO, 1.0, [4, 4]);
        let view = world.view();
        let point = LightRegion::whole(view.scene.lights()).sample(0.3, 0.6);
        emission(&view, &view.scene.light_point(&point).1, direction).is_some()
    }

    #[test]
    fn a_lamp_emits_nothing_in_its_own_plane() {
        for both_sides in [false, true] {
            assert!(!emits(both_sides, Vec3A::X), "in the plane");
            assert!(emits(both_sides, Vec3A::Y), "upwards");
            assert_eq!(emits(both_sides, -Vec3A::Y), both_sides, "downwards");
        }
    }
}
