//! Where animations put nodes, and how they shape meshes, at one time.
//!
//! Of several channels that move the same, the first counts. A time outside of a channel's keys is its nearest key.

use super::accessor::{Reader, Vectors};
use super::rotation::rotation;
use crate::SceneError;
use glam::{DMat4, DQuat, DVec3};
use gltf::{
    Document, Node,
    animation::{Interpolation, Property},
    json::{animation::Sampler, validation::Checked},
    scene::Transform,
};
use std::{collections::HashMap, rc::Rc};

/// Properties of nodes that animations set.
#[derive(Default)]
pub(super) struct Pose {
    transforms: HashMap<usize, Moved>,
    weights: HashMap<usize, Vec<f64>>,
}

/// Parts of a node's transform.
#[derive(Clone, Copy, Default)]
struct Moved {
    translation: Option<DVec3>,
    rotation: Option<DQuat>,
    scale: Option<DVec3>,
}

/// Elements of a channel, and where among its keys the time lies.
struct Track<'a> {
    values: Rc<Vectors<'a>>,
    /// Numbers in a value.
    size: usize,
    interpolation: Interpolation,
    /// Key before the time, way from it to the next, 0…1, and seconds between them.
    key: usize,
    way: f64,
    seconds: f64,
}

impl Pose {
    /// At a time, in seconds.
    pub(super) fn at(
        reader: &mut Reader,
        document: &Document,
        time: f64,
        warnings: &mut Vec<String>,
    ) -> Result<Self, SceneError> {
        let (mut pose, mut unusable) = (Self::default(), 0);
        for animation in &document.as_json().animations {
            for channel in &animation.channels {
                let (node, Checked::Valid(property)) = (channel.target.node.value(), channel.target.path) else {
                    unusable += 1;
                    continue;
                };
                let sampler = animation.samplers.get(channel.sampler.value());
                let track = sampler.map(|sampler| Track::read(reader, document, sampler, property, time));
                match track.transpose()?.flatten() {
                    Some(track) if node < document.nodes().len() => pose.set(node, property, &track),
                    _ => unusable += 1,
                }
            }
        }
        if unusable > 0 {
            warnings.push(format!("{unusable} channels of animations cannot be used; what they move stays at rest: bake the animation before the export"));
        }
        Ok(pose)
    }

    fn set(&mut self, node: usize, property: Property, track: &Track) {
        let vector = || {
            let v = track.value();
            DVec3::new(v[0], v[1], v[2])
        };
        let moved = self.transforms.entry(node).or_default();
        match property {
            Property::Translation => _ = moved.translation.get_or_insert_with(vector),
            Property::Scale => _ = moved.scale.get_or_insert_with(vector),
            Property::Rotation => _ = moved.rotation.get_or_insert_with(|| track.rotation()),
            Property::MorphTargetWeights => _ = self.weights.entry(node).or_insert_with(|| track.value()),
        }
    }

    /// A node's transform to its parent's space.
    pub(super) fn local(&self, node: &Node) -> DMat4 {
        let moved = self.transforms.get(&node.index()).copied().unwrap_or_default();
        match node.transform() {
            Transform::Matrix { matrix } => DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))),
            Transform::Decomposed { translation, rotation: turned, scale } => {
                let [translation, scale] = [translation, scale].map(|v| DVec3::from_array(v.map(f64::from)));
                DMat4::from_scale_rotation_translation(
                    moved.scale.unwrap_or(scale),
                    moved.rotation.unwrap_or_else(|| rotation(turned)),
                    moved.translation.unwrap_or(translation),
                )
            }
        }
    }

    /// Weights of the morph targets of a node's mesh; those at rest are the node's, or the mesh's.
    pub(super) fn weights(&self, node: &Node) -> Vec<f64> {
        let rest = || {
            let own = node.weights().or_else(|| node.mesh()?.weights());
            own.unwrap_or_default().iter().copied().map(f64::from).collect()
        };
        self.weights.get(&node.index()).cloned().unwrap_or_else(rest)
    }
}

impl<'a> Track<'a> {
    /// `None`: the sampler's data are not such as the property has.
    fn read(
        reader: &mut Reader<'a>,
        document: &Document,
        sampler: &Sampler,
        property: Property,
        time: f64,
    ) -> Result<Option<Self>, SceneError> {
        let accessor = |index: usize| document.accessors().nth(index);
        let (Some(input), Some(output)) = (accessor(sampler.input.value()), accessor(sampler.output.value())) else {
            return Ok(None);
        };
        let Checked::Valid(interpolation) = sampler.interpolation else { return Ok(None) };
        let (times, values) = (reader.any_vectors(&input)?, reader.any_vectors(&output)?);
        let each = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let (keys, numbers) = (times.count(), values.count() * values.components());
        let size = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => numbers / (keys * each).max(1),
        };
        let fits = values.components() == if property == Property::MorphTargetWeights { 1 } else { size };
        if keys == 0 || size == 0 || times.components() != 1 || !fits || numbers < keys * each * size {
            return Ok(None);
        }
        let (key, way, seconds) = place(&times, time);
        Ok(Some(Self { values, size, interpolation, key, way, seconds }))
    }

    /// Element number `i` of the sampler's output.
    fn element(&self, i: usize) -> Vec<f64> {
        if self.values.components() == 1 {
            return (0..self.size).map(|k| f64::from(self.values.at::<1>((i * self.size + k) as u32)[0])).collect();
        }
        self.values.at::<4>(i as u32)[..self.size].iter().copied().map(f64::from).collect()
    }

    /// The value at the time, number by number.
    fn value(&self) -> Vec<f64> {
        let (k, t) = (self.key, self.way);
        let mixed = |a: Vec<f64>, b: Vec<f64>, t: f64| a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect();
        match self.interpolation {
            Interpolation::Step => self.element(k),
            Interpolation::Linear if t <= 0.0 => self.element(k),
            Interpolation::Linear => mixed(self.element(k), self.element(k + 1), t),
            // Each key has a slope before it, a value and a slope behind it.
            Interpolation::CubicSpline if t <= 0.0 => self.element(3 * k + 1),
            Interpolation::CubicSpline => {
                let [a, leaving, arriving, b] = [3 * k + 1, 3 * k + 2, 3 * k + 3, 3 * k + 4].map(|i| self.element(i));
                let (square, cube) = (t * t, t * t * t);
                let of = |i: usize| {
                    (2.0 * cube - 3.0 * square + 1.0) * a[i]
                        + self.seconds * (cube - 2.0 * square + t) * leaving[i]
                        + (3.0 * square - 2.0 * cube) * b[i]
                        + self.seconds * (cube - square) * arriving[i]
                };
                (0..self.size).map(of).collect()
            }
        }
    }

    /// The rotation at the time: along the shorter arc where it is linear.
    fn rotation(&self) -> DQuat {
        let unit = |v: Vec<f64>| {
            let q = DQuat::from_xyzw(v[0], v[1], v[2], v[3]);
            if q.length() > 0.0 && q.is_finite() { q / q.length() } else { DQuat::IDENTITY }
        };
        if self.interpolation != Interpolation::Linear || self.way <= 0.0 {
            return unit(self.value());
        }
        let [a, b] = [self.key, self.key + 1].map(|i| unit(self.element(i)));
        let b = if a.dot(b) < 0.0 { -b } else { b };
        let angle = libm::acos(a.dot(b).min(1.0));
        // Between directions as near as that, an arc is a line.
        let [of_a, of_b] = if angle < 1e-6 {
            [1.0 - self.way, self.way]
        } else {
            [1.0 - self.way, self.way].map(|t| libm::sin(t * angle) / libm::sin(angle))
        };
        let q = a * of_a + b * of_b;
        q / q.length()
    }
}

/// The key before a time, the way from it to the next, and the seconds between them.
fn place(times: &Vectors, time: f64) -> (usize, f64, f64) {
    let at = |i: usize| f64::from(times.at::<1>(i as u32)[0]);
    let (mut low, mut high) = (0, times.count());
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if at(middle) <= time { low = middle } else { high = middle }
    }
    if low + 1 == times.count() || time <= at(low) {
        return (low, 0.0, 0.0);
    }
    let seconds = at(low + 1) - at(low);
    (low, ((time - at(low)) / seconds).clamp(0.0, 1.0), seconds)
}
