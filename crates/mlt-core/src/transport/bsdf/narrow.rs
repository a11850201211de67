//! Narrow lobes of microfacets, in the slope of the microfacet that joins two directions.
//!
//! A microfacet with the unit normal h mirrors or refracts one direction, a, into the other, b. Its slope in widths of the lobe is
//!
//! m = (h·s, h·t)/(α h·n),   dm = dω_h/(α² (h·n)³),
//!
//! with tangents s and t. While a stays, b changes with h:
//!
//! * dω_h/dω_b = 1/(4 |h·b|) where it mirrors,
//! * dω_h/dω_b = η_b² |h·b|/|η_a a + η_b b|² where it refracts.
//!
//! Sources: [Walter07]; slopes as coordinates of a path: [KaplanyanHanikaDachsbacher14].

use super::fresnel::{reflect, refract};
use super::microfacet::{GRAZING, Ggx};
use super::rough_thin::through;
use super::{Bsdf, Lobe, Mix};
use crate::transport::geometry::math::{frame, unit};
use glam::{Vec2, Vec3A};

/// Largest α of a lobe that counts as narrow: a direction turned by an angle seldom stays in it (docs/log/mutations.md).
const WIDEST: f32 = 0.006;
/// Largest slope, in widths, that counts as within a lobe; 94 % of what it scatters of a direction along n.
const STEEPEST: f32 = 4.0;

/// A lobe of narrow width.
#[derive(Clone, Copy, Debug)]
pub struct NarrowLobe {
    /// α.
    alpha: f32,
    behind: Behind,
}

/// Where light goes that passes.
#[derive(Clone, Copy, Debug)]
enum Behind {
    /// Nowhere.
    Nothing,
    /// On, as if mirrored and then moved to the other side.
    ThinWall,
    /// Into a medium of this index.
    Medium(f32),
}

/// A microfacet of a lobe that joins two directions.
#[derive(Clone, Copy, Debug)]
pub struct Microfacet {
    /// m.
    pub slope: Vec2,
    /// Whether it refracts.
    pub transmits: bool,
}

impl Microfacet {
    /// The same microfacet with another slope; `None` outside the lobe.
    pub fn with_slope(self, slope: Vec2) -> Option<Self> {
        (slope.length_squared() <= STEEPEST * STEEPEST).then_some(Self { slope, ..self })
    }
}

impl NarrowLobe {
    fn new(ggx: Ggx, behind: Behind) -> Option<Self> {
        (ggx.alpha <= WIDEST).then_some(Self { alpha: ggx.alpha, behind })
    }

    /// The microfacet that joins two directions, whichever is given; `None`: none within the lobe.
    pub fn microfacet(&self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Microfacet> {
        let transmits = n.dot(a) * n.dot(b) < 0.0;
        let h = unit(self.joining(n, a, b)?);
        let (s, t) = frame(n);
        let slope = Vec2::new(h.dot(s), h.dot(t)) / (self.alpha * h.dot(n));
        Microfacet { slope, transmits }.with_slope(slope)
    }

    /// The direction that a microfacet joins to `given`; `None`: it would end on the wrong side.
    pub fn direction(&self, n: Vec3A, given: Vec3A, microfacet: Microfacet) -> Option<Vec3A> {
        let side = 1f32.copysign(n.dot(given));
        let mirrored = microfacet.transmits && matches!(self.behind, Behind::ThinWall);
        // A thin wall mirrors what comes to its front; the direction on the back is moved there.
        let from = if mirrored && side < 0.0 { through(n, given) } else { given };
        let (s, t) = frame(n);
        let [x, y] = (self.alpha * microfacet.slope).to_array();
        let h = unit(x * s + y * t + n) * 1f32.copysign(n.dot(from));
        if from.dot(h) <= 0.0 {
            return None;
        }
        let direction = match self.behind {
            _ if !microfacet.transmits => reflect(from, h),
            Behind::Nothing => return None,
            Behind::ThinWall if side > 0.0 => through(n, reflect(from, h)),
            Behind::ThinWall => reflect(from, h),
            Behind::Medium(ior) => refract(from, h, eta(ior, -side) / eta(ior, side))?,
        };
        let other = if microfacet.transmits { -side } else { side };
        (n.dot(direction) * other > GRAZING).then_some(direction)
    }

    /// dm/dω of `sampled` while `given` stays, sr⁻¹; 0 where no microfacet joins them.
    pub fn slopes_per_solid_angle(&self, n: Vec3A, given: Vec3A, sampled: Vec3A) -> f64 {
        let Some(sum) = self.joining(n, given, sampled) else { return 0.0 };
        let h = unit(sum);
        let cos = f64::from(h.dot(n));
        let per_normal = match self.behind {
            Behind::Medium(ior) if n.dot(given) * n.dot(sampled) < 0.0 => {
                let eta = eta(ior, n.dot(sampled));
                eta * eta * h.dot(sampled).abs() / sum.length_squared()
            }
            // 1/(4 |h·b|): the sum of two unit vectors has the length 2 |h·b|.
            _ => 0.5 / sum.length(),
        };
        f64::from(per_normal) / (f64::from(self.alpha).powi(2) * cos * cos * cos)
    }

    /// A multiple of h, on the front, as long as the sum of the two directions in their media; `None`: none joins them.
    fn joining(&self, n: Vec3A, a: Vec3A, b: Vec3A) -> Option<Vec3A> {
        let [ca, cb] = [n.dot(a), n.dot(b)];
        let sum = match self.behind {
            _ if ca * cb > 0.0 => a + b,
            Behind::Nothing => return None,
            Behind::ThinWall => {
                if ca > 0.0 {
                    a + through(n, b)
                } else {
                    through(n, a) + b
                }
            }
            Behind::Medium(ior) => eta(ior, ca) * a + eta(ior, cb) * b,
        };
        let cos = n.dot(sum);
        (cos != 0.0).then_some(sum * 1f32.copysign(cos))
    }
}

/// Index of refraction on the side where n·direction has the sign of `cos`.
fn eta(ior: f32, cos: f32) -> f32 {
    if cos > 0.0 { 1.0 } else { ior }
}

impl Lobe {
    fn narrow(&self) -> Option<NarrowLobe> {
        match self {
            Self::Conductor(metal) => NarrowLobe::new(metal.facets.ggx, Behind::Nothing),
            Self::Glossy(coated) => NarrowLobe::new(coated.coat.facets.ggx, Behind::Nothing),
            Self::RoughDielectric(glass) => NarrowLobe::new(glass.once.ggx, Behind::Medium(glass.once.ior)),
            Self::RoughThin(wall) => NarrowLobe::new(wall.facets.ggx, Behind::ThinWall),
            Self::Lambert(_) | Self::BrushedMetal(_) | Self::BrushedCoat(_) => None,
        }
    }
}

impl Mix {
    /// All of its narrow lobes have the same α: the one that passes light has the reflection of the others.
    fn narrow(&self) -> Option<NarrowLobe> {
        let lobes = || self.lobes.iter().filter_map(|(_, lobe)| lobe.as_ref());
        let passing = lobes().filter(|lobe| lobe.is_transmissive());
        passing.chain(lobes()).find_map(Lobe::narrow)
    }
}

impl Bsdf {
    /// Its narrow lobe.
    pub fn narrow_lobe(&self) -> Option<NarrowLobe> {
        match *self {
            Self::Conductor(b) => Lobe::Conductor(b).narrow(),
            Self::Glossy(b) => Lobe::Glossy(b).narrow(),
            Self::RoughDielectric(b) => Lobe::RoughDielectric(b).narrow(),
            Self::RoughThin(b) => Lobe::RoughThin(b).narrow(),
            Self::Mix(ref mix) => mix.narrow(),
            Self::Layered(ref layered) => {
                let coat = layered.coat.filter(|coat| coat.normal.is_none());
                coat.and_then(|coat| Lobe::Conductor(coat.lobe).narrow()).or_else(|| layered.base.narrow())
            }
            Self::Black | Self::Lambert(_) | Self::Mirror(_) | Self::Dielectric(_) | Self::Thin(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::bsdf::{Conductor, RoughDielectric, RoughThin};
    use crate::transport::colour::Rgb;

    fn lobes() -> [NarrowLobe; 3] {
        let ggx = Ggx { alpha: 0.005 };
        [
            Bsdf::Conductor(Conductor::new(Rgb::ONE, 1.0, ggx)),
            Bsdf::RoughDielectric(RoughDielectric::new(1.5, Rgb::ONE, ggx)),
            Bsdf::RoughThin(RoughThin::new(1.5, Rgb::ONE, ggx)),
        ]
        .map(|bsdf| bsdf.narrow_lobe().expect("narrow"))
    }

    const N: Vec3A = Vec3A::new(0.36, -0.48, 0.8);

    /// Directions on the front and on the back, events, and slopes.
    fn cases() -> impl Iterator<Item = (NarrowLobe, Vec3A, Microfacet)> {
        let (s, t) = frame(N);
        let given = move |side: f32| (side * N + 0.7 * s - 0.4 * t).normalize();
        let slopes = [Vec2::ZERO, Vec2::new(0.5, -1.0), Vec2::new(-3.0, 2.0)];
        lobes().into_iter().flat_map(move |lobe| {
            [1.0, -1.0].into_iter().flat_map(move |side| {
                [false, true]
                    .into_iter()
                    .flat_map(move |transmits| slopes.map(|slope| (lobe, given(side), Microfacet { slope, transmits })))
            })
        })
    }

    #[test]
    fn the_microfacet_that_gives_a_direction_joins_it() {
        let mut joined = 0;
        for (lobe, given, facet) in cases() {
            let Some(direction) = lobe.direction(N, given, facet) else { continue };
            for (a, b) in [(given, direction), (direction, given)] {
                let found = lobe.microfacet(N, a, b).expect("within the lobe");
                assert_eq!(found.transmits, facet.transmits);
                assert!(found.slope.distance(facet.slope) < 1e-2, "{lobe:?}: {found:?} for {facet:?}");
            }
            joined += 1;
        }
        // A metal passes nothing.
        assert_eq!(joined, 30);
    }

    /// |∂b/∂m₁ × ∂b/∂m₂| by differences is the reciprocal of dm/dω.
    #[test]
    fn slopes_per_solid_angle_are_those_of_differences() {
        const STEP: f32 = 0.25;
        for (lobe, given, facet) in cases() {
            let at = |dx: f32, dy: f32| {
                lobe.direction(N, given, Microfacet { slope: facet.slope + Vec2::new(dx, dy), ..facet })
            };
            let Some(direction) = at(0.0, 0.0) else { continue };
            let along = |dx: f32, dy: f32| {
                (at(dx, dy).expect("near") - at(-dx, -dy).expect("near")).as_dvec3() / f64::from(2.0 * STEP)
            };
            let per_slope = along(STEP, 0.0).cross(along(0.0, STEP)).length();
            let product = per_slope * lobe.slopes_per_solid_angle(N, given, direction);
            assert!((product - 1.0).abs() < 5e-3, "{lobe:?}, {facet:?}: {product}");
        }
    }

    #[test]
    fn wide_lobes_and_steep_microfacets_do_not_count() {
        let metal = |alpha| Bsdf::Conductor(Conductor::new(Rgb::ONE, 1.0, Ggx { alpha })).narrow_lobe();
        assert!(metal(0.3).is_none());
        let lobe = metal(0.005).expect("narrow");
        let towards = |angle: f32| Vec3A::new(angle.sin(), 0.0, angle.cos());
        assert!(lobe.microfacet(Vec3A::Z, Vec3A::Z, towards(0.03)).is_some());
        assert!(lobe.microfacet(Vec3A::Z, Vec3A::Z, towards(0.05)).is_none());
    }
}
