//! The different directions that light comes from to the surroundings of a place, whichever share of it each has.
//!
//! Several mirrors show a lamp to a place by the same events. The photons of a small leaf tell of the brightest of its images, and may miss another
//! until a path finds it by chance, with the weight of all that did not. So the photons of a larger part of a surface are parted by directions, and each
//! cluster has the same probability. Source: [Gonzalez85], centres of clusters that are as far apart as half of the best.

use super::fit::{FEWEST, Fit};
use super::lobe::Lobe;
use super::place::Photon;
use glam::Vec3A;

/// Most clusters.
const MOST: usize = 16;

/// Photons with similar directions.
#[derive(Clone, Copy, Debug)]
enum Cluster {
    Many(Fit),
    /// The centre of a few.
    Few(Photon),
}

/// Clusters of photons.
#[derive(Clone, Debug)]
pub(super) struct Clusters(Vec<Cluster>);

impl Clusters {
    /// Of one photon or more.
    pub(super) fn new(photons: &[Photon]) -> Self {
        let directions: Vec<_> = photons.iter().map(Photon::direction).collect();
        // Of each photon: the centre nearest to it, and the square of the distance.
        let mut nearest = vec![(0, f32::INFINITY); photons.len()];
        let (mut centres, mut farthest) = (Vec::with_capacity(MOST), 0);
        while centres.len() < MOST && nearest[farthest].1 > 0.0 {
            for (direction, nearest) in directions.iter().zip(&mut nearest) {
                let square = direction.distance_squared(directions[farthest]);
                if square < nearest.1 {
                    *nearest = (centres.len(), square);
                }
            }
            centres.push(farthest);
            let distance = |&i: &usize| nearest[i].1;
            farthest = (0..photons.len()).reduce(|a, b| if distance(&b) > distance(&a) { b } else { a }).unwrap_or(0);
        }
        let cluster = |(number, centre): (usize, &usize)| {
            let of_it = photons.iter().zip(&nearest).filter(|(_, (of, _))| *of == number);
            let of_it: Vec<_> = of_it.map(|(photon, _)| *photon).collect();
            let many = of_it.len() >= FEWEST;
            if many { Cluster::Many(Fit::new(&of_it)) } else { Cluster::Few(photons[*centre]) }
        };
        Self(centres.iter().enumerate().map(cluster).collect())
    }

    /// The lobe of one of them, if `chosen` is uniform in [0, 1).
    pub(super) fn lobe(&self, chosen: f32, x: Vec3A) -> Lobe {
        self.0[(chosen * self.0.len() as f32) as usize].lobe(x)
    }

    /// The density of directions from lobes of clusters that are chosen evenly, sr⁻¹.
    pub(super) fn density(&self, x: Vec3A, direction: Vec3A) -> f32 {
        self.0.iter().map(|cluster| cluster.lobe(x).density(direction)).sum::<f32>() / self.0.len() as f32
    }
}

impl Cluster {
    fn lobe(&self, x: Vec3A) -> Lobe {
        match self {
            Self::Many(fit) => fit.lobe(x),
            Self::Few(photon) => photon.lobe(x),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::place::Place;
    use super::*;
    use crate::engine::{Purpose, generator, uniform_f32};
    use crate::transport::geometry::math::unit;

    /// One of a hundred photons comes from another mirror: its direction is as likely as those of a sixteenth of all.
    #[test]
    fn rare_directions_are_likely() {
        let image =
            |i: u64| if i.is_multiple_of(100) { Vec3A::new(-3.0, 1.0, 0.0) } else { Vec3A::new(0.2, 3.0, -0.1) };
        let photon = |i: u64| {
            let rng = &mut generator(2, Purpose::Sample, 0, 0, i);
            let position = Vec3A::new(uniform_f32(rng), 0.0, uniform_f32(rng)) * 0.2;
            Photon { at: Place { position, normal: Vec3A::Y }, from: position + 0.5 * (image(i) - position) }
        };
        let photons: Vec<_> = (0..200).map(photon).collect();
        let (clusters, x) = (Clusters::new(&photons), Vec3A::new(0.07, 0.0, 0.13));
        for i in [0, 1] {
            let density = clusters.density(x, unit(image(i) - x));
            assert!(density > 1.0, "{i}: {density}");
        }
        assert_eq!(clusters.0.len(), MOST);
    }
}
