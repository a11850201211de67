//! Copies of a shape, each in a place of its own, which share the shape's structure.
//!
//! A tree over the copies' boxes is walked like any other; at a leaf the ray goes on in the coordinates of the shape. Of two hits at
//! exactly the same t, the one with the smaller index wins, as among triangles.

use super::binary::over_boxes;
use super::collapse::fold;
use super::segment::Segment;
use super::simd::Simd;
use super::traverse::{Leaves, Structure, any_hit, nearest_hit};
use super::wide::{Child, WIDTH, WideTree};
use super::{Accel, Quality};
use crate::transport::geometry::{Hit, Placement, Ray};
use obvhs::aabb::Aabb;

/// Copies of shapes.
#[derive(Debug, Default)]
pub(crate) struct Copies {
    /// The shapes.
    pub shapes: Vec<Accel>,
    /// Of each copy its shape's number and where it stands.
    pub places: Vec<(u32, Placement)>,
}

/// Copies of shapes, in a tree.
#[derive(Debug)]
pub(super) struct Instances {
    copies: Copies,
    /// Of each copy the index of its first triangle, ascending.
    firsts: Vec<u32>,
    tree: WideTree,
    /// The copy in each leaf.
    in_leaf: Vec<u32>,
}

/// A triangle of a copy.
#[derive(Clone, Copy, Debug)]
pub struct Instance<'a> {
    /// Number of the shape.
    pub shape: usize,
    /// Index of the triangle in the shape.
    pub triangle: u32,
    /// Where the shape stands.
    pub(crate) placement: &'a Placement,
}

impl Instances {
    /// Copies whose triangles have the indices from `first` on.
    pub(super) fn new(copies: Copies, mut first: u32) -> Self {
        let mut firsts = Vec::with_capacity(copies.places.len());
        for (shape, _) in &copies.places {
            firsts.push(first);
            first += copies.shapes[*shape as usize].count;
        }
        let bounds = |(shape, placement): &(u32, Placement)| copies.shapes[*shape as usize].bounds_at(placement);
        let boxes: Vec<_> = copies.places.iter().map(bounds).collect();
        let names: Vec<_> = (0..boxes.len() as u32).collect();
        let (nodes, slots, depth) = fold(&over_boxes(&boxes, &names, Quality::Medium), 1, |_| false);
        let whole = boxes.iter().fold(Aabb::empty(), |whole, b| whole.union(b));
        let tree = WideTree::new(nodes, Vec::new(), depth, whole.min.abs().max(whole.max.abs()).max_element());
        let in_leaf = slots.chunks(WIDTH).map(|slots| slots[0]).collect();
        Self { copies, firsts, tree, in_leaf }
    }

    /// Memory that they and their shapes take, bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { copies: Copies { shapes, places }, firsts, tree, in_leaf } = self;
        let lists = size_of_val(&places[..]) + size_of_val(&firsts[..]) + size_of_val(&in_leaf[..]);
        tree.bytes() + lists + shapes.iter().map(Accel::bytes).sum::<usize>()
    }

    /// The copy that has the triangle of an index, which is not less than the first.
    pub(super) fn find(&self, primitive: u32) -> Instance<'_> {
        let number = self.firsts.partition_point(|&first| first <= primitive) - 1;
        let (shape, placement) = &self.copies.places[number];
        Instance { shape: *shape as usize, triangle: primitive - self.firsts[number], placement }
    }

    /// In a leaf: the copy's number, its shape, and the ray there.
    #[inline]
    fn enter(&self, leaf: Child, ray: &Ray) -> (usize, &Accel, Ray) {
        let number = self.in_leaf[leaf.first_block()] as usize;
        let (shape, placement) = &self.copies.places[number];
        (number, &self.copies.shapes[*shape as usize], placement.ray(ray))
    }
}

impl Accel {
    /// The box around the triangles as they stand at a place; that of each of the root's children is mapped, which is tighter.
    fn bounds_at(&self, placement: &Placement) -> Aabb {
        let boxes = self.tree.nodes[0].boxes().map(|corners| placement.bounds(corners));
        boxes.fold(Aabb::empty(), |whole, [min, max]| whole.union(&Aabb { min: min.into(), max: max.into() }))
    }
}

impl Structure for &Instances {
    #[inline(always)]
    fn nearest<S: Simd>(self, simd: S, ray: &Segment) -> Option<Hit> {
        let mut visit = Visit { instances: self, ray: (*ray).into(), hit: None };
        nearest_hit::<_, false>(simd, &self.tree, ray, &mut visit);
        visit.hit
    }

    #[inline(always)]
    fn any<S: Simd>(self, simd: S, ray: &Segment) -> bool {
        any_hit::<_, false>(simd, &self.tree, ray, &Visit { instances: self, ray: (*ray).into(), hit: None })
    }
}

/// One ray among the copies.
struct Visit<'a> {
    instances: &'a Instances,
    ray: Ray,
    hit: Option<Hit>,
}

impl<S: Simd> Leaves<S> for Visit<'_> {
    fn t(&self) -> f32 {
        self.hit.map_or(self.ray.t_max, |hit| hit.t)
    }

    fn look(&mut self, _: S, leaf: Child) {
        let ray = Ray { t_max: Leaves::<S>::t(self), ..self.ray };
        let (number, shape, ray) = self.instances.enter(leaf, &ray);
        let Some(hit) = shape.closest(&ray) else { return };
        let hit = Hit { primitive: self.instances.firsts[number] + hit.primitive, ..hit };
        if self.hit.is_none_or(|found| (hit.t, hit.primitive) < (found.t, found.primitive)) {
            self.hit = Some(hit);
        }
    }

    fn any(&self, _: S, leaf: Child) -> bool {
        let (_, shape, ray) = self.instances.enter(leaf, &self.ray);
        shape.occluded(&ray)
    }
}
