//! The scalar that chains sample.

/// I(x) ≥ 0, in proportion to which a chain visits states; it may be 0 only where every deposit of x is 0.
pub trait Importance<P> {
    /// I(x), in the measure that the strata's densities refer to.
    fn eval(&self, path: &P) -> f64;

    /// The divisor of a deposit of x, `eval` being I(x). It is larger where others estimate a part of f(x): chains then estimate the
    /// share I(x)/`divisor` of it.
    #[inline]
    fn divisor(&self, _path: &P, eval: f64) -> f64 {
        eval
    }
}

/// Any closure is an importance.
impl<P, F: Fn(&P) -> f64> Importance<P> for F {
    fn eval(&self, path: &P) -> f64 {
        self(path)
    }
}
