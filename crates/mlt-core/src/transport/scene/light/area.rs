//! Surfaces that emit, each with a map from the unit square in proportion to power.

use super::even::Even;
use super::triangle::weights;
use super::uneven::Uneven;
use super::{Light, Piece, Shape};
use crate::transport::colour::Rgb;
use glam::{DVec2, Vec3};

/// How the unit square lies on the surface.
#[derive(Clone, Debug)]
pub(crate) enum Area {
    /// (u, v) ↦ origin + u·edges[0] + v·edges[1]; on the first of two triangles where u + v ≤ 1.
    Parallelogram { origin: Vec3, edges: [Vec3; 2], primitives: [u32; 2] },
    /// u runs through the triangles in proportion to their areas.
    Even(Box<Even>),
    /// u runs through parts of the triangles in proportion to their power.
    Uneven(Box<Uneven>),
}

impl Light {
    pub(crate) fn parallelogram(origin: Vec3, edges: [Vec3; 2], primitives: [u32; 2]) -> Self {
        let area = f64::from(edges[0].cross(edges[1]).length());
        Self::surface(area, Area::Parallelogram { origin, edges, primitives })
    }

    /// A light of triangles; `None` if their area is zero.
    pub(crate) fn triangles(list: impl Iterator<Item = (u32, [Vec3; 3])>) -> Option<Self> {
        let (even, area) = Even::new(list)?;
        Some(Self::surface(area, Area::Even(Box::new(even))))
    }

    /// A light of triangles that emit `glow` at barycentric weights of one of them, radiance times opacity, at most `brightest`; `None`:
    /// they emit nothing. Its opacity is 1.
    pub(crate) fn uneven(
        triangles: Vec<(u32, [Vec3; 3])>,
        brightest: Rgb,
        glow: impl Fn(usize, [f32; 2]) -> Rgb + Sync,
    ) -> Option<Self> {
        let (uneven, area, emission) = Uneven::new(triangles, brightest, glow)?;
        Some(Self::new(Shape::Area(Area::Uneven(Box::new(uneven))), area, emission))
    }

    fn surface(area: f64, shape: Area) -> Self {
        Self::new(Shape::Area(shape), area, Rgb::ZERO)
    }
}

impl Area {
    /// Its parallelogram, or those of its triangles, as far as they lie between two corners of the unit square, in the order
    /// of their numbers; and the first one's number.
    pub(super) fn pieces(&self, low: DVec2, high: DVec2) -> (u32, Vec<Piece>) {
        match self {
            &Self::Parallelogram { origin, edges: [e, f], .. } => {
                let at = |u: f64, v: f64| origin + u as f32 * e + v as f32 * f;
                let corners = [at(low.x, low.y), at(high.x, low.y), at(low.x, high.y), at(high.x, high.y)];
                (0, vec![Piece::new([low, high], &corners)])
            }
            Self::Even(even) => even.pieces(low, high),
            Self::Uneven(uneven) => uneven.pieces(low, high),
        }
    }

    /// Lengths of the sides of the unit square; a mesh has one.
    pub(super) fn sides(&self) -> DVec2 {
        match self {
            Self::Parallelogram { edges, .. } => DVec2::from_array(edges.map(|e| f64::from(e.length()))),
            Self::Even(_) | Self::Uneven(_) => DVec2::X,
        }
    }

    /// Columns and rows of as many cells as a rectangle is to have; a mesh is cut along u alone, which runs through its
    /// triangles.
    pub(super) fn grid(&self, size: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Parallelogram { .. } => size,
            Self::Even(_) | Self::Uneven(_) => [size[0] * size[1], 1],
        }
    }

    /// Its centre of mass.
    pub(super) fn centre(&self) -> Vec3 {
        match self {
            Self::Parallelogram { origin, edges: [e, f], .. } => *origin + 0.5 * (*e + *f),
            Self::Even(even) => even.centre(),
            Self::Uneven(uneven) => uneven.centre(),
        }
    }

    /// Triangle and position at coordinates (u, v).
    #[inline(always)]
    pub(crate) fn at(&self, u: f64, v: f64) -> (u32, Vec3) {
        match self {
            Self::Parallelogram { origin, edges, primitives } => {
                (primitives[usize::from(u + v > 1.0)], *origin + u as f32 * edges[0] + v as f32 * edges[1])
            }
            Self::Even(even) => even.at(u, v),
            Self::Uneven(uneven) => uneven.at(u, v),
        }
    }

    /// Coordinates of the point nearest to `position` on the light's triangle number `index` (in the order given).
    pub(super) fn coordinates(&self, index: u32, position: Vec3) -> (f64, f64) {
        match self {
            Self::Parallelogram { origin, edges: [e, f], .. } => weights(position - *origin, *e, *f),
            Self::Even(even) => even.coordinates(index, position),
            Self::Uneven(uneven) => uneven.coordinates(index, position),
        }
    }
}
