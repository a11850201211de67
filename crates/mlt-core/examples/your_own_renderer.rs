//! A renderer that knows nothing of ours, made Metropolis by the engine's traits.
//!
//! It has its own vectors and its own paths: three spheres on a plane under a square lamp, direct light and one bounce.
//! A path is made from eight numbers in [0, 1), and a chain walks over those numbers. What the engine asks for is small:
//! what a state deposits, how to change it, and the parts that the lamp is cut into.
//!
//!     cargo run --release -p mlt-core --no-default-features --example your_own_renderer [IMAGE.ppm]
//!
//! Source: [KelemenSzirmayKalos02] (Metropolis over the numbers that a path is made from).

use mlt_core::engine::{
    Accumulated, Film, Metropolis, Mixture, Mutation, Path, Pixel, Purpose, SetupError, Share, Splat, Stratum,
    generator, render, uniform,
};
use mlt_core::rand_core::Rng;
use std::f64::consts::PI;
use std::ops::ControlFlow;

const WIDTH: u32 = 72;
const HEIGHT: u32 = 48;
const PIXELS: u32 = WIDTH * HEIGHT;
/// The lamp is cut into GRID × GRID squares.
const GRID: u32 = 2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (film, acceptance) = metropolis()?;
    let [mean] = film.pixel(PIXELS as usize);
    let plain = plain_monte_carlo(400_000);
    let z = (mean.mean - plain.mean) / mean.stderr.hypot(plain.stderr);
    match std::env::args().nth(1) {
        Some(file) => std::fs::write(file, ppm(&film))?,
        None => print!("{}", ascii(&film)),
    }
    println!("mean radiance, Metropolis:        {:.5} ± {:.5}", mean.mean, mean.stderr);
    println!("mean radiance, plain Monte Carlo: {:.5} ± {:.5}", plain.mean, plain.stderr);
    println!("difference: {z:+.2} standard errors; {:.0} % of the mutations accepted", 100.0 * acceptance);
    Ok(())
}

/// The image, with its mean at one more site, and the share of accepted mutations.
fn metropolis() -> Result<(Film<1>, f64), SetupError> {
    let share = Share { mutations: 20_000, samples: 5_000 };
    let strata: Vec<_> = (0..GRID * GRID).map(|i| (LampCell { column: i % GRID, row: i / GRID }, share)).collect();
    let (mixture, importance) = (Mixture::new(vec![Step::Small, Step::Large]), |path: &Numbers| path.radiance);
    let metropolis = Metropolis::new(&strata, &mixture, &importance, 1)?;
    let mut sums = Accumulated::new(Film::new(PIXELS + 1, 1.0));
    render(&metropolis, 0..24, &mut sums, &mut |_, _| ControlFlow::Continue(()));
    let (film, tally) = sums.into_parts();
    let total = tally.total();
    let accepted: u64 = total.mutations.iter().map(|m| m.accepted).sum();
    tally.warnings().iter().for_each(|warning| println!("warning: {warning}"));
    Ok((film, accepted as f64 / total.steps() as f64))
}

/// The mean of the image from independent numbers.
fn plain_monte_carlo(samples: u64) -> Pixel {
    let mut rng = generator(2, Purpose::Image, 0, 0, 0);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..samples {
        let radiance = Numbers::evaluate(std::array::from_fn(|_| uniform(&mut rng))).radiance;
        sum += radiance;
        squares += radiance * radiance;
    }
    let n = samples as f64;
    let mean = sum / n;
    Pixel { mean, stderr: ((squares / n - mean * mean) / (n - 1.0)).sqrt() }
}

// What the engine asks for.

/// Eight numbers, and the path that they make: film point, lamp point seen from the first surface, direction of the
/// bounce, lamp point seen from the second surface.
#[derive(Clone)]
struct Numbers {
    u: [f64; 8],
    pixel: u32,
    /// Contribution over density of the path, so that its mean over uniform numbers is the image's mean radiance.
    radiance: f64,
}

impl Numbers {
    fn evaluate(u: [f64; 8]) -> Self {
        let column = (u[0] * f64::from(WIDTH)) as u32;
        let row = (u[1] * f64::from(HEIGHT)) as u32;
        let pixel = row.min(HEIGHT - 1) * WIDTH + column.min(WIDTH - 1);
        Self { u, pixel, radiance: radiance(&u) }
    }
}

impl Path for Numbers {
    type Splat = Splat<1>;

    fn splats(&self) -> impl Iterator<Item = Splat<1>> {
        let pixel = Splat { site: self.pixel, value: [self.radiance * f64::from(PIXELS)] };
        [pixel, Splat { site: PIXELS, value: [self.radiance] }].into_iter()
    }
}

/// The paths whose first lamp point lies in one square of the lamp.
struct LampCell {
    column: u32,
    row: u32,
}

impl LampCell {
    /// Independent numbers, with those of the first lamp point mapped into the cell.
    fn draw(&self, rng: &mut impl Rng) -> Numbers {
        let mut u: [f64; 8] = std::array::from_fn(|_| uniform(rng));
        u[2] = (f64::from(self.column) + u[2]) / f64::from(GRID);
        u[3] = (f64::from(self.row) + u[3]) / f64::from(GRID);
        Numbers::evaluate(u)
    }
}

impl Stratum<Numbers> for LampCell {
    fn contains(&self, path: &Numbers) -> bool {
        let cell = |u: f64| ((u * f64::from(GRID)) as u32).min(GRID - 1);
        cell(path.u[2]) == self.column && cell(path.u[3]) == self.row
    }

    fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&Numbers, f64)) {
        visit(&self.draw(rng), self.power());
    }

    fn density(&self, _: &Numbers) -> f64 {
        f64::from(GRID * GRID)
    }

    fn power(&self) -> f64 {
        1.0 / f64::from(GRID * GRID)
    }
}

/// Both kinds of step have T(y→x) = T(x→y).
enum Step {
    /// Every number moves a little, round the ends of [0, 1).
    Small,
    /// All numbers anew, inside the stratum.
    Large,
}

impl Mutation<Numbers, LampCell> for Step {
    fn name(&self) -> &'static str {
        match self {
            Self::Small => "small step",
            Self::Large => "large step",
        }
    }

    fn suitability(&self, _: &Numbers) -> f64 {
        match self {
            Self::Small => 0.7,
            Self::Large => 0.3,
        }
    }

    fn propose(&self, x: &Numbers, y: &mut Numbers, within: &LampCell, rng: &mut impl Rng) -> Option<f64> {
        *y = match self {
            Self::Small => Numbers::evaluate(x.u.map(|u| (u + nudge(rng)).rem_euclid(1.0))),
            Self::Large => within.draw(rng),
        };
        Some(1.0)
    }
}

/// ±2⁻⁴ to ±2⁻¹⁰, the logarithm uniform.
fn nudge(rng: &mut impl Rng) -> f64 {
    (-4.0 - 6.0 * uniform(rng)).exp2() * if uniform(rng) < 0.5 { -1.0 } else { 1.0 }
}

// The renderer.

#[derive(Clone, Copy)]
struct V([f64; 3]);

fn add(a: V, s: f64, b: V) -> V {
    V(std::array::from_fn(|i| a.0[i] + s * b.0[i]))
}

fn dot(a: V, b: V) -> f64 {
    (0..3).map(|i| a.0[i] * b.0[i]).sum()
}

fn cross(V(a): V, V(b): V) -> V {
    V([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
}

fn unit(a: V) -> V {
    add(V([0.0; 3]), 1.0 / dot(a, a).sqrt(), a)
}

/// Centre, radius and reflectance; below them the plane y = 0.
const SPHERES: [(V, f64, f64); 3] =
    [(V([-1.3, 0.8, 0.0]), 0.8, 0.8), (V([0.6, 1.0, -0.9]), 1.0, 0.5), (V([0.8, 0.4, 0.9]), 0.4, 0.9)];
const PLANE_REFLECTANCE: f64 = 0.6;
/// The lamp: y = 4, |x| < 1, |z| < 1, shining down.
const LAMP_HEIGHT: f64 = 4.0;
const LAMP_RADIANCE: f64 = 12.0;
const LAMP_AREA: f64 = 4.0;

/// Where a ray meets a diffuse surface, the normal there on the ray's side, and the reflectance.
struct Surface {
    point: V,
    normal: V,
    reflectance: f64,
}

/// Radiance along the camera ray through (u₀, u₁), from one lamp point and one bounce.
fn radiance(u: &[f64; 8]) -> f64 {
    let (eye, half) = (V([0.0, 2.2, 6.0]), 0.42);
    let (x, y) = (2.0 * u[0] - 1.0, 1.0 - 2.0 * u[1]);
    let aspect = f64::from(WIDTH) / f64::from(HEIGHT);
    let Some(first) = intersect(eye, unit(V([half * aspect * x, half * y - 0.25, -1.0]))) else {
        return 0.0;
    };
    let bounce = cosine_hemisphere(first.normal, u[4], u[5]);
    let indirect = intersect(add(first.point, 1e-6, first.normal), bounce).map_or(0.0, |s| direct(&s, u[6], u[7]));
    direct(&first, u[2], u[3]) + first.reflectance * indirect
}

/// Light that a surface reflects from one point of the lamp, over that point's density: L ρ/π cosθ cosθ′ A / d².
fn direct(surface: &Surface, u: f64, v: f64) -> f64 {
    let lamp = V([2.0 * u - 1.0, LAMP_HEIGHT, 2.0 * v - 1.0]);
    let to_lamp = add(lamp, -1.0, surface.point);
    let square = dot(to_lamp, to_lamp);
    let direction = unit(to_lamp);
    let cosines = dot(surface.normal, direction).max(0.0) * direction.0[1].max(0.0);
    let from = add(surface.point, 1e-6, surface.normal);
    if cosines == 0.0 || SPHERES.iter().any(|s| sphere(from, direction, s).is_some_and(|t| t * t < square)) {
        return 0.0;
    }
    LAMP_RADIANCE * surface.reflectance / PI * cosines * LAMP_AREA / square
}

fn intersect(from: V, direction: V) -> Option<Surface> {
    let plane = -from.0[1] / direction.0[1];
    let mut nearest = if plane > 0.0 { plane } else { f64::INFINITY };
    let mut hit = None;
    for s in &SPHERES {
        if let Some(t) = sphere(from, direction, s).filter(|&t| t < nearest) {
            (nearest, hit) = (t, Some(s));
        }
    }
    let point = add(from, nearest, direction);
    match hit {
        Some(&(centre, _, reflectance)) => Some(Surface { point, normal: unit(add(point, -1.0, centre)), reflectance }),
        None => {
            nearest.is_finite().then_some(Surface { point, normal: V([0.0, 1.0, 0.0]), reflectance: PLANE_REFLECTANCE })
        }
    }
}

/// Distance to a sphere from outside it.
fn sphere(from: V, direction: V, &(centre, radius, _): &(V, f64, f64)) -> Option<f64> {
    let offset = add(from, -1.0, centre);
    let b = dot(offset, direction);
    let discriminant = b * b - dot(offset, offset) + radius * radius;
    let t = -b - discriminant.max(0.0).sqrt();
    (discriminant > 0.0 && t > 0.0).then_some(t)
}

/// A direction with density cosθ/π about the unit vector n.
fn cosine_hemisphere(n: V, u: f64, v: f64) -> V {
    let s = unit(cross(n, if n.0[0].abs() < 0.5 { V([1.0, 0.0, 0.0]) } else { V([0.0, 1.0, 0.0]) }));
    let (r, angle) = (u.sqrt(), 2.0 * PI * v);
    add(add(add(V([0.0; 3]), r * angle.cos(), s), r * angle.sin(), cross(n, s)), (1.0 - u).sqrt(), n)
}

// What to do with the film.

/// sRGB's transfer function, roughly: x^(1/2.2).
fn encode(film: &Film<1>, pixel: u32) -> f64 {
    film.pixel(pixel as usize)[0].mean.clamp(0.0, 1.0).powf(1.0 / 2.2)
}

fn ppm(film: &Film<1>) -> String {
    let grey = |pixel| ((encode(film, pixel) * 255.0).round() as u8).to_string();
    let pixels: Vec<_> = (0..PIXELS).map(|pixel| [grey(pixel), grey(pixel), grey(pixel)].join(" ")).collect();
    format!("P3\n{WIDTH} {HEIGHT}\n255\n{}\n", pixels.join("\n"))
}

/// Two rows of pixels a line, since a character is twice as high as it is wide.
fn ascii(film: &Film<1>) -> String {
    const INK: &[u8] = b" .:-=+*#%@";
    let shade = |pixel| {
        let value = 0.5 * (encode(film, pixel) + encode(film, pixel + WIDTH));
        char::from(INK[((value * INK.len() as f64) as usize).min(INK.len() - 1)])
    };
    let line = |row: u32| (0..WIDTH).map(|x| shade(2 * row * WIDTH + x)).chain(['\n']).collect::<String>();
    (0..HEIGHT / 2).map(line).collect()
}

#[test]
fn both_ways_have_one_mean() {
    let (film, _) = metropolis().expect("sound strata");
    let ([mean], plain) = (film.pixel(PIXELS as usize), plain_monte_carlo(400_000));
    assert!((mean.mean - plain.mean).abs() < 5.0 * mean.stderr.hypot(plain.stderr), "{mean:?}, {plain:?}");
}
