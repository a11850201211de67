//! Which side of a surface is its outside, where a file's normals and its winding do not agree.
//!
//! The renderer takes the outside of glass and the front of lights from the order of a triangle's corners. Some programs
//! write that order the wrong way round beside normals that are right, which no rasteriser shows.
//!
//! A triangle is *opposed* if all three normals at its corners point to the back of its winding. Shading normals lean, at
//! silhouettes and folds by much, but all three corners of a triangle point backwards only by mistake: of the winding, or, on
//! few triangles of a coarse mesh, of the normals. To tell them apart, triangles that share edges are judged as one piece:
//!
//! * where neighbours run through their common edges in opposite directions, the winding is right or wrong for the whole
//!   piece. The piece is turned if nearly all of its area is opposed; where the normals contradict each other, it stays;
//! * where they do not, the winding says nothing of the outside, and each opposed triangle is turned by itself.

use glam::DVec3;
use mlt_core::transport::Rgb;
use mlt_core::transport::bsdf::Bsdf;
use mlt_core::transport::geometry::Mesh;
use mlt_core::transport::scene::{Material, SceneDescription};
use std::collections::HashMap;

/// The share of a piece's area that must be opposed, or must not be, for its normals to agree with each other.
const AGREEMENT: f64 = 0.9;

/// Turns the triangles of glass and of lights that face away from their own normals.
pub(crate) fn follow_normals(scene: &mut SceneDescription, warnings: &mut Vec<String>) {
    let SceneDescription { meshes, prototypes, materials, .. } = scene;
    for mesh in meshes.iter_mut().chain(prototypes.iter_mut().flat_map(|prototype| &mut prototype.meshes)) {
        if has_outside(&materials[mesh.material as usize]) {
            turn(mesh, warnings);
        }
    }
}

/// Whether a material's two sides differ.
fn has_outside(material: &Material) -> bool {
    let emits = material.emission != Rgb::ZERO && !material.emits_both_sides;
    emits
        || !matches!(
            material.bsdf,
            Bsdf::Black
                | Bsdf::Lambert(_)
                | Bsdf::Mirror(_)
                | Bsdf::Conductor(_)
                | Bsdf::Glossy(_)
                | Bsdf::Thin(_)
                | Bsdf::RoughThin(_)
        )
}

fn turn(mesh: &mut Mesh, warnings: &mut Vec<String>) {
    if mesh.normals.is_empty() {
        return;
    }
    let facings: Vec<_> = mesh.triangles.iter().map(|t| facing(mesh, t)).collect();
    let opposed = facings.iter().filter(|&&facing| facing < 0.0).count();
    if opposed == 0 {
        return;
    }
    let (pieces, piece_of) = Piece::all(mesh, &facings);
    for (triangle, facing) in facings.iter().enumerate() {
        if pieces[piece_of[triangle] as usize].turns(*facing) {
            mesh.triangles[triangle].swap(1, 2);
        }
    }
    let (name, all) = (&mesh.name, mesh.triangles.len());
    let doubtful = pieces.iter().any(Piece::is_doubtful);
    warnings.push(match doubtful {
        false => format!(
            "mesh `{name}`: the normals of {opposed} of its {all} triangles oppose their winding; \
             the normals decide which side is the outside"
        ),
        true => format!(
            "mesh `{name}`: the normals of {opposed} of its {all} triangles oppose their winding and others do not; \
             where they contradict each other the winding decides which side is the outside"
        ),
    });
}

/// Twice the area of a triangle that faces the way its normals point; negative if it is opposed, 0 if they are at odds.
fn facing(mesh: &Mesh, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
    let normal = (b - a).cross(c - a);
    let cosines = triangle.map(|i| normal.dot(mesh.normals[i as usize].as_dvec3()));
    match cosines.map(|cosine| cosine > 0.0) {
        [true, true, true] => normal.length(),
        [false, false, false] if !cosines.contains(&0.0) => -normal.length(),
        _ => 0.0,
    }
}

/// Triangles that hang together by their edges.
#[derive(Clone, Copy, Default)]
struct Piece {
    /// Twice the area that is opposed.
    opposed: f64,
    /// Twice the area that is not.
    agreeing: f64,
    /// Some neighbours run through their common edge in the same direction.
    torn: bool,
}

impl Piece {
    /// The pieces of a mesh, and the piece of each triangle.
    fn all(mesh: &Mesh, facings: &[f64]) -> (Vec<Self>, Vec<u32>) {
        let corners = welded(mesh);
        let mut sets = Sets::new(mesh.triangles.len());
        let mut torn = Vec::new();
        // An edge's first triangle, and in which directions triangles run through it.
        let mut edges: HashMap<[u32; 2], (u32, [bool; 2])> = HashMap::new();
        for (triangle, t) in mesh.triangles.iter().enumerate() {
            for [from, to] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|edge| edge.map(|i| corners[i as usize])) {
                let direction = usize::from(from > to);
                let edge = edges.entry([from.min(to), from.max(to)]).or_insert((triangle as u32, [false; 2]));
                sets.join(edge.0, triangle as u32);
                if std::mem::replace(&mut edge.1[direction], true) {
                    torn.push(triangle as u32);
                }
            }
        }
        let piece_of: Vec<_> = (0..facings.len() as u32).map(|t| sets.find(t)).collect();
        let mut pieces = vec![Self::default(); facings.len()];
        for (&piece, &facing) in piece_of.iter().zip(facings) {
            pieces[piece as usize].opposed += (-facing).max(0.0);
            pieces[piece as usize].agreeing += facing.max(0.0);
        }
        torn.iter().for_each(|&t| pieces[piece_of[t as usize] as usize].torn = true);
        (pieces, piece_of)
    }

    /// Whether a triangle of it is turned.
    fn turns(&self, facing: f64) -> bool {
        if self.torn { facing < 0.0 } else { self.opposed > AGREEMENT * (self.opposed + self.agreeing) }
    }

    /// Whether its winding is of a piece and its normals are not.
    fn is_doubtful(&self) -> bool {
        let all = self.opposed + self.agreeing;
        !self.torn && self.opposed.max(self.agreeing) <= AGREEMENT * all && all > 0.0
    }
}

/// For each vertex the first one in the same place.
fn welded(mesh: &Mesh) -> Vec<u32> {
    let mut first = HashMap::new();
    // Adding zero makes −0 a +0.
    let bits = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
    mesh.positions.iter().enumerate().map(|(i, p)| *first.entry(bits(p)).or_insert(i as u32)).collect()
}

/// Disjoint sets of numbers, each found by its smallest-ranked member (union by index, paths halved).
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn find(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let parent = self.0[i as usize];
            self.0[i as usize] = self.0[parent as usize];
            i = parent;
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use mlt_core::transport::bsdf::{Dielectric, Lambert};

    /// A unit ball about `centre` with its own vertices at each triangle, counter-clockwise from outside.
    fn ball(centre: DVec3) -> Mesh {
        const RINGS: u32 = 8;
        let point = |ring: u32, spoke: u32| {
            let (polar, azimuth) =
                (f64::from(ring) / f64::from(RINGS), f64::from(spoke % (2 * RINGS)) / f64::from(RINGS));
            let (polar, azimuth) = (polar * std::f64::consts::PI, azimuth * std::f64::consts::PI);
            DVec3::new(polar.sin() * azimuth.cos(), polar.cos(), -polar.sin() * azimuth.sin())
        };
        let mut mesh = Mesh { name: "ball".to_owned(), ..Mesh::default() };
        for (ring, spoke) in (0..RINGS).flat_map(|ring| (0..2 * RINGS).map(move |spoke| (ring, spoke))) {
            let [a, b] = [point(ring, spoke), point(ring, spoke + 1)];
            let [c, d] = [point(ring + 1, spoke), point(ring + 1, spoke + 1)];
            let halves = [(ring > 0, [a, c, b]), (ring < RINGS - 1, [b, c, d])];
            for corners in halves.into_iter().filter(|half| half.0).map(|half| half.1) {
                let first = mesh.positions.len() as u32;
                mesh.triangles.push([first, first + 1, first + 2]);
                mesh.positions.extend(corners.map(|p| centre + p));
                mesh.normals.extend(corners.map(DVec3::as_vec3));
            }
        }
        mesh
    }

    fn swap(mesh: &mut Mesh, which: impl Fn(usize) -> bool) {
        let triangles = mesh.triangles.iter_mut().enumerate();
        triangles.filter(|(i, _)| which(*i)).for_each(|(_, t)| t.swap(1, 2));
    }

    fn together(a: Mesh, b: Mesh) -> Mesh {
        let first = a.positions.len() as u32;
        Mesh {
            positions: [a.positions, b.positions].concat(),
            normals: [a.normals, b.normals].concat(),
            triangles: [a.triangles, b.triangles.iter().map(|t| t.map(|i| i + first)).collect()].concat(),
            ..a
        }
    }

    /// Triangles that face inwards of the balls about the origin and (5, 0, 0), and the warnings, of a mesh of glass.
    fn inwards(mesh: Mesh) -> (usize, Vec<String>) {
        let glass = Bsdf::Dielectric(Dielectric { ior: 1.5, tint: Rgb::ONE });
        let material = Material { bsdf: glass, ..Material::default() };
        let mut scene =
            SceneDescription { meshes: vec![mesh], materials: vec![material], ..SceneDescription::default() };
        let mut warnings = Vec::new();
        follow_normals(&mut scene, &mut warnings);
        let mesh = &scene.meshes[0];
        let is_inwards = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let centre = if a.x > 2.5 { DVec3::new(5.0, 0.0, 0.0) } else { DVec3::ZERO };
            (b - a).cross(c - a).dot(a + b + c - 3.0 * centre) < 0.0
        };
        (mesh.triangles.iter().filter(is_inwards).count(), warnings)
    }

    #[test]
    fn a_right_ball_stays_as_it_is() {
        assert_eq!(inwards(ball(DVec3::ZERO)), (0, vec![]));
        let mut flat = ball(DVec3::ZERO);
        swap(&mut flat, |_| true);
        flat.normals.clear();
        assert_eq!(inwards(flat), (224, vec![]), "without normals the winding decides");
    }

    #[test]
    fn opposed_triangles_are_turned_all_or_some() {
        for opposed in [|_| true, |i| i % 2 == 0, |i| i % 7 == 0, |i| i > 100] as [fn(usize) -> bool; 4] {
            let mut mesh = ball(DVec3::ZERO);
            swap(&mut mesh, opposed);
            let (left, warnings) = inwards(mesh);
            let count = (0..224).filter(|&i| opposed(i)).count();
            assert_eq!(left, 0);
            assert!(
                warnings.len() == 1 && warnings[0].contains(&format!("{count} of its 224 triangles")),
                "{warnings:?}"
            );
        }
    }

    #[test]
    fn each_piece_of_a_mesh_is_judged_by_itself() {
        let (mut opposed, right) = (ball(DVec3::ZERO), ball(DVec3::new(5.0, 0.0, 0.0)));
        swap(&mut opposed, |_| true);
        assert_eq!(inwards(together(opposed, right)).0, 0);
    }

    /// Turning single triangles of a surface that is wound as one would make holes in it.
    #[test]
    fn normals_that_contradict_each_other_turn_nothing() {
        for (every, doubtful) in [(20, false), (2, true)] {
            let mut mesh = ball(DVec3::ZERO);
            let wrong: Vec<_> = mesh.triangles.iter().step_by(every).copied().collect();
            wrong.iter().flatten().for_each(|&i| mesh.normals[i as usize] = -mesh.normals[i as usize]);
            let (left, warnings) = inwards(mesh);
            assert_eq!(left, 0);
            assert_eq!(
                warnings[0].contains("where they contradict each other the winding decides"),
                doubtful,
                "{warnings:?}"
            );
        }
    }

    #[test]
    fn only_what_has_an_outside_is_turned() {
        let material = |emission, emits_both_sides| Material {
            bsdf: Bsdf::Lambert(Lambert { reflectance: Rgb::ONE }),
            emission,
            emits_both_sides,
            ..Material::default()
        };
        for (material, turned) in
            [(material(Rgb::ZERO, false), false), (material(Rgb::ONE, true), false), (material(Rgb::ONE, false), true)]
        {
            let mut mesh = Mesh {
                positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
                normals: vec![Vec3::NEG_Z; 3],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            };
            mesh.name = "lamp".to_owned();
            let mut scene =
                SceneDescription { meshes: vec![mesh], materials: vec![material], ..SceneDescription::default() };
            let mut warnings = Vec::new();
            follow_normals(&mut scene, &mut warnings);
            assert_eq!((scene.meshes[0].triangles[0] == [0, 2, 1], !warnings.is_empty()), (turned, turned));
        }
    }
}
