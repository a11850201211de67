//! All lights of a scene.

use super::light::{Environment, Light, LightPoint, PunctualLight, Surroundings};
use super::material::Material;
use super::textures::{Attributes, Texture};
use crate::transport::geometry::{LIGHT, Mesh, Space, Sphere, hilbert};
use glam::{DVec3, Vec3, Vec3A};
use rayon::prelude::*;

/// No light, in the table of primitives.
const NONE: u32 = u32::MAX;

/// The lights, and which triangle belongs to which.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// In the order of the meshes; a mesh's parallelograms first, then the rest of it as one light. Those without a surface come last.
    pub lights: Vec<Light>,
    /// Of each triangle: its light and its number within that light.
    of_primitive: Vec<(u32, u32)>,
    /// Those that are met where no surface is: the suns, and after them the environment.
    distant: Vec<u32>,
}

impl Lights {
    /// Finds the lights among `meshes`. `primitives` holds, mesh by mesh, the triangles as the scene keeps them.
    pub(crate) fn new(meshes: &[Mesh], materials: &[Material], textures: &[Texture], primitives: &[[Vec3; 3]]) -> Self {
        let mut lights =
            Self { lights: Vec::new(), of_primitive: vec![(NONE, 0); primitives.len()], distant: Vec::new() };
        let mut first = 0;
        for mesh in meshes {
            let material = &materials[mesh.material as usize];
            if material.emission.max_element() > 0.0 {
                let part = EmittingMesh { mesh, material, first, primitives };
                if material.shines_unevenly() {
                    lights.add_uneven(part, textures);
                } else {
                    lights.add_even(part);
                }
            }
            first += mesh.triangles.len();
        }
        lights
    }

    /// With an environment around the scene.
    pub(crate) fn surrounded(mut self, environment: Environment, sphere: Sphere) -> Self {
        self.distant.push(self.lights.len() as u32);
        self.lights.push(Surroundings::light(environment, sphere));
        self
    }

    /// With lights that have no surface, as far as they send any light.
    pub(crate) fn and_punctual(mut self, punctual: &[PunctualLight], space: &Space, sphere: Sphere) -> Self {
        for light in punctual.iter().filter(|light| light.is_lit()) {
            if light.has_extent() {
                self.distant.push(self.lights.len() as u32);
            }
            self.lights.push(light.light(space, sphere));
        }
        self
    }

    /// The lights that are met in a unit direction where no surface is.
    #[inline]
    pub(super) fn in_direction(&self, direction: Vec3A) -> impl Iterator<Item = (u32, &Light)> {
        let distant = self.distant.iter().map(|&light| (light, &self.lights[light as usize]));
        distant.filter(move |(_, light)| light.is_seen_in(direction))
    }

    /// The light of a vertex's primitive.
    #[inline]
    pub fn of(&self, primitive: u32) -> Option<&Light> {
        self.lights.get(self.place(primitive).0 as usize)
    }

    /// The light of a vertex's primitive, if that emits, and its number within it.
    #[inline]
    pub(crate) fn number(&self, primitive: u32) -> Option<(u32, u32)> {
        let number = self.place(primitive);
        (number.0 != NONE).then_some(number)
    }

    /// The light point at `position` of a primitive that emits.
    pub fn point(&self, primitive: u32, position: Vec3A) -> Option<LightPoint> {
        let (light, index) = self.place(primitive);
        let (u, v) = self.lights.get(light as usize)?.coordinates(index, position.into());
        Some(LightPoint { light, u, v })
    }

    #[inline]
    fn place(&self, primitive: u32) -> (u32, u32) {
        // A light without a surface is all that has no triangle, but for copies, which do not emit.
        let without_surface = || (primitive.checked_sub(LIGHT).unwrap_or(NONE), 0);
        self.of_primitive.get(primitive as usize).copied().unwrap_or_else(without_surface)
    }

    /// Σ power.
    pub fn power(&self) -> f64 {
        self.lights.iter().map(Light::power).sum()
    }

    fn add_even(&mut self, part: EmittingMesh) {
        let EmittingMesh { mesh, material, first, primitives } = part;
        let mut rest = Vec::new();
        for component in components(mesh) {
            let [a, b] = component[..] else {
                rest.extend(component);
                continue;
            };
            match parallelogram(primitives[first + a], primitives[first + b]) {
                Some((origin, edges)) => {
                    let both = [first + a, first + b];
                    self.push(Light::parallelogram(origin, edges, both.map(|p| p as u32)), material, &both);
                }
                None => rest.extend([a, b]),
            }
        }
        let list = part.compact(rest);
        if let Some(light) = Light::triangles(list.iter().map(|&p| (p as u32, primitives[p]))) {
            self.push(light, material, &list);
        }
    }

    fn add_uneven(&mut self, part: EmittingMesh, textures: &[Texture]) {
        let EmittingMesh { mesh, material, first, primitives } = part;
        let list = part.compact((0..mesh.triangles.len()).collect());
        let glow = |i: usize, weights: [f32; 2]| {
            let place = Attributes::on(mesh, mesh.triangles[list[i] - first], weights);
            material.emission_at(textures, &place) * material.opacity_at(textures, &place)
        };
        let triangles = list.iter().map(|&p| (p as u32, primitives[p])).collect();
        if let Some(light) = Light::uneven(triangles, material.emission, glow) {
            self.add_numbers(&list);
            let emission = light.emission;
            self.lights.push(light.shining(material, emission, 1.0));
        }
    }

    fn push(&mut self, light: Light, material: &Material, primitives: &[usize]) {
        self.add_numbers(primitives);
        self.lights.push(light.shining(material, material.emission, material.opacity));
    }

    /// Gives the next light these triangles.
    fn add_numbers(&mut self, primitives: &[usize]) {
        let id = self.lights.len() as u32;
        for (index, &p) in (0..).zip(primitives) {
            self.of_primitive[p] = (id, index);
        }
    }
}

/// A mesh that emits, and its triangles among all of the scene, of which `first` is its first one.
struct EmittingMesh<'a> {
    mesh: &'a Mesh,
    material: &'a Material,
    first: usize,
    primitives: &'a [[Vec3; 3]],
}

impl EmittingMesh<'_> {
    /// Numbers in the scene of some of its triangles, those that have an area, in an order in which any interval is a compact patch.
    fn compact(&self, mut triangles: Vec<usize>) -> Vec<usize> {
        let corners = |i: &usize| self.primitives[self.first + i];
        triangles.retain(|i| {
            let [a, b, c] = corners(i);
            (b - a).cross(c - a).length() > 0.0
        });
        triangles.sort_unstable();
        let centres: Vec<_> = triangles.iter().map(|i| corners(i).iter().sum::<Vec3>() / 3.0).collect();
        hilbert::order(&centres).into_iter().map(|i| self.first + triangles[i as usize]).collect()
    }
}

/// Groups of triangles that share a corner's position, in the order of their first triangles.
fn components(mesh: &Mesh) -> Vec<Vec<usize>> {
    let key = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let corners = mesh.triangles.iter().enumerate().flat_map(|(i, t)| t.map(|c| (i, c)));
    let mut corners: Vec<_> = corners.map(|(i, c)| (key(mesh.positions[c as usize]), i)).collect();
    corners.par_sort_unstable();
    let mut parent: Vec<usize> = (0..mesh.triangles.len()).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    for pair in corners.windows(2) {
        if pair[0].0 == pair[1].0 {
            let (a, b) = (root(&mut parent, pair[0].1), root(&mut parent, pair[1].1));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); parent.len()];
    for i in 0..parent.len() {
        groups[root(&mut parent, i)].push(i);
    }
    groups.retain(|g| !g.is_empty());
    groups
}

/// Corner and edges of the parallelogram that two triangles form, oriented as they are.
fn parallelogram(a: [Vec3; 3], b: [Vec3; 3]) -> Option<(Vec3, [Vec3; 2])> {
    let shared = |p: &Vec3, other: &[Vec3; 3]| other.contains(p);
    let i = (0..3).find(|&i| !shared(&a[i], &b))?;
    let fourth = b.iter().find(|p| !shared(p, &a))?;
    let (origin, p, q) = (a[i], a[(i + 1) % 3], a[(i + 2) % 3]);
    if !(shared(&p, &b) && shared(&q, &b)) {
        return None;
    }
    let edges = [p - origin, q - origin];
    let size = edges[0].length() + edges[1].length();
    let same_side = (b[1] - b[0]).cross(b[2] - b[0]).dot(edges[0].cross(edges[1])) > 0.0;
    let closes = (origin + edges[0] + edges[1]).distance(*fourth) < 1e-5 * size;
    (same_side && closes).then_some((origin, edges))
}
