//! Locally ordered clustering, in a bounded number of passes.
//!
//! Boxes are sorted along a Morton curve. In each pass every cluster looks for the partner, among its neighbours along the
//! curve, with which it has the smallest box; two that choose each other become one. Where boxes grow steadily along the curve,
//! as in a nest of shells or the wedges of a disc, all choose the same side and one pair is made a pass: quadratic time, and a
//! tree as deep as it has leaves. So a pass in which fewer than one cluster in [`STALLED`] finds a partner joins neighbours
//! instead, which halves the number of clusters.
//!
//! Source: [MeisterBittner18].

use glam::DVec3;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH, node::Bvh2Node},
    ploc::morton::{morton_encode_u64_unorm, morton_encode_u128_unorm},
};
use rayon::prelude::*;

/// Clusters for each pair that a pass has to make.
const STALLED: usize = 32;
/// So few clusters may be joined one pair at a time.
const FEW: usize = 256;

/// How clusters look for partners.
#[derive(Clone, Copy)]
pub(super) struct Search {
    /// Neighbours along the curve, to either side.
    pub reach: usize,
    /// Passes, the first ones, in which only the next neighbours count.
    pub short_passes: usize,
    /// Whether the curve has 42 bits an axis; else 21.
    pub precise: bool,
}

/// A binary tree over `boxes`, one to a leaf, and whether a pass has stalled.
pub(super) fn cluster(boxes: &[Aabb], search: Search) -> (Bvh2, bool) {
    let mut clusters: Vec<_> =
        along_curve(boxes, search.precise).into_iter().map(|i| Bvh2Node::new(boxes[i as usize], 1, i)).collect();
    let mut free = (2 * boxes.len()).saturating_sub(1);
    let mut bvh = Bvh2::zeroed(boxes.len());
    bvh.primitive_indices = (0..boxes.len() as u32).collect();
    let (mut passes, mut stalled) = (0, false);
    while clusters.len() > 1 {
        let (partners, stalls) = partners(&clusters, if passes < search.short_passes { 1 } else { search.reach });
        let mut next = Vec::with_capacity(clusters.len());
        for (i, &partner) in partners.iter().enumerate() {
            if partner == i {
                next.push(clusters[i]);
            } else if partner < i {
                free -= 2;
                (bvh.nodes[free], bvh.nodes[free + 1]) = (clusters[i], clusters[partner]);
                next.push(Bvh2Node::new(clusters[i].aabb().union(clusters[partner].aabb()), 0, free as u32));
            }
        }
        clusters = next;
        (passes, stalled) = (passes + 1, stalled | stalls);
    }
    if let Some(&root) = clusters.first() {
        bvh.nodes[0] = root;
    }
    bvh.max_depth = DEFAULT_MAX_STACK_DEPTH.max(passes + 1);
    bvh.children_are_ordered_after_parents = true;
    (bvh, stalled)
}

/// With which cluster each one is joined, itself where it waits for the next pass, and whether the pass stalls.
fn partners(clusters: &[Bvh2Node], reach: usize) -> (Vec<usize>, bool) {
    let count = clusters.len();
    let choices: Vec<_> = (0..count).into_par_iter().with_min_len(512).map(|i| choice(clusters, i, reach)).collect();
    let agree = |i: usize| choices[choices[i]] == i;
    let pairs = (0..count).filter(|&i| choices[i] < i && agree(i)).count();
    let stalls = count > FEW && pairs * STALLED < count;
    let partner = |i: usize| match stalls {
        true => (i ^ 1).min(count - 1),
        false if agree(i) => choices[i],
        false => i,
    };
    ((0..count).map(partner).collect(), stalls)
}

/// The neighbour with which cluster `i` has the smallest box; of equals, the last.
fn choice(clusters: &[Bvh2Node], i: usize, reach: usize) -> usize {
    let own = clusters[i].aabb();
    let neighbours = (i.saturating_sub(reach)..clusters.len().min(i + reach + 1)).filter(|&other| other != i);
    let mut best = (f32::INFINITY, i);
    for other in neighbours {
        let area = own.union(clusters[other].aabb()).half_area();
        if area <= best.0 {
            best = (area, other);
        }
    }
    best.1
}

/// Indices of the boxes along a Morton curve through their centres.
fn along_curve(boxes: &[Aabb], precise: bool) -> Vec<u32> {
    let whole = boxes.iter().fold(Aabb::empty(), |whole, b| whole.union(b));
    let (low, size) = (whole.min.as_dvec3(), whole.diagonal().as_dvec3());
    let scale = DVec3::select(size.cmpgt(DVec3::ZERO), size.recip(), DVec3::ZERO);
    let code = |b: &Aabb| {
        let at = (b.center().as_dvec3() - low) * scale;
        if precise { morton_encode_u128_unorm(at) } else { u128::from(morton_encode_u64_unorm(at)) }
    };
    let mut keyed: Vec<_> = boxes.par_iter().zip(0..boxes.len() as u32).map(|(b, i)| (code(b), i)).collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}
