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
use mlt_core::transport::{Rgb, bsdf::Bsdf, description::SceneDescription, material::Material, mesh::Mesh};
use std::collections::HashMap;

/// The share of a piece's area that must be opposed, or must not be, for its normals to agree with each other.
const AGREEMENT: f64 = 0.9;

/// Turns the triangles of glass and of lights that face away from their own normals.
pub(crate) fn follow_normals(scene: &mut SceneDescription, warnings: &mut Vec<String>) {
    for mesh in &mut scene.meshes {
        if has_outside(&scene.materials[mesh.material as usize]) {
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
