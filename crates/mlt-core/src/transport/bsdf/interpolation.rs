//! Reading between the nodes of a table.

/// The node below `x` ∈ [0, 1] among `count` equidistant ones, not the last, and how far x is on the way to the next.
#[inline]
pub(super) fn bracket(x: f32, count: usize) -> (usize, f32) {
    let position = x * (count - 1) as f32;
    let node = (position as usize).min(count - 2);
    (node, position - node as f32)
}

/// The point between `a` and `b` at the share `t` of the way.
#[inline]
pub(super) fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}
