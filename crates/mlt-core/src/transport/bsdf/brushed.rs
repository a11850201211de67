//! Microfacets of a brushed surface with all that is known of them at their two roughnesses.
//!
//! E and B (see [`albedo`](super::albedo)) depend on α_t, α_b, μ = cosθ and the azimuth. They are interpolated from tables that are made
//! when the first brushed surface is, in 0.3 s, over √α_t, √α_b and
//!
//! * E: x = √(μ/(μ + s)), s² = α_t² (v·t)² + α_b² (v·b)², and the azimuth after stretching, along which √(1 − E)/(1 − x + ᾱ) is nearly straight,
//!   ᾱ² being the mean of α_t² and α_b²: off by 0.001 in the mean, by 0.005 at most;
//! * B/E: √μ and the azimuth: off by 0.001 in the mean, by 0.03 at grazing angles.

use super::albedo::{cosine_average, lattice_average};
use super::anisotropic::AnisotropicGgx;
use super::facets::Facets;
use super::fresnel::reflect;
use super::interpolation::{bracket, lerp};
use super::lacking::{Lacking, Tabulated};
use super::microfacet::{GRAZING, Ggx, Microfacets};
use super::spread::Spread;
use glam::Vec3A;
use std::f32::consts::FRAC_PI_2;
use std::sync::LazyLock;

/// Nodes along √α_t, and along √α_b.
const ROWS: usize = 16;
/// Nodes along x, and along √μ.
const COLUMNS: usize = 24;
/// Nodes along a right angle of azimuths.
const TURNS: usize = 7;
/// Least α: rounding of directions in f32 resolves the lobe.
const LEAST: f32 = 1e-4;

impl Tabulated for AnisotropicGgx {
    type Albedo = ();

    #[inline]
    fn lacking(self, (): &(), n: Vec3A, direction: Vec3A) -> Lacking {
        lacking(self.alphas, self.local(n, direction))
    }
}

impl Facets<AnisotropicGgx> {
    /// Of a brushed surface, with α_t along the unit vector `tangent`, and α_b across it.
    pub fn brushed(tangent: Vec3A, alphas: [f32; 2]) -> Self {
        let alphas = alphas.map(|alpha| alpha.clamp(LEAST, 1.0));
        let widest = Ggx { alpha: alphas[0].max(alphas[1]) };
        let ggx = AnisotropicGgx { tangent, alphas };
        Self { ggx, albedo: (), spread: Spread::new(widest), mean: mean(alphas) }
    }
}

/// Numbers over √α_t, √α_b, a column and an azimuth.
struct Table(Vec<f32>);

/// √(1 − E)/(1 − x + ᾱ).
static LACKING: LazyLock<Table> = LazyLock::new(|| Table::new(lacking_node));

/// B/E.
static BENT: LazyLock<Table> = LazyLock::new(|| Table::new(bent_node));

/// √m̄ and B̄ over √α_t and √α_b.
static MEANS: LazyLock<Vec<[f32; 2]>> =
    LazyLock::new(|| (0..ROWS * ROWS).map(|i| mean_node([i / ROWS, i % ROWS].map(alpha))).collect());

impl Table {
    /// `node`: the number for α_t, α_b, a column and an azimuth, both ∈ [0, 1].
    fn new(node: impl Fn([f32; 2], f32, f32) -> f32) -> Self {
        let mut table = Self(vec![0.0; ROWS * ROWS * COLUMNS * TURNS]);
        for (down, right) in (0..ROWS).flat_map(|down| (0..=down).map(move |right| (down, right))) {
            for (column, turn) in (0..COLUMNS).flat_map(|column| (0..TURNS).map(move |turn| (column, turn))) {
                let share = |i: usize, count: usize| i as f32 / (count - 1) as f32;
                let value = node([alpha(down), alpha(right)], share(column, COLUMNS), share(turn, TURNS));
                table.0[index([down, right], column, turn)] = value;
                table.0[index([right, down], column, TURNS - 1 - turn)] = value;
            }
        }
        table
    }

    /// Interpolated; column and azimuth ∈ [0, 1].
    fn at(&self, alphas: [f32; 2], column: f32, turn: f32) -> f32 {
        let [(down, d), (right, r)] = alphas.map(|alpha| bracket(alpha.sqrt(), ROWS));
        let ((column, c), (turn, t)) = (bracket(column, COLUMNS), bracket(turn, TURNS));
        let along = |rows: [usize; 2]| {
            let of_column = |column| {
                let first = index(rows, column, turn);
                lerp(self.0[first], self.0[first + 1], t)
            };
            lerp(of_column(column), of_column(column + 1), c)
        };
        let of_row = |down| lerp(along([down, right]), along([down, right + 1]), r);
        lerp(of_row(down), of_row(down + 1), d)
    }
}

fn index([down, right]: [usize; 2], column: usize, turn: usize) -> usize {
    ((down * ROWS + right) * COLUMNS + column) * TURNS + turn
}

/// α of a row; of the first a small one instead of 0.
fn alpha(row: usize) -> f32 {
    (row as f32 / (ROWS - 1) as f32).powi(2).max(LEAST)
}

/// ᾱ.
fn mean_alpha([a, b]: [f32; 2]) -> f32 {
    (0.5 * (a * a + b * b)).sqrt()
}

/// Azimuth of (x, y) ≥ 0 over a right angle.
fn quarter(x: f32, y: f32) -> f32 {
    (libm::atan2f(y, x) / FRAC_PI_2).clamp(0.0, 1.0)
}

/// The direction at μ whose azimuth is that of (x, y).
fn direction(cos: f32, x: f32, y: f32) -> Vec3A {
    let cos = cos.max(2.0 * GRAZING);
    let scale = (1.0 - cos * cos).max(0.0).sqrt() / (x * x + y * y).sqrt();
    Vec3A::new(scale * x, scale * y, cos)
}

/// Lacking energy for a direction in local coordinates, on either side.
fn lacking(alphas: [f32; 2], [x, y, z]: [f32; 3]) -> Lacking {
    let (x, y, cos) = (x.abs(), y.abs(), z.abs().clamp(GRAZING, 1.0));
    let [along, across] = [alphas[0] * x, alphas[1] * y];
    let column = (cos / (cos + (along * along + across * across).sqrt())).sqrt();
    let root = LACKING.at(alphas, column, quarter(along, across)) * (1.0 - column + mean_alpha(alphas));
    let white = (root * root).min(1.0);
    Lacking { white, grazing: (1.0 - white) * BENT.at(alphas, cos.sqrt(), quarter(x, y)) }
}

fn mean(alphas: [f32; 2]) -> Lacking {
    let [(down, d), (right, r)] = alphas.map(|alpha| bracket(alpha.sqrt(), ROWS));
    let of = |k: usize| {
        let of_row = |down: usize| lerp(MEANS[down * ROWS + right][k], MEANS[down * ROWS + right + 1][k], r);
        lerp(of_row(down), of_row(down + 1), d)
    };
    Lacking { white: of(0).powi(2), grazing: of(1) }
}

/// Mean of `g` over the microfacet normals that `v` sees, about n = z, given v mirrored about each.
fn visible_average(alphas: [f32; 2], v: Vec3A, g: impl Fn(Vec3A, Vec3A) -> f32) -> f32 {
    let ggx = AnisotropicGgx { tangent: Vec3A::X, alphas };
    let at = |u| {
        ggx.sample_normal(Vec3A::Z, v, u).map_or(0.0, |h| {
            let r = reflect(v, h);
            if r.z > 0.0 { ggx.unmasked(v, r) * g(h, r) } else { 0.0 }
        })
    };
    lattice_average([233, 377], at)
}

fn lacking_node(alphas: [f32; 2], x: f32, turn: f32) -> f32 {
    let (sin, cos) = (libm::sinf(turn * FRAC_PI_2), libm::cosf(turn * FRAC_PI_2));
    // The azimuth before stretching; s over sinθ is 1 over the length of this.
    let (along, across) = (cos / alphas[0], sin / alphas[1]);
    let (rest, part) = (1.0 - x * x, x * x / (along * along + across * across).sqrt());
    let v = direction(part / (rest * rest + part * part).sqrt(), along, across);
    let white = 1.0 - visible_average(alphas, v, |_, _| 1.0);
    white.max(0.0).sqrt() / (1.0 - x + mean_alpha(alphas))
}

fn bent_node(alphas: [f32; 2], root: f32, turn: f32) -> f32 {
    let v = direction(root * root, libm::cosf(turn * FRAC_PI_2), libm::sinf(turn * FRAC_PI_2));
    let bent = |h: Vec3A, _| (1.0 - h.dot(v)).clamp(0.0, 1.0).powi(5);
    visible_average(alphas, v, bent) / visible_average(alphas, v, |_, _| 1.0).max(f32::MIN_POSITIVE)
}

fn mean_node(alphas: [f32; 2]) -> [f32; 2] {
    const STEPS: u16 = 16;
    let over_turns = |cos: f32| {
        let mut sum = [0.0; 2];
        for step in 0..STEPS {
            let azimuth = FRAC_PI_2 * (f32::from(step) + 0.5) / f32::from(STEPS);
            let found = lacking(alphas, direction(cos, libm::cosf(azimuth), libm::sinf(azimuth)).to_array());
            sum = [sum[0] + found.white / f32::from(STEPS), sum[1] + found.grazing / f32::from(STEPS)];
        }
        sum
    };
    let [white, grazing] = cosine_average(over_turns);
    [white.sqrt(), grazing]
}
