//! Surfaces that lie in one plane, one upon the other: which of them is there.
//!
//! Where two triangles are nearer to each other than the error of a point, rounding decides which of them a ray meets first,
//! and a connection that ends on one of them does not see the other. One rule takes its place, for camera rays, scattered rays
//! and the ends of connections alike. Of the triangles at a point, seen from one side, the one that is there
//!
//! 1. emits to that side; else it is opaque and no light; else it is the back of a light; else it lets light through;
//! 2. among equals, belongs to the mesh with the smallest area: what is small lies upon what is large;
//! 3. among equals, comes first.
//!
//! So a lamp in the plane of a ceiling shines, a rug on a floor is seen, two lamps back to back shine to both sides, and of a
//! lamp that is there twice one shines. Triangles of one material that emits nothing need no rule: either will do.
//!
//! Light that crosses such a place passes the surfaces of both of its sides, where these are two: `scene/veil.rs`.
//!
//! A triangle that is there on both of its sides needs no rule either. The others are [`shared`](Primitive::shared); only hits
//! of those cost anything.

mod search;
#[cfg(test)]
mod tests;

use super::material::Material;
use super::primitive::Primitive;
use glam::{Vec3, Vec3A};
use std::cmp::Reverse;
use std::collections::{BTreeSet, HashMap};

/// Which triangles share their place with others.
#[derive(Debug, Default)]
pub(super) struct Ties {
    /// Of each shared triangle: those at its place, itself included, in the order of points 2 and 3.
    rivals: HashMap<u32, Box<[u32]>>,
    /// Numbers of two meshes, the one that is there first, where a light is hidden or hides another surface.
    overlaps: BTreeSet<[u32; 2]>,
}

/// The triangles of a scene, mesh by mesh.
#[derive(Clone, Copy)]
pub(super) struct Surfaces<'a> {
    pub(super) primitives: &'a [Primitive],
    pub(super) materials: &'a [Material],
}

impl Surfaces<'_> {
    /// How a triangle fares by point 1, seen from `towards`: the largest number is there.
    fn class(&self, primitive: u32, towards: Vec3A) -> u8 {
        let p = &self.primitives[primitive as usize];
        let material = &self.materials[p.material as usize];
        match (p.emits, material.transmits() || material.is_veil()) {
            (true, _) if material.emits_both_sides || Vec3A::from(p.normal).dot(towards) > 0.0 => 3,
            (_, true) => 0,
            (true, false) => 1,
            (false, false) => 2,
        }
    }
}

impl Ties {
    /// Finds the ties, marks the triangles that share their place, and widens the error bounds of all that are tied, so that a
    /// ray that leaves one of them starts beyond the others. `meshes`: the mesh of each triangle.
    pub(super) fn resolve(primitives: &mut [Primitive], materials: &[Material], meshes: &[u32]) -> Self {
        let mut ties = Self::default();
        let found = search::ties(primitives);
        if found.is_empty() {
            return ties;
        }
        let order = precedence(primitives, meshes);
        for (primitive, partners) in found {
            let gap = partners.iter().map(|(_, gap)| *gap).fold(0.0, f32::max);
            let mut rivals: Vec<_> = partners.iter().map(|(partner, _)| *partner).chain([primitive]).collect();
            rivals.sort_unstable_by_key(|&rival| (order[meshes[rival as usize] as usize], rival));
            let surfaces = Surfaces { primitives, materials };
            let shared = ties.contest(surfaces, primitive, &rivals, meshes);
            primitives[primitive as usize].error += gap;
            primitives[primitive as usize].shared = shared;
            if shared {
                ties.rivals.insert(primitive, rivals.into());
            }
        }
        ties
    }

    /// Whether a triangle gives way to one of its rivals on either side; notes where light is concerned.
    fn contest(&mut self, surfaces: Surfaces, primitive: u32, rivals: &[u32], meshes: &[u32]) -> bool {
        let Primitive { normal, emits, .. } = surfaces.primitives[primitive as usize];
        let mut shared = false;
        for side in [Vec3A::from(normal), Vec3A::from(-normal)] {
            let class = |rival: u32| surfaces.class(rival, side);
            let own = class(primitive);
            let before = rivals.iter().take_while(|&&rival| rival != primitive).filter(|&&rival| class(rival) == own);
            for &winner in rivals.iter().filter(|&&rival| class(rival) > own).chain(before) {
                shared = true;
                if own == LIT || (class(winner) == LIT && !emits) {
                    self.overlaps.insert([winner, primitive].map(|p| meshes[p as usize]));
                }
            }
        }
        shared
    }

    /// Of the triangles at a point of a shared triangle, the one that is there, seen from `towards`.
    pub(super) fn winner(&self, surfaces: Surfaces, primitive: u32, position: Vec3A, towards: Vec3A) -> u32 {
        let here = |rival: u32| rival == primitive || surfaces.primitives[rival as usize].weights(position).is_some();
        let rivals = self.rivals.get(&primitive).into_iter().flatten().copied().filter(|&rival| here(rival));
        rivals.min_by_key(|&rival| Reverse(surfaces.class(rival, towards))).unwrap_or(primitive)
    }

    /// Pairs of meshes, by number, of which the first is seen where both are, and a light is one of them.
    pub(super) fn overlaps(&self) -> impl Iterator<Item = [u32; 2]> {
        self.overlaps.iter().copied()
    }
}

/// [`Surfaces::class`] of what emits to the side that it is seen from.
const LIT: u8 = 3;

/// Place of each mesh by point 2.
fn precedence(primitives: &[Primitive], meshes: &[u32]) -> Vec<u32> {
    let count = meshes.last().map_or(0, |&last| last as usize + 1);
    let mut areas = vec![0.0; count];
    for (p, &mesh) in primitives.iter().zip(meshes) {
        let [a, b, c] = p.vertices.map(Vec3::as_dvec3);
        areas[mesh as usize] += (b - a).cross(c - a).length();
    }
    let mut sorted: Vec<u32> = (0..count as u32).collect();
    sorted.sort_by(|&a, &b| areas[a as usize].total_cmp(&areas[b as usize]));
    let mut order = vec![0; count];
    (0..).zip(sorted).for_each(|(place, mesh)| order[mesh as usize] = place);
    order
}
