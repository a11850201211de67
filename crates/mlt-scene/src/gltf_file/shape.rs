//! Where the vertices of a primitive lie: shaped by morph targets, then placed by a node or by the joints of a skin.

use super::accessor::{Reader, Vectors};
use super::graph::place;
use crate::SceneError;
use glam::{DMat3, DMat4, DVec3};
use gltf::{Document, Node, Primitive, Semantic};
use std::{collections::HashMap, rc::Rc};

/// Sets of four joints that a vertex may have.
const JOINT_SETS: u32 = 2;

/// A node's mesh as it stands.
pub(super) struct Standing {
    /// From the mesh's space to the world, where no skin says otherwise.
    pub to_world: DMat4,
    /// From the mesh's space to the world, of each joint of its skin.
    pub joints: Option<Vec<DMat4>>,
    /// Weights of its morph targets.
    pub weights: Vec<f64>,
}

/// The vertices of a primitive.
pub(super) struct Vertices<'a, 's> {
    positions: Rc<Vectors<'a>>,
    normals: Option<Rc<Vectors<'a>>>,
    targets: Vec<Target<'a>>,
    joints: Vec<[Rc<Vectors<'a>>; 2]>,
    standing: &'s Standing,
}

/// Differences that a morph target makes, as far as it counts.
struct Target<'a> {
    weight: f64,
    positions: Option<Rc<Vectors<'a>>>,
    normals: Option<Rc<Vectors<'a>>>,
}

/// The matrices of a skin's joints, given the world transforms of all nodes; `None`, with a warning, if it has none that are usable.
pub(super) fn joints(
    reader: &mut Reader,
    document: &Document,
    node: &Node,
    worlds: &HashMap<usize, DMat4>,
    warnings: &mut Vec<String>,
) -> Result<Option<Vec<DMat4>>, SceneError> {
    let index = document.as_json().nodes[node.index()].skin.map(|skin| skin.value());
    let Some(index) = index else { return Ok(None) };
    let skin = document.as_json().skins.get(index);
    let inverse = skin.and_then(|skin| document.accessors().nth(skin.inverse_bind_matrices?.value()));
    let inverse = inverse.map(|accessor| reader.any_vectors(&accessor)).transpose()?;
    let matrix = |i: usize, joint: usize| -> Option<DMat4> {
        let bound = match &inverse {
            Some(inverse) if inverse.components() == 16 && i < inverse.count() => {
                DMat4::from_cols_array(&inverse.at::<16>(i as u32).map(f64::from))
            }
            Some(_) => return None,
            None => DMat4::IDENTITY,
        };
        Some(*worlds.get(&joint)? * bound)
    };
    let joints = skin.map(|skin| skin.joints.iter().enumerate().map(|(i, joint)| matrix(i, joint.value())).collect());
    let joints: Option<Vec<_>> = joints.flatten().filter(|joints: &Vec<DMat4>| !joints.is_empty());
    if joints.is_none() {
        warnings.push(format!(
            "{}: its skin has joints that are not there; it is left out: export the armature with its mesh",
            place(node)
        ));
    }
    Ok(joints)
}

impl<'a, 's> Vertices<'a, 's> {
    /// Of a primitive with positions; `named` begins a warning.
    pub(super) fn read(
        reader: &mut Reader<'a>,
        primitive: &Primitive,
        positions: Rc<Vectors<'a>>,
        standing: &'s Standing,
        (named, warnings): (&str, &mut Vec<String>),
    ) -> Result<Self, SceneError> {
        let mut normals = primitive.get(&Semantic::Normals).map(|a| reader.vectors(&a)).transpose()?;
        if normals.as_ref().is_some_and(|n| n.count() != positions.count()) {
            warnings.push(format!("{named}: there are not as many normals as positions; they are left out, so faces look flat: export the normals again"));
            normals = None;
        }
        let mut targets = Vec::new();
        for (target, &weight) in primitive.morph_targets().zip(&standing.weights).filter(|(_, weight)| **weight != 0.0)
        {
            let mut read = |accessor: Option<gltf::Accessor>| -> Result<_, SceneError> {
                let found = accessor.map(|accessor| reader.vectors(&accessor)).transpose()?;
                Ok(found.filter(|found| found.count() == positions.count()))
            };
            targets.push(Target { weight, positions: read(target.positions())?, normals: read(target.normals())? });
        }
        let mut joints = Vec::new();
        for set in (0..JOINT_SETS).filter(|_| standing.joints.is_some()) {
            let accessors = primitive.get(&Semantic::Joints(set)).zip(primitive.get(&Semantic::Weights(set)));
            let Some((numbers, weights)) = accessors else { break };
            let both = [reader.any_vectors(&numbers)?, reader.any_vectors(&weights)?];
            if both.iter().any(|found| found.count() != positions.count() || found.components() != 4) {
                warnings.push(format!("{named}: there are not as many joints as positions; they are left out, so the mesh stands at rest: export it again"));
                break;
            }
            joints.push(both);
        }
        Ok(Self { positions, normals, targets, joints, standing })
    }

    /// Number of vertices.
    pub(super) fn count(&self) -> usize {
        self.positions.count()
    }

    /// Whether they have normals.
    pub(super) fn have_normals(&self) -> bool {
        self.normals.is_some()
    }

    /// World position of a vertex.
    pub(super) fn position(&self, i: u32) -> DVec3 {
        self.to_world(i).transform_point3(self.shaped(i, &self.positions, |target| target.positions.as_ref()))
    }

    /// World normal of a vertex that has one, a unit vector or zero.
    pub(super) fn normal(&self, i: u32) -> DVec3 {
        let Some(normals) = &self.normals else { return DVec3::ZERO };
        let linear = self.linear(i);
        let side = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        (side * cofactors(linear) * self.shaped(i, normals, |target| target.normals.as_ref())).normalize_or_zero()
    }

    /// The linear part of what takes a vertex to the world.
    pub(super) fn linear(&self, i: u32) -> DMat3 {
        DMat3::from_mat4(self.to_world(i))
    }

    fn shaped<'t>(
        &'t self,
        i: u32,
        base: &Vectors,
        of: impl Fn(&'t Target<'a>) -> Option<&'t Rc<Vectors<'a>>>,
    ) -> DVec3 {
        let change = |target: &'t Target<'a>| Some(target.weight * vector(of(target)?, i));
        vector(base, i) + self.targets.iter().filter_map(change).sum::<DVec3>()
    }

    /// Σ w_j J_j over the joints of a vertex, w normalised; what takes its node to the world if it has none.
    fn to_world(&self, i: u32) -> DMat4 {
        let (mut sum, mut total) = (DMat4::ZERO, 0.0);
        for [numbers, weights] in &self.joints {
            for (number, weight) in numbers.at::<4>(i).into_iter().zip(weights.at::<4>(i)) {
                let joint = self.standing.joints.as_ref().and_then(|joints| joints.get(number as usize));
                if let (Some(joint), true) = (joint, weight > 0.0) {
                    sum += *joint * f64::from(weight);
                    total += f64::from(weight);
                }
            }
        }
        if total > 0.0 { sum * (1.0 / total) } else { self.standing.to_world }
    }
}

/// The inverse transpose times the determinant: it maps normals, also where the matrix is singular.
fn cofactors(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

fn vector(vectors: &Vectors, i: u32) -> DVec3 {
    DVec3::from_array(vectors.at::<3>(i).map(f64::from))
}
