//! How much light microfacets scatter at once, and where the rest goes.
//!
//! One scattering returns E(μ) < 1 of what comes along a direction with μ = cosθ; the others meet the surface again. They
//! leave in proportion to what one scattering lacks there, m(μ) = 1 - E(μ):
//!
//! f = m(μₗ) m(μₑ)/(π m̄),  m̄ = ∫₀¹ m 2μ dμ,  so that ∫ f cosθ dω = m: reciprocal, and white is white.
//!
//! Tables are over x = √(μ/(μ + α sinθ)) ∈ [0, 1], in which E has one shape for all α → 0, and √m is nearly straight at either end.
//! Derivation: docs/theory-surfaces.md.
//!
//! Source: Kulla & Conty, "Revisiting Physically Based Shading at Imageworks", SIGGRAPH course, 2017.

use super::albedo_table::{BENT, COLUMNS, LACKING, ROWS};
use super::interpolation::{bracket, lerp};
use super::lacking::{Lacking, Tabulated};
use super::microfacet::{self, Ggx, Microfacets};
use glam::Vec3A;

/// x(μ).
#[inline]
fn abscissa(alpha: f32, cos: f32) -> f32 {
    (cos / (cos + alpha * (1.0 - cos * cos).max(0.0).sqrt())).sqrt()
}

/// μ(x).
fn cosine(alpha: f32, x: f32) -> f32 {
    let (rest, part) = (1.0 - x * x, alpha * x * x);
    part / (rest * rest + part * part).sqrt()
}

/// ∫₀¹ g(μ) 2μ dμ by the trapezium rule in μ², between points that are equidistant in √μ.
pub(super) fn cosine_average<const N: usize>(g: impl Fn(f32) -> [f32; N]) -> [f32; N] {
    const STEPS: u16 = 128;
    let mut sum = [0.0; N];
    let (mut below, mut at_below) = (0.0, g(0.0));
    for i in 1..=STEPS {
        let root = f32::from(i) / f32::from(STEPS);
        let (cos, at) = (root * root, g(root * root));
        let weight = 0.5 * (cos - below) * (cos + below);
        (0..N).for_each(|k| sum[k] += weight * (at_below[k] + at[k]));
        (below, at_below) = (cos, at);
    }
    sum
}

/// Mean of `g` over the microfacet normals that the direction `v` about n = z sees, weighted by D_v.
pub(super) fn visible_average(ggx: Ggx, v: Vec3A, g: impl Fn(Vec3A) -> f32) -> f32 {
    lattice_average([987, 1597], |u| ggx.sample_normal(Vec3A::Z, v, u).map_or(0.0, &g))
}

/// Mean over the unit square on a Fibonacci lattice: two Fibonacci numbers that follow each other, the second is that of points.
///
/// Few points of it lie along any one kink of the integrand, as total reflection and the horizon make them.
pub(super) fn lattice_average([step, count]: [u32; 2], g: impl Fn([f32; 2]) -> f32) -> f32 {
    let at = |i: u32| (i as f32 + 0.5) / count as f32;
    let sum: f64 = (0..count).map(|i| f64::from(g([at(i * step % count), at(i)]))).sum();
    (sum / f64::from(count)) as f32
}

/// A direction at μ = cosθ about z.
pub(super) fn at_cosine(cos: f32) -> Vec3A {
    Vec3A::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos)
}

/// Directional albedo of microfacets that reflect, from tables.
#[derive(Clone, Copy, Debug)]
pub struct Albedo {
    alpha: f32,
    row: usize,
    /// Of the next row, ∈ [0, 1].
    share: f32,
}

impl Albedo {
    /// Of these microfacets.
    pub(super) fn new(ggx: Ggx) -> Self {
        let (row, share) = bracket(ggx.alpha.sqrt(), ROWS);
        Self { alpha: ggx.alpha, row, share }
    }

    /// At μ = `cos`.
    #[inline]
    pub(super) fn at(self, cos: f32) -> Lacking {
        let x = abscissa(self.alpha, cos);
        let (column, t) = bracket(x, COLUMNS);
        let read = |table: &[[f32; COLUMNS]; ROWS]| {
            let along = |row: &[f32; COLUMNS]| lerp(row[column], row[column + 1], t);
            lerp(along(&table[self.row]), along(&table[self.row + 1]), self.share)
        };
        let root = read(&LACKING) * (1.0 - x + self.alpha);
        let white = root * root;
        let far = (1.0 - cos).max(0.0);
        let mirrored = (far * far) * (far * far) * far;
        Lacking { white, grazing: (self.alpha * read(&BENT) + (1.0 - white) * mirrored).max(0.0) }
    }

    /// ∫₀¹ · 2μ dμ of both.
    pub(super) fn average(self) -> Lacking {
        let at = |cos| {
            let lacking = self.at(cos);
            [lacking.white, lacking.grazing]
        };
        let [white, grazing] = cosine_average(at);
        Lacking { white, grazing }
    }
}

impl Tabulated for Ggx {
    type Albedo = Albedo;

    #[inline]
    fn lacking(self, albedo: &Albedo, n: Vec3A, direction: Vec3A) -> Lacking {
        albedo.at(n.dot(direction).abs())
    }
}

/// m(μ) of microfacets that do more than reflect, at one α, over x of √α: fine enough at the critical angle, too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    roughness: f32,
    /// √m.
    nodes: [f32; COLUMNS],
}

impl Curve {
    /// m = 1 - `albedo`(μ), but never below 0.
    pub(super) fn new(ggx: Ggx, albedo: impl Fn(f32) -> f32) -> Self {
        let roughness = ggx.alpha.sqrt();
        let cos = |i| cosine(roughness, i as f32 / (COLUMNS - 1) as f32).max(2.0 * microfacet::GRAZING);
        let node = |i| (1.0 - albedo(cos(i))).max(0.0).sqrt();
        Self { roughness, nodes: std::array::from_fn(node) }
    }

    /// The curve of these microfacets between two others of the same interface: √m is interpolated at each x.
    pub(super) fn between(ggx: Ggx, [a, b]: [&Self; 2], t: f32) -> Self {
        Self { roughness: ggx.alpha.sqrt(), nodes: std::array::from_fn(|i| lerp(a.nodes[i], b.nodes[i], t)) }
    }

    /// m(μ).
    #[inline]
    pub(super) fn at(&self, cos: f32) -> f32 {
        let (column, t) = bracket(abscissa(self.roughness, cos), COLUMNS);
        let root = lerp(self.nodes[column], self.nodes[column + 1], t);
        root * root
    }

    /// m̄.
    pub(super) fn average(&self) -> f32 {
        cosine_average(|cos| [self.at(cos)])[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::bsdf::fresnel::reflect;

    /// E and B by quadrature.
    fn albedo(ggx: Ggx, cos: f32) -> [f32; 2] {
        let v = at_cosine(cos);
        let weighted = |weight: fn(f32) -> f32| {
            let reflected = |h: Vec3A| ggx.unmasked(cos, reflect(v, h).z) * weight(h.dot(v));
            lattice_average([6765, 10946], |u| ggx.sample_normal(Vec3A::Z, v, u).map_or(0.0, reflected))
        };
        [weighted(|_| 1.0), weighted(|cos| (1.0 - cos).max(0.0).powi(5))]
    }

    /// Nodes of both tables by quadrature.
    fn node(row: usize, column: usize) -> [f32; 2] {
        let roughness = row as f32 / (ROWS - 1) as f32;
        // Of the limit α → 0 this is a good example.
        let ggx = Ggx { alpha: (roughness * roughness).max(1e-3) };
        let cos = cosine(ggx.alpha, column as f32 / (COLUMNS - 1) as f32).max(2.0 * microfacet::GRAZING);
        let [white, grazing] = albedo(ggx, cos);
        let x = column as f32 / (COLUMNS - 1) as f32;
        let root = (1.0 - white).max(0.0).sqrt();
        [root / (1.0 - x + ggx.alpha), (grazing - white * (1.0 - cos).powi(5)) / ggx.alpha]
    }

    /// Prints what `albedo_table.rs` says.
    #[test]
    #[ignore = "makes the tables"]
    fn tables() {
        for k in 0..2 {
            for row in 0..ROWS {
                let nodes: Vec<String> = (0..COLUMNS).map(|column| format!("{:.3}", node(row, column)[k])).collect();
                println!("    [{}],", nodes.join(", "));
            }
            println!();
        }
    }

    /// The greatest error of the tables' nodes in units of their last digit, if all of them had `error` units more.
    fn distance(error: f32) -> f32 {
        let nodes = (0..ROWS * COLUMNS).map(|i| (i / COLUMNS, i % COLUMNS));
        let off = nodes.map(|(row, column)| {
            let [white, bent] = node(row, column);
            let units = [LACKING[row][column] - white, BENT[row][column] - bent].map(|off| off / 1e-3);
            units.into_iter().map(|unit| (unit + error).abs()).fold(0.0, f32::max)
        });
        off.fold(0.0, f32::max)
    }

    #[test]
    fn tables_hold_what_quadrature_finds() {
        assert!(distance(0.0) < 1.0 && distance(1.0) > 1.0, "{}", distance(0.0));
    }

    /// Between the nodes, too: m and B by quadrature, from grazing to normal incidence.
    #[test]
    fn tables_are_fine_enough() {
        for roughness in [0.02, 0.1, 0.17, 0.3, 0.44, 0.61, 0.83, 1.0f32] {
            let ggx = Ggx { alpha: roughness * roughness };
            for cos in [1e-3, 0.01, 0.02, 0.05, 0.13, 0.3, 0.55, 0.8, 0.97] {
                let ([white, grazing], found) = (albedo(ggx, cos), Albedo::new(ggx).at(cos));
                let off = [1.0 - white - found.white, grazing - found.grazing];
                assert!(off.iter().all(|d| d.abs() < 2.5e-3), "roughness {roughness}, cosθ {cos}: {off:?}");
            }
        }
    }
}
