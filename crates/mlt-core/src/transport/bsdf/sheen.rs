//! Fibres that stand on a surface, such as those of velvet.

use super::Evaluation;
use super::albedo::at_cosine;
use super::interpolation::{bracket, lerp};
use super::microfacet::GRAZING;
use crate::transport::colour::Rgb;
use crate::transport::geometry::math::{frame, turn, unit};
use glam::Vec3A;
use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::LazyLock;

/// Smallest α: fibres that are straighter shine in a line that no one has a use for.
const LEAST_ALPHA: f32 = 0.02;

/// Nodes of [`ALBEDO`] over √α and over √μ.
const ROWS: usize = 17;
const COLUMNS: usize = 33;

/// E(μ) of white fibres.
static ALBEDO: LazyLock<Vec<[f32; COLUMNS]>> = LazyLock::new(|| {
    let share = |i: usize, count: usize| i as f32 / (count - 1) as f32;
    let row = |i: usize| {
        let alpha = (share(i, ROWS) * share(i, ROWS)).max(LEAST_ALPHA);
        std::array::from_fn(|k| quadrature(alpha, (share(k, COLUMNS) * share(k, COLUMNS)).max(1e-4)))
    };
    (0..ROWS).map(row).collect()
});

/// f_s = C D V/E_max on either side, with D = (2 + 1/α) sin^{1/α}θₕ/2π, V = 1/(4 (μₗ + μₑ − μₗ μₑ)) and E_max ≥ 1 so large that white fibres
/// reflect no more than they get.
///
/// Sources: Estevez & Kulla, "Production Friendly Microfacet Sheen BRDF", SIGGRAPH course, 2017; Neubelt & Pettineo, "Crafting a
/// Next-Gen Material Pipeline for The Order: 1886", SIGGRAPH course, 2013 (V).
#[derive(Clone, Copy, Debug)]
pub struct Sheen {
    /// C ∈ [0, 1].
    pub colour: Rgb,
    alpha: f32,
    row: usize,
    /// Of the next row, ∈ [0, 1].
    share: f32,
    /// 1/E_max.
    scale: f32,
}

/// D V.
fn shine(alpha: f32, cos: [f32; 2], cos_half: f32) -> f32 {
    let sin2 = (1.0 - cos_half * cos_half).max(0.0);
    let d = (2.0 + 1.0 / alpha) * libm::powf(sin2, 0.5 / alpha) / TAU;
    d / (4.0 * (cos[0] + cos[1] - cos[0] * cos[1]))
}

/// ∫ D V μ dω by the midpoint rule over μ² and azimuth.
fn quadrature(alpha: f32, cos: f32) -> f32 {
    const STEPS: [u32; 2] = [64, 32];
    let v = at_cosine(cos);
    let mut sum = 0.0f64;
    for i in 0..STEPS[0] {
        let root = (i as f32 + 0.5) / STEPS[0] as f32;
        let z = root * root;
        let sin = (1.0 - z * z).sqrt();
        for j in 0..STEPS[1] {
            let azimuth = turn((j as f32 + 0.5) / STEPS[1] as f32);
            let l = Vec3A::new(sin * azimuth.x, sin * azimuth.y, z);
            let half = unit(l + v);
            // dμ = 2 root d(root).
            sum += f64::from(shine(alpha, [z, cos], half.z) * z * 2.0 * root);
        }
    }
    (sum * f64::from(TAU) / f64::from(STEPS[0] * STEPS[1])) as f32
}

impl Sheen {
    /// Fibres of a roughness; α is its square.
    pub fn new(colour: Rgb, roughness: f32) -> Self {
        let alpha = (roughness * roughness).max(LEAST_ALPHA);
        let (row, share) = bracket(alpha.sqrt(), ROWS);
        let most = |row: usize| ALBEDO[row].iter().copied().fold(1.0, f32::max);
        let scale = 1.0 / most(row).max(most(row + 1));
        Self { colour, alpha, row, share, scale }
    }

    /// E(μ) of the greatest channel.
    #[inline]
    pub fn albedo(&self, cos: f32) -> f32 {
        let (column, t) = bracket(cos.clamp(0.0, 1.0).sqrt(), COLUMNS);
        let along = |row: &[f32; COLUMNS]| lerp(row[column], row[column + 1], t);
        let white = lerp(along(&ALBEDO[self.row]), along(&ALBEDO[self.row + 1]), self.share);
        (white * self.scale * self.colour.max_element()).min(1.0)
    }

    /// f_s, and the density 1/2π on one side.
    #[inline]
    pub fn evaluate(&self, n: Vec3A, to_light: Vec3A, to_eye: Vec3A) -> Evaluation {
        let (l, e) = (n.dot(to_light), n.dot(to_eye));
        if l * e <= 0.0 || l.abs().min(e.abs()) <= GRAZING {
            return Evaluation::NOTHING;
        }
        let cos_half = n.dot((to_light + to_eye).normalize_or_zero());
        let value = self.colour * (self.scale * shine(self.alpha, [l.abs(), e.abs()], cos_half));
        Evaluation { value, pdf_to_eye: 0.5 * FRAC_1_PI, pdf_to_light: 0.5 * FRAC_1_PI }
    }

    /// Uniform on the side of `given`.
    #[inline]
    pub fn sample(&self, n: Vec3A, given: Vec3A, u: [f32; 3]) -> Vec3A {
        let cos = u[0].max(2.0 * GRAZING);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let n = n * 1f32.copysign(n.dot(given));
        let (s, t) = frame(n);
        let azimuth = turn(u[1]);
        sin * (azimuth.x * s + azimuth.y * t) + cos * n
    }
}
