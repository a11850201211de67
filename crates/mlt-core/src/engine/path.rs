//! States of a chain.

/// One deposit of a state: a site of the film and f(x) there, before any weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat<const C: usize> {
    /// Index of the film's site.
    pub site: u32,
    /// f(x), one number a channel.
    pub value: [f64; C],
}

/// A state x together with what it deposits when a chain visits it.
pub trait Path: Clone {
    /// One deposit; opaque to the chain.
    type Splat;

    /// h_p(x) f(x), one item for each site p that x touches.
    fn splats(&self) -> impl Iterator<Item = Self::Splat>;
}
