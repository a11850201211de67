//! Directions of photons that lie around a place, as a function of the place.
//!
//! Light of one small lamp by one sequence of events comes from nearly one point, its image, so that its direction is a smooth function. A fit of the
//! second degree knows it far better than any photon: what it leaves is of the third order in the distance between photons.

use super::lobe::Lobe;
use super::place::Photon;
use crate::transport::geometry::math::frame;
use glam::{DVec3, Vec3A};

/// Share of the mean of their squares that is added to that of photons' monomials in a fit, so that it is defined wherever they lie.
const RIDGE: f64 = 1e-4;
/// Monomials of the coordinates u and v of a place that a fit takes: 1, u, v, and with enough photons u², uv and v², too.
const MONOMIALS: [usize; 2] = [3, 6];
/// Fewest photons that tell the width of a fit.
pub(super) const FEWEST: usize = MONOMIALS[1] + 1;

/// Directions as a function of the second degree of the place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// x̄.
    place: Vec3A,
    /// One over the root of the mean square of |x_j − x̄|: places are scaled by it, as scenes are of all sizes.
    pub(super) scale: f32,
    /// The axes of u and v: two across the mean normal.
    axes: [Vec3A; 2],
    /// c_i, of d(u, v) = Σ c_i m_i(u, v).
    coefficients: [Vec3A; MONOMIALS[1]],
    /// ε.
    width: f32,
}

impl Fit {
    /// The least squares of d_j − d(u_j, v_j).
    pub(super) fn new(photons: &[Photon]) -> Self {
        let n = photons.len() as f32;
        let place = photons.iter().map(|p| p.at.position).sum::<Vec3A>() / n;
        let square = photons.iter().map(|p| (p.at.position - place).length_squared()).sum::<f32>() / n;
        let scale = if square > 0.0 { square.sqrt().recip() } else { 0.0 };
        let normal = Lobe::towards(photons.iter().map(|p| p.at.normal).sum(), 1.0).axis;
        let coefficients = [Vec3A::ZERO; MONOMIALS[1]];
        let mut it = Self { place, scale, axes: frame(normal).into(), coefficients, width: 1.0 };
        let count = if photons.len() < 2 * MONOMIALS[1] { MONOMIALS[0] } else { MONOMIALS[1] };
        it.coefficients = it.least_squares(photons, count);
        if photons.len() >= FEWEST {
            let left = |p: &Photon| (p.direction() - it.direction(p.at.position)).length_squared();
            it.width = 0.5 * photons.iter().map(left).sum::<f32>() / (n - count as f32);
        }
        it
    }

    /// Coefficients of so many monomials, from the normal equations.
    fn least_squares(&self, photons: &[Photon], count: usize) -> [Vec3A; MONOMIALS[1]] {
        let (mut squares, mut products) = ([[0.0; MONOMIALS[1]]; MONOMIALS[1]], [DVec3::ZERO; MONOMIALS[1]]);
        for photon in photons {
            let m = self.monomials(photon.at.position).map(f64::from);
            for i in 0..count {
                products[i] += m[i] * photon.direction().as_dvec3();
                (0..count).for_each(|j| squares[i][j] += m[i] * m[j]);
            }
        }
        (1..count).for_each(|i| squares[i][i] += RIDGE * photons.len() as f64);
        solve(&mut squares, &mut products, count);
        products.map(|c| c.as_vec3a())
    }

    fn monomials(&self, x: Vec3A) -> [f32; MONOMIALS[1]] {
        let step = self.scale * (x - self.place);
        let [u, v] = self.axes.map(|axis| axis.dot(step));
        [1.0, u, v, u * u, u * v, v * v]
    }

    /// d.
    fn direction(&self, x: Vec3A) -> Vec3A {
        self.coefficients.iter().zip(self.monomials(x)).map(|(c, m)| *c * m).sum()
    }

    /// Of a place to those of the photons, one over an area: 1/(1 + |s (x − x̄)|²)^(3/2) s², with s one over their extent.
    pub(super) fn nearness(&self, x: Vec3A) -> f64 {
        let square = f64::from(self.scale).powi(2);
        let apart = 1.0 + square * (x - self.place).as_dvec3().length_squared();
        square / (apart * apart.sqrt())
    }

    /// The directions that it foretells at x.
    pub(super) fn lobe(&self, x: Vec3A) -> Lobe {
        Lobe::towards(self.direction(x), self.width)
    }
}

/// Solves A c = b for the first `count` rows and columns of a symmetric positive definite matrix by elimination; c takes the place of b.
fn solve(a: &mut [[f64; MONOMIALS[1]]; MONOMIALS[1]], b: &mut [DVec3; MONOMIALS[1]], count: usize) {
    for i in 0..count {
        let (row, right) = (a[i], b[i]);
        for j in i + 1..count {
            let factor = a[j][i] / row[i];
            a[j].iter_mut().zip(row).for_each(|(below, above)| *below -= factor * above);
            b[j] -= factor * right;
        }
    }
    for i in (0..count).rev() {
        let known: DVec3 = (i + 1..count).map(|j| a[i][j] * b[j]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
}

#[cfg(test)]
mod tests {
    use super::super::place::Place;
    use super::*;
    use crate::engine::{Purpose, generator, uniform_f32};
    use crate::transport::geometry::math::unit;

    /// All rays of a point behind a mirror come from the point's image, wherever they arrive: the fit knows it, single photons do not.
    #[test]
    fn a_fit_foretells_what_lies_between_its_photons() {
        let image = Vec3A::new(0.2, 3.0, -0.1);
        let photon = |i: u64| {
            let rng = &mut generator(2, Purpose::Sample, 0, 0, i);
            let position = Vec3A::new(uniform_f32(rng), 0.0, uniform_f32(rng)) * 0.2;
            let from = position + (image - position) / (image.y - position.y);
            Photon { at: Place { position, normal: Vec3A::Y }, from }
        };
        let photons: Vec<_> = (0..16).map(photon).collect();
        let (fit, x) = (Fit::new(&photons), Vec3A::new(0.07, 0.0, 0.13));
        let right = unit(image - x);
        assert!(fit.lobe(x).axis.distance(right) < 2e-3, "{fit:?}");
        let of_photons = photons.iter().map(|photon| photon.lobe(x).density(right)).sum::<f32>() / 16.0;
        assert!(fit.lobe(x).density(right) > 100.0 * of_photons, "{of_photons}");
    }
}
