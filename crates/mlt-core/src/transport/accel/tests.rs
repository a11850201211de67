use super::*;
use crate::instructions::Portable;
use rand_pcg::Pcg32;
use rand_pcg::rand_core::{Rng, SeedableRng};
use std::f32::consts::TAU;

type Triangle = [Vec3; 3];

/// How many rays a watertightness test sends at each mesh. Miri takes a tenth of a second for one.
const RAYS: usize = if cfg!(miri) {
    12
} else if cfg!(debug_assertions) {
    5_000
} else {
    100_000
};

/// `count`, or in Miri so many fewer.
const fn or_in_miri(count: usize, fewer: usize) -> usize {
    if cfg!(miri) { fewer } else { count }
}

fn uniform(rng: &mut Pcg32) -> f32 {
    (rng.next_u32() >> 8) as f32 / 16_777_216.0
}

fn in_cube(rng: &mut Pcg32) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| 2.0 * uniform(rng) - 1.0))
}

fn soup(count: usize, size: f32, rng: &mut Pcg32) -> Vec<Triangle> {
    (0..count)
        .map(|_| {
            let centre = in_cube(rng);
            [0; 3].map(|_| centre + size * in_cube(rng))
        })
        .collect()
}

fn random_ray(rng: &mut Pcg32) -> Ray {
    Ray { origin: 1.5 * in_cube(rng), direction: in_cube(rng), t_max: if uniform(rng) < 0.5 { 1.0 } else { 1e30 } }
}

/// A closed mesh: a grid over two angles, periodic in both (torus) or closed at the poles (sphere).
fn closed_mesh(n: usize, m: usize, surface: impl Fn(usize, usize) -> Vec3) -> Vec<Triangle> {
    let quad = |i: usize, j: usize| {
        let (a, b, c, d) = (surface(i, j), surface(i + 1, j), surface(i + 1, j + 1), surface(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    (0..n).flat_map(|i| (0..m).flat_map(move |j| [(i, j)])).flat_map(|(i, j)| quad(i, j)).collect()
}

fn sphere(n: usize) -> Vec<Triangle> {
    closed_mesh(n, 2 * n, |i, j| {
        let (theta, phi) = (TAU / 2.0 * i as f32 / n as f32, TAU * (j % (2 * n)) as f32 / (2 * n) as f32);
        let radius = if i % n == 0 { 0.0 } else { theta.sin() };
        Vec3::new(radius * phi.cos(), radius * phi.sin(), theta.cos())
    })
}

fn torus(n: usize) -> Vec<Triangle> {
    closed_mesh(n, n, |i, j| {
        let (a, b) = (TAU * (i % n) as f32 / n as f32, TAU * (j % n) as f32 / n as f32);
        Vec3::new((1.0 + 0.3 * b.cos()) * a.cos(), (1.0 + 0.3 * b.cos()) * a.sin(), 0.3 * b.sin())
    })
}

/// t of the plane hit and the least barycentric weight (negative: outside), in f64.
fn reference(triangle: &Triangle, ray: &Ray) -> (f64, f64) {
    let [a, b, c] = triangle.map(|v| v.as_dvec3());
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (e1, e2, s) = (b - a, c - a, o - a);
    let det = d.cross(e2).dot(e1);
    let (u, v) = (d.cross(e2).dot(s) / det, s.cross(e1).dot(d) / det);
    (s.cross(e1).dot(e2) / det, u.min(v).min(1.0 - u - v))
}

#[test]
fn agrees_with_brute_force() {
    let mut rng = Pcg32::seed_from_u64(1);
    for (count, size) in [(1, 1.0), (9, 0.7), (300, 0.3), (3000, 0.1)] {
        let triangles = soup(count, size, &mut rng);
        let accel = Accel::new(&triangles);
        for _ in 0..600 {
            let ray = random_ray(&mut rng);
            let nearest = |slack: f64| {
                triangles
                    .iter()
                    .map(|t| reference(t, &ray))
                    .filter(|&(t, inside)| t > 0.0 && t <= f64::from(ray.t_max) && inside >= slack)
                    .fold(f64::INFINITY, |least, (t, _)| least.min(t))
            };
            let t = accel.closest(&ray).map_or(f64::INFINITY, |hit| f64::from(hit.t));
            let close = |reference: f64| t == reference || (t - reference).abs() < 1e-5 * (1.0 + t.abs());
            assert!(close(nearest(0.0)) || close(nearest(-1e-5)) || close(nearest(1e-5)), "{ray:?} {t}");
        }
    }
}

#[test]
fn closed_meshes_do_not_leak() {
    let mut rng = Pcg32::seed_from_u64(2);
    let mut leaks = 0;
    for (mesh, inside) in [(sphere(40), Vec3::ZERO), (torus(60), Vec3::X)] {
        for (scale, offset) in [(1e-4, 0.0), (1.0, 0.0), (1e5, 0.0), (1.0, 1e5), (1e5, 1e5)] {
            let place = |v: Vec3| scale * v + Vec3::new(offset, -offset, offset);
            let triangles: Vec<Triangle> = mesh.iter().map(|t| t.map(place)).collect();
            let accel = Accel::new(&triangles);
            for k in 0..RAYS {
                let [a, b, _] = triangles[rng.next_u32() as usize % triangles.len()];
                let target = if k % 2 == 0 { a } else { a.lerp(b, uniform(&mut rng)) };
                let origin = place(inside + 0.1 * in_cube(&mut rng));
                let ray = Ray::new(origin, target - origin);
                leaks += usize::from(accel.closest(&ray).is_none()) + usize::from(!accel.occluded(&ray));
            }
        }
    }
    assert_eq!(leaks, 0);
}

#[test]
fn a_hole_is_seen() {
    let mut open = sphere(40);
    let mut rng = Pcg32::seed_from_u64(3);
    let removed = open.swap_remove(1000);
    let target = (removed[0] + removed[1] + removed[2]) / 3.0;
    let accel = Accel::new(&open);
    assert!((0..100).all(|_| {
        let origin = 0.1 * in_cube(&mut rng);
        accel.closest(&Ray::new(origin, target - origin)).is_none()
    }));
}

#[test]
fn axis_parallel_rays_hit_in_the_faces_of_boxes() {
    let corner = |i: usize, j: usize| Vec3::new(i as f32, j as f32, 0.0);
    let accel = Accel::new(&closed_mesh(16, 16, corner));
    for (i, j) in (0..=32).flat_map(|i| (0..=32).map(move |j| (i, j))) {
        let origin = Vec3::new(0.5 * i as f32, 0.5 * j as f32, 3.0);
        let hit = accel.closest(&Ray::new(origin, Vec3::NEG_Z)).expect("a grid without gaps");
        assert_eq!(hit.t, 3.0);
        assert!(accel.occluded(&Ray::new(origin, Vec3::new(0.0, -0.0, -1e-3))));
    }
}

#[test]
fn a_far_origin_still_hits() {
    let accel = Accel::new(&sphere(40));
    let mut rng = Pcg32::seed_from_u64(4);
    for _ in 0..RAYS {
        let origin = 1e4 * in_cube(&mut rng).normalize();
        let target = 0.99 * in_cube(&mut rng).normalize();
        assert!(accel.closest(&Ray::new(origin, target - origin)).is_some());
    }
}

#[test]
fn both_instruction_sets_give_the_same_bits() {
    let mut rng = Pcg32::seed_from_u64(5);
    let mut triangles = soup(or_in_miri(4000, 20), 0.1, &mut rng);
    triangles.extend(torus(or_in_miri(30, 3)));
    // Ties: neighbours that overlap exactly in part.
    triangles.extend((0..or_in_miri(50, 5)).map(|i| [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0 + i as f32, 0.0)]));
    let fast = Accel::new(&triangles);
    let portable = Accel { instructions: InstructionSet::Portable(Portable), ..Accel::new(&triangles) };
    let bits = |hit: Option<Hit>| hit.map(|h| (h.primitive, h.t.to_bits(), h.u.to_bits(), h.v.to_bits()));
    for _ in 0..RAYS {
        let ray = random_ray(&mut rng);
        assert_eq!(bits(fast.closest(&ray)), bits(portable.closest(&ray)));
        assert_eq!(fast.occluded(&ray), portable.occluded(&ray));
    }
}

#[test]
fn any_hit_agrees_with_the_nearest() {
    let mut rng = Pcg32::seed_from_u64(6);
    let accel = Accel::with_quality(&soup(500, 0.2, &mut rng), Quality::Fast);
    let mut hits = 0;
    for _ in 0..RAYS {
        let ray = random_ray(&mut rng);
        hits += usize::from(accel.occluded(&ray));
        assert_eq!(accel.occluded(&ray), accel.closest(&ray).is_some());
    }
    assert!(hits > RAYS / 10 && hits < RAYS * 9 / 10);
}

#[test]
fn the_range_leaves_out_zero_and_takes_in_the_end() {
    let accel = Accel::new(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
    let ray = |z: f32, t_max: f32| Ray { origin: Vec3::new(0.25, 0.25, z), direction: Vec3::NEG_Z, t_max };
    assert!(accel.closest(&ray(0.0, 9.0)).is_none());
    assert_eq!(accel.closest(&ray(1.0, 1.0)), Some(Hit { primitive: 0, t: 1.0, u: 0.25, v: 0.25 }));
    assert!(accel.closest(&ray(1.0, 1.0f32.next_down())).is_none());
    assert!(!accel.occluded(&ray(1.0, 0.0)));
}

#[test]
fn the_length_of_the_direction_does_not_matter() {
    let accel = Accel::new(&sphere(20));
    let ray = |direction: Vec3| Ray::new(Vec3::new(0.1, 0.2, 0.0), direction);
    let t = accel.closest(&ray(Vec3::Z)).expect("inside a sphere").t;
    for exponent in -120..=120 {
        let length = 2f32.powi(exponent);
        assert_eq!(accel.closest(&ray(length * Vec3::Z)).map(|hit| hit.t), Some(t / length));
    }
    let subnormal = f32::from_bits(1);
    assert!(accel.occluded(&ray(subnormal * Vec3::Z)));
}

#[test]
fn the_hit_point_is_the_same_by_t_and_by_weights() {
    let mut rng = Pcg32::seed_from_u64(7);
    // Slivers: 10⁴ times as long as they are wide.
    let slivers: Vec<Triangle> =
        soup(2000, 1.0, &mut rng).into_iter().map(|[a, b, c]| [a, b, b.lerp(a, 0.3) + 1e-4 * c]).collect();
    let accel = Accel::new(&slivers);
    let mut hits = 0;
    for k in 0..RAYS {
        let [a, b, c] = slivers[k % slivers.len()];
        let origin = 3.0 * in_cube(&mut rng);
        let ray = Ray::new(origin, 0.3 * a + 0.3 * b + 0.4 * c - origin);
        let Some(hit) = accel.closest(&ray) else { continue };
        hits += 1;
        assert!(hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.0 && hit.t > 0.0);
        let [a, b, c] = slivers[hit.primitive as usize];
        let by_weights = a + hit.u * (b - a) + hit.v * (c - a);
        assert!(by_weights.distance(ray.origin + hit.t * ray.direction) < 5e-6, "{hit:?}");
    }
    assert!(hits > RAYS * 9 / 10);
}

#[test]
fn bad_input_is_a_miss() {
    let ray = Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z);
    assert!(Accel::new(&[]).closest(&ray).is_none() && !Accel::new(&[]).occluded(&ray));
    let good = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let bad = [f32::NAN, f32::INFINITY, 1e38].map(|x| [Vec3::ZERO, Vec3::X, Vec3::new(0.0, x, 0.0)]);
    let accel = Accel::new(&[bad[0], bad[1], bad[2], [Vec3::ONE; 3], good]);
    assert_eq!(accel.closest(&ray).map(|hit| hit.primitive), Some(4));
    assert!(Accel::new(&bad).closest(&ray).is_none());
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let (mut origin, mut direction) = (ray, ray);
            origin.origin[axis] = value;
            direction.direction[axis] = value;
            assert!(accel.closest(&origin).is_none() && accel.closest(&direction).is_none());
        }
    }
    assert!(accel.closest(&Ray { direction: Vec3::ZERO, ..ray }).is_none());
    assert!(accel.closest(&Ray { t_max: f32::NAN, ..ray }).is_none());
    assert!(accel.closest(&Ray { t_max: -1.0, ..ray }).is_none());
}

#[test]
fn of_coincident_triangles_the_first_is_hit() {
    let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut triangles = vec![[a - Vec3::Z, b - Vec3::Z, c - Vec3::Z]];
    triangles.extend((0..100_000).map(|i| [[a, b, c], [b, c, a], [c, b, a]][i % 3]));
    let hit = Accel::new(&triangles).closest(&Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z));
    assert_eq!(hit.map(|hit| hit.primitive), Some(1));
}

/// A tree that was changed in a way that walks must not depend on.
fn same_hits_after(change: impl FnOnce(&mut Accel)) {
    let mut rng = Pcg32::seed_from_u64(8);
    let triangles = soup(or_in_miri(500, 250), 0.2, &mut rng);
    let (plain, mut changed) = (Accel::new(&triangles), Accel::new(&triangles));
    change(&mut changed);
    for _ in 0..RAYS {
        let ray = random_ray(&mut rng);
        assert_eq!(changed.closest(&ray), plain.closest(&ray));
    }
}

#[test]
fn a_tree_too_deep_for_the_local_stack_gives_the_same_hits() {
    same_hits_after(|accel| (accel.tree.depth, accel.kind) = (10_000, Kind::Any));
}

#[test]
fn a_tree_that_is_asked_for_ahead_of_its_use_gives_the_same_hits() {
    same_hits_after(|accel| accel.tree.is_large = true);
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let triangles = soup(20_000, 0.05, &mut Pcg32::seed_from_u64(9));
    let layout = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let tree = pool.install(|| Accel::new(&triangles)).tree;
        let planes: Vec<_> = tree.nodes.iter().map(|n| (n.planes.map(|p| p.0.map(f32::to_bits)), n.children)).collect();
        (planes, tree.blocks.iter().map(|b| b.primitives).collect::<Vec<_>>())
    };
    let one = layout(1);
    assert!([2, 3, 8].iter().all(|&threads| layout(threads) == one));
}

/// `count` wedges of a disc, which all meet in its centre.
fn fan(count: usize) -> Vec<Triangle> {
    let rim = |i: usize| {
        let (sin, cos) = (TAU * (i % count) as f32 / count as f32).sin_cos();
        Vec3::new(cos, sin, 0.0)
    };
    (0..count).map(|i| [Vec3::ZERO, rim(i), rim(i + 1)]).collect()
}

/// `count` copies of a shape around one point, each a little larger than the last.
fn nest(shape: &[Triangle], count: usize) -> Vec<Triangle> {
    let grown = |i: usize| shape.iter().map(move |t| t.map(|v| (1.0 + 1e-6 * i as f32) * v));
    (0..count).flat_map(grown).collect()
}

/// Levels stay few where boxes lie one in the other; one pair a pass would make a tree of thousands of levels, in quadratic time.
#[test]
fn nearly_coincident_triangles_make_a_shallow_tree() {
    let count = if cfg!(debug_assertions) { 5_000 } else { 50_000 };
    let mut rng = Pcg32::seed_from_u64(10);
    let [a, b, c] = [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.1), Vec3::new(0.0, 1.0, 0.2)];
    let jittered = (0..count).map(|_| [a, b, c].map(|v| v + 1e-6 * in_cube(&mut rng))).collect();
    let mixed = [soup(count, 0.1, &mut rng), fan(count)].concat();
    let shapes = [
        ("fan", fan(count)),
        ("nest", nest(&[[a, b, c]], count)),
        ("nest of quads", nest(&[[a, b, c], [c, b, Vec3::new(2.0, 1.0, 0.3)]], count / 2)),
        ("nest of spheres", nest(&sphere(4), count / 64)),
        ("jittered", jittered),
        ("fan in a soup", mixed),
    ];
    for (name, triangles) in shapes {
        for quality in [Quality::Fast, Quality::Medium] {
            let depth = Accel::with_quality(&triangles, quality).tree.depth;
            assert!(depth < 100, "{name}, {quality:?}: {depth} levels");
        }
    }
}

/// Half-width of the plain, of which small triangles next to it make its triangles coarse.
const PLAIN: f32 = 1e6;

/// Two triangles that meet in the origin, in a plane that is not axis-parallel, and a small one below them if asked for.
fn plain(with_detail: bool) -> Vec<Triangle> {
    let at = |x: f32, z: f32| PLAIN * Vec3::new(x, 0.25 * x - 0.125 * z, z);
    let [a, b, c, d] = [at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0)];
    let detail = [Vec3::NEG_Y, Vec3::new(0.1, -1.0, 0.0), Vec3::new(0.0, -1.0, 0.1)];
    [vec![[a, b, c], [a, c, d]], if with_detail { vec![detail] } else { Vec::new() }].concat()
}

/// Share of rays, some towards and some away from the plain from a little above it, that get the wrong answer.
fn wrong_share(accel: &Accel) -> f64 {
    let mut rng = Pcg32::seed_from_u64(11);
    let up = Vec3::new(-0.25, 1.0, 0.125).normalize();
    let rays = 20_000;
    let wrong = (0..rays).filter(|_| {
        let [x, z] = [0; 2].map(|_| 4.0 * uniform(&mut rng) - 2.0);
        let origin = Vec3::new(x, 0.25 * x - 0.125 * z, z) + (1e-4 + 0.1 * uniform(&mut rng)) * up;
        let ray = Ray::new(origin, in_cube(&mut rng).normalize());
        let normal = glam::DVec3::new(-0.25, 1.0, 0.125);
        let falls = ray.direction.as_dvec3().dot(normal);
        let t = -origin.as_dvec3().dot(normal) / falls;
        match accel.closest(&ray) {
            // Where a ray grazes the plain, t is that of the outline's nearest point.
            _ if falls.abs() < 0.05 => false,
            Some(hit) => falls > 0.0 || (f64::from(hit.t) - t).abs() > 1e-5 * t || !accel.occluded(&ray),
            None => falls < 0.0 || accel.occluded(&ray),
        }
    });
    wrong.count() as f64 / f64::from(rays)
}

/// Control: without detail to compare them with, the same triangles are not coarse, and f32 is not enough.
#[test]
fn t_is_right_near_the_middle_of_a_triangle_of_any_size() {
    assert_eq!(wrong_share(&Accel::new(&plain(true))), 0.0);
    assert!(wrong_share(&Accel::new(&plain(false))) > 0.1);
}
