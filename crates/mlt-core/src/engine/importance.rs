//! The scalar that chains sample.

/// I(x) ≥ 0, in proportion to which a chain visits states; it may be 0 only where every deposit of x is 0.
pub trait Importance<P> {
    /// I(x), in the measure that the strata's densities refer to.
    fn eval(&self, path: &P) -> f64;
}

/// Any closure is an importance.
impl<P, F: Fn(&P) -> f64> Importance<P> for F {
    fn eval(&self, path: &P) -> f64 {
        self(path)
    }
}
