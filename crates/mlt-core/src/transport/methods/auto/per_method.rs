//! One value for each of the two independent methods that a pilot measures.

use super::candidates::Sampler;

/// A value of path tracing and one of bidirectional path tracing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PerMethod<T> {
    pub(super) path: T,
    pub(super) bidirectional: T,
}

impl<T> PerMethod<T> {
    pub(super) fn map<U>(self, mut f: impl FnMut(T) -> U) -> PerMethod<U> {
        PerMethod { path: f(self.path), bidirectional: f(self.bidirectional) }
    }

    pub(super) fn zip<U>(self, other: PerMethod<U>) -> PerMethod<(T, U)> {
        PerMethod { path: (self.path, other.path), bidirectional: (self.bidirectional, other.bidirectional) }
    }

    pub(super) fn as_ref(&self) -> PerMethod<&T> {
        PerMethod { path: &self.path, bidirectional: &self.bidirectional }
    }

    /// Each method with the value of the other one.
    pub(super) fn swapped(self) -> Self {
        Self { path: self.bidirectional, bidirectional: self.path }
    }

    /// The value of path tracing, then that of bidirectional path tracing.
    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        [&self.path, &self.bidirectional].into_iter()
    }

    /// That of a method.
    pub(super) fn of(&self, sampler: Sampler) -> &T {
        match sampler {
            Sampler::Path { .. } => &self.path,
            Sampler::Bidirectional => &self.bidirectional,
        }
    }
}
