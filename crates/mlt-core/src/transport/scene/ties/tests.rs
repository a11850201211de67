use crate::engine::{Purpose, generator, uniform};
use crate::transport::colour::Rgb;
use crate::transport::geometry::{Mesh, Vertex};
use crate::transport::lights::LightRegion;
use crate::transport::paths::emission;
use crate::transport::scene::{Material, Scene};
use crate::transport::tests::worlds::{Builder, World, glass, lambert, quad};
use glam::{DVec3, Vec3A};

/// A horizontal square at a height, its front up or down. All scenes here reach to 1 and are not scaled.
fn slab(height: f64, [x, z]: [f64; 2], half: f64, up: bool) -> Mesh {
    let side = if up { half } else { -half };
    let v = |dx: f64, dz: f64| DVec3::new(x + dx, height, z + dz);
    quad([v(-side, half), v(side, half), v(side, -half), v(-side, -half)])
}

fn from_above(builder: Builder) -> World {
    builder.seen(DVec3::new(0.1, 5.0, 0.2), DVec3::ZERO, 40.0, [8, 8])
}

/// The surface that a ray from far above or below meets at height 0.
fn met(scene: &Scene, [x, z]: [f32; 2], down: bool) -> Vertex {
    let sign = if down { 1.0 } else { -1.0 };
    let eye = Vertex::camera(Vec3A::new(x + 0.3, 2.0 * sign, z - 0.2), Vec3A::Y);
    let direction = Vec3A::new(x, 0.0, z) - eye.position;
    scene.trace(&eye, direction.normalize()).expect("a surface")
}

fn points(n: u64) -> Vec<[f32; 2]> {
    let mut rng = generator(n, Purpose::Sample, 0, 0, 0);
    (0..200).map(|_| [0; 2].map(|_| (1.8 * uniform(&mut rng) - 0.9) as f32)).collect()
}

/// Σ over uniform points of the lights of what they emit straight up and down, in shares of a lamp of the same size.
fn lit_shares(world: &World) -> [f64; 2] {
    let region = LightRegion::whole(world.scene.lights());
    let mut rng = generator(5, Purpose::Sample, 0, 0, 0);
    let mut shares = [0.0; 2];
    for _ in 0..2000 {
        let vertex = world.scene.light_point(&region.sample(uniform(&mut rng), uniform(&mut rng))).1;
        for (share, direction) in shares.iter_mut().zip([Vec3A::Y, Vec3A::NEG_Y]) {
            *share += f64::from(u8::from(emission(&world.view(), &vertex, direction).is_some()));
        }
    }
    shares.map(|share| share / 2000.0)
}

/// Whatever the order of the meshes, and within the error of a point above or below the surface that it lies in.
#[test]
fn a_lamp_in_a_plane_shines() {
    for (before, gap) in [(true, 0.0), (false, 0.0), (true, 2e-7), (false, -2e-7)] {
        let lamp = |b: Builder| b.light(slab(gap, [0.1, 0.0], 0.3, true), Rgb::ONE, false);
        let floor = |b: Builder| b.surface(slab(0.0, [0.0, 0.0], 1.0, true), lambert(Rgb::ONE));
        let builder = Builder::default();
        let world = from_above(if before { floor(lamp(builder)) } else { lamp(floor(builder)) });
        for [x, z] in points(1) {
            let within = (x - 0.1).abs() < 0.299 && z.abs() < 0.299;
            let around = (x - 0.1).abs() < 0.301 && z.abs() < 0.301;
            let [above, below] = [true, false].map(|down| met(&world.scene, [x, z], down));
            assert!(within == around && above.emits == within && !below.emits, "{x} {z}: {above:?} {below:?}");
            let away = world.scene.trace(&above, Vec3A::new(0.6, 0.8, 0.0));
            assert!(away.is_none(), "{away:?}");
        }
        assert_eq!(lit_shares(&world), [1.0, 0.0]);
        assert_eq!(world.scene.overlaps().len(), 1);
    }
}

/// Of two lamps in one place, each twice, one is seen; back to back, both are.
#[test]
fn each_side_has_one_lamp() {
    let lamp = |b: Builder, up: bool| b.light(slab(0.0, [0.0, 0.0], 1.0, up), Rgb::ONE, false);
    let twice = from_above(lamp(lamp(Builder::default(), true), true));
    let [up, down] = lit_shares(&twice);
    assert!((up - 0.5).abs() < 0.05 && down == 0.0, "{up} {down}");
    assert_eq!(twice.scene.overlaps().len(), 1);
    let back_to_back = from_above(lamp(lamp(Builder::default(), false), true));
    let [up, down] = lit_shares(&back_to_back);
    assert!((up - 0.5).abs() < 0.05 && (down - 0.5).abs() < 0.05, "{up} {down}");
    assert!(back_to_back.scene.overlaps().is_empty());
    for (world, both) in [(&twice, false), (&back_to_back, true)] {
        for point in points(2) {
            let [above, below] = [true, false].map(|down| met(&world.scene, point, down));
            let lit =
                [(above, Vec3A::Y), (below, Vec3A::NEG_Y)].map(|(x, up)| emission(&world.view(), &x, up).is_some());
            assert_eq!(lit, [true, both]);
        }
    }
}

/// An opaque surface hides glass that touches it, and a small one lies upon a large one.
#[test]
fn a_wall_behind_glass_and_a_rug_on_a_floor_are_seen() {
    let lamp = |b: Builder| b.light(slab(-1.0, [-0.95, -0.95], 0.04, true), Rgb::ONE, false);
    let (white, red) = (Rgb::ONE, Rgb::X);
    let pane = from_above(lamp(
        Builder::default()
            .surface(slab(0.0, [0.0, 0.0], 0.5, true), glass(0.0))
            .surface(slab(0.0, [0.0, 0.0], 1.0, true), lambert(white)),
    ));
    let rug = from_above(lamp(
        Builder::default()
            .surface(slab(0.0, [0.0, 0.0], 1.0, true), lambert(white))
            .surface(slab(0.0, [0.0, 0.0], 0.5, true), lambert(red)),
    ));
    for [x, z] in points(3) {
        let within = x.abs() < 0.5 && z.abs() < 0.5;
        for down in [true, false] {
            assert_eq!(met(&pane.scene, [x, z], down).material, 1);
            assert_eq!(met(&rug.scene, [x, z], down).material, u32::from(within));
        }
    }
    assert!(pane.scene.overlaps().is_empty() && rug.scene.overlaps().is_empty());
}

/// As much light crosses lamps in one place from above, where the large veil is seen, as from below, where the small lamp is.
#[test]
fn as_much_passes_up_as_down() {
    for (opacity, expected) in [(1.0, 0.0), (0.5, 0.375)] {
        let lamp = |emits_both_sides, opacity| Material {
            emission: Rgb::ONE,
            emits_both_sides,
            opacity,
            ..Material::default()
        };
        let large = Builder::default().mesh(slab(0.0, [0.0, 0.0], 1.0, true), lamp(true, 0.25));
        let world = from_above(large.mesh(slab(0.0, [0.1, 0.0], 0.3, false), lamp(false, opacity)));
        let mut rng = generator(2, Purpose::Sample, 0, 0, 0);
        for [x, z] in points(3) {
            let within = (x - 0.1).abs() < 0.3 && z.abs() < 0.3;
            let expected = if within { expected } else { 0.75 };
            for sign in [1.0, -1.0] {
                let ends = [sign, -sign].map(|y| Vertex::camera(Vec3A::new(x, y, z), Vec3A::Y));
                assert_eq!(world.scene.transmittance(&ends[0], &ends[1]).unwrap_or(0.0), expected, "{x} {z} {sign}");
                let stops =
                    (0..400).filter(|_| world.scene.follow(&ends[0], Vec3A::Y * -sign, &mut rng).is_some()).count();
                // Two surfaces, either of which is there at most.
                let seen = if within && sign < 0.0 { opacity } else { 0.25 };
                assert!((stops as f32 / 400.0 - seen).abs() < 0.12, "{x} {z} {sign}: {stops} of 400");
            }
        }
    }
}

/// Neighbours that share an edge or part of one, crossing walls, and a lamp a little below a ceiling are no ties.
#[test]
fn what_touches_or_stands_apart_is_not_tied() {
    let v = DVec3::new;
    let crossing = quad([v(0., -1., -0.5), v(0., -1., 0.5), v(0., 1., 0.5), v(0., 1., -0.5)]);
    let world = from_above(
        Builder::default()
            .surface(slab(0.0, [0.0, 0.0], 0.5, true), lambert(Rgb::ONE))
            .surface(slab(0.0, [0.75, 0.3], 0.25, true), lambert(Rgb::X))
            .surface(crossing, lambert(Rgb::Y))
            .light(slab(0.0, [-0.75, 0.2], 0.25, true), Rgb::ONE, false)
            .light(slab(1e-4, [0.25, 0.1], 0.2, true), Rgb::ONE, false),
    );
    assert!(world.scene.overlaps().is_empty());
    let shared = points(4).into_iter().map(|[x, z]| met(&world.scene, [0.5 * x, 0.5 * z], true).shared);
    assert_eq!(shared.filter(|&shared| shared).count(), 0);
}

/// Thousands of lamps in one place take no longer than as many apart.
#[test]
fn many_in_one_place_are_found_in_time() {
    let count = 3000;
    let heap = (0..count)
        .fold(Builder::default(), |b, i| b.light(slab(0.0, [1e-9 * f64::from(i), 0.0], 1.0, true), Rgb::ONE, false));
    let world = from_above(heap);
    let [up, _] = lit_shares(&world);
    assert!(up < 0.01, "{up}");
}
