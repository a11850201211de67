//! Copies that share a shape against the same triangles in world space.

use crate::engine::{Purpose, generator, uniform};
use crate::transport::accel::{Accel, Copies};
use crate::transport::bsdf::{Anisotropy, MetallicRoughness};
use crate::transport::colour::Rgb;
use crate::transport::geometry::{Mesh, Placement, Ray, Vertex, points};
use crate::transport::scene::{
    Alpha, Encoding, Filter, Maps, Material, NormalMap, Pixels, Prototype, Resolved, Scene, SceneDescription, Texture,
    Wrap,
};
use crate::transport::tests::worlds::{ball, map, quad, varying};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec3A, Vec4};
use rand_pcg::rand_core::Rng;

/// Turned, mirrored, stretched, sheared flat, small and far away, large.
fn places() -> Vec<DAffine3> {
    let v = DVec3::new;
    let turn = DQuat::from_axis_angle(v(1.0, 2.0, -1.0).normalize(), 0.7);
    let at = |scale: DVec3, position: DVec3| DAffine3::from_scale_rotation_translation(scale, turn, position);
    let shear = DMat3::from_cols(v(1.0, 0.0, 0.0), v(0.9, 0.3, 0.0), v(0.2, -0.8, 0.1));
    vec![
        at(DVec3::ONE, v(3.0, 0.0, 0.0)),
        at(v(-1.0, 1.0, 1.0), v(-3.0, 0.5, 0.0)),
        at(v(1.0, 0.1, 2.0), v(0.0, 4.0, 0.0)),
        at(v(0.7, -0.01, 0.7), v(0.0, -4.0, 1.0)),
        DAffine3 { matrix3: shear, translation: v(0.0, 0.0, 5.0) },
        at(DVec3::splat(1e-3), v(0.0, 10.0, -12.0)),
        at(v(40.0, 50.0, 40.0), v(0.0, 0.0, -80.0)),
    ]
}

/// The mesh as it stands at a place.
fn placed(mesh: &Mesh, place: &DAffine3) -> Mesh {
    let linear = place.matrix3;
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let side = 1f64.copysign(linear.determinant());
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * side;
    let along = |t: &Vec4| (linear * t.truncate().as_dvec3()).as_vec3().extend(t.w * side as f32);
    let turned = |&[a, b, c]: &[u32; 3]| if side < 0.0 { [a, c, b] } else { [a, b, c] };
    Mesh {
        positions: mesh.positions.iter().map(|p| place.transform_point3(*p)).collect(),
        normals: mesh.normals.iter().map(|n| (cofactors * n.as_dvec3()).normalize().as_vec3()).collect(),
        tangents: mesh.tangents.iter().map(along).collect(),
        triangles: mesh.triangles.iter().map(turned).collect(),
        ..mesh.clone()
    }
}

fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let all: Vec<_> = points(std::slice::from_ref(mesh)).map(|p| p.as_vec3()).collect();
    all.chunks(3).map(|t| [t[0], t[1], t[2]]).collect()
}

/// Copies of a mesh in a structure of their own.
fn copies(mesh: &Mesh, places: &[DAffine3]) -> Accel {
    let placements = places.iter().map(|place| (0, Placement::new(*place).expect("invertible")));
    Accel::new(&[]).with_copies(Copies { shapes: vec![Accel::new(&corners(mesh))], places: placements.collect() })
}

fn direction(rng: &mut impl Rng) -> Vec3 {
    Vec3::from_array([0; 3].map(|_| uniform(rng) as f32 - 0.5)).normalize()
}

/// Share of rays from one copy to another of which two structures say different things.
fn differing(a: &Accel, b: &Accel) -> f64 {
    let mut rng = generator(1, Purpose::Sample, 0, 0, 0);
    let places = places();
    let mut point = |size: f64| {
        let place = places[(uniform(&mut rng) * places.len() as f64) as usize];
        place.transform_point3(size * direction(&mut rng).as_dvec3()).as_vec3()
    };
    let rays = 4000;
    let differs = |_: &i32| {
        let origin = point(3.0);
        let ray = Ray { t_max: 2.0, ..Ray::new(origin, point(0.5) - origin) };
        let found = [a, b].map(|accel| accel.closest(&ray));
        [a, b].iter().zip(found).for_each(|(accel, hit)| assert_eq!(accel.occluded(&ray), hit.is_some(), "{ray:?}"));
        match found {
            [Some(a), Some(b)] => {
                // In world space corners are rounded.
                let rounding = 1e-5 * origin.abs().max_element();
                (a.t - b.t).abs() * ray.direction.length() > rounding
            }
            [a, b] => a.is_some() != b.is_some(),
        }
    };
    (0..rays).filter(differs).count() as f64 / f64::from(rays)
}

/// Control: one copy of seven that stands a little wrong.
#[test]
fn copies_are_hit_as_triangles_in_world_space_are() {
    let (shape, places) = (ball(DVec3::ZERO, 1.0, false), places());
    let baked: Vec<_> = places.iter().flat_map(|place| corners(&placed(&shape, place))).collect();
    let baked = Accel::new(&baked);
    let share = differing(&copies(&shape, &places), &baked);
    assert!(share < 2e-3, "{share}");
    let mut wrong = places;
    wrong[1].translation.x += 0.01;
    let share = differing(&copies(&shape, &wrong), &baked);
    assert!(share > 0.03, "{share}");
}

#[test]
fn closed_copies_do_not_leak() {
    let shape = ball(DVec3::ZERO, 1.0, false);
    let (accel, corners) = (copies(&shape, &places()), corners(&shape));
    let mut rng = generator(2, Purpose::Sample, 0, 0, 0);
    for place in places() {
        let put = |p: Vec3| place.transform_point3(p.as_dvec3()).as_vec3();
        for k in 0..4000 {
            let [a, b, _] = corners[(uniform(&mut rng) * corners.len() as f64) as usize];
            let target = if k % 2 == 0 { a } else { a.lerp(b, uniform(&mut rng) as f32) };
            let origin = put(0.3 * direction(&mut rng));
            let ray = Ray::new(origin, put(target) - origin);
            assert!(accel.closest(&ray).is_some() && accel.occluded(&ray), "{place:?} {ray:?}");
        }
    }
}

/// A scene of copies of a mesh, held once or not, beside a lamp above them.
fn scene(mesh: Mesh, material: Material, places: Vec<DAffine3>, shared: bool) -> Scene {
    let v = |x: f64, z: f64| DVec3::new(x, 60.0, z);
    let lamp = Mesh { material: 1, ..quad([v(-1., -1.), v(1., -1.), v(1., 1.), v(-1., 1.)]) };
    let light = Material { emission: Rgb::ONE, ..Material::default() };
    let leaning =
        |i: i32| [128 + [0, 60, 0, -60][i as usize % 4], 128 + [50, -50][i as usize / 8], 220].map(|x| x as u8);
    let pixels = Pixels::new([4, 4], 3, (0..16).flat_map(leaning).collect()).expect("as many bytes as pixels");
    let texture = Texture::new(pixels.into(), [Wrap::Repeat; 2], Filter::Bilinear, Encoding::Linear);
    let mut description = SceneDescription {
        meshes: vec![lamp],
        materials: vec![material, light],
        textures: vec![texture],
        ..Default::default()
    };
    match shared {
        true => description.prototypes = vec![Prototype { meshes: vec![mesh], places }],
        false => description.meshes.extend(places.iter().map(|place| placed(&mesh, place))),
    }
    Scene::new(description).expect("a scene")
}

/// Vertices where rays from around a unit ball meet its copy at a place; a few may miss it.
fn vertices<'a>(scene: &'a Scene, place: &'a DAffine3, seed: u64) -> impl Iterator<Item = Option<Vertex>> + 'a {
    let mut rng = generator(seed, Purpose::Sample, 0, 0, 0);
    (0..1000).map(move |_| {
        let [from, to] = [1.5, 0.8].map(|size| size * direction(&mut rng).as_dvec3());
        let [from, to] = [from, to].map(|p| scene.space.point(place.transform_point3(p)));
        scene.trace_ray(from.into(), (to - from).normalize().into()).filter(|vertex| !vertex.emits)
    })
}

/// A ray that leaves a convex copy does not meet it, and one that enters it does. Control: rays that start at the vertex itself.
#[test]
fn the_error_of_a_vertex_is_within_its_bound() {
    let scene = scene(ball(DVec3::ZERO, 1.0, false), Material::default(), places(), true);
    let mut rng = generator(3, Purpose::Sample, 0, 0, 0);
    let mut control = 0;
    for (i, place) in places().iter().enumerate() {
        let (mut found, mut lost) = (0, 0);
        for vertex in vertices(&scene, place, 4).flatten() {
            let towards = Vec3A::from(direction(&mut rng));
            let outwards = towards * 1f32.copysign(towards.dot(vertex.geometric_normal));
            // The lamp has two triangles, each ball 90.
            let copy = |v: Vertex| (v.primitive - 2) / 90;
            let meets_itself = |from: &Vertex, towards: Vec3A| {
                scene.trace(from, towards).is_some_and(|hit| !hit.emits && copy(hit) == copy(vertex))
            };
            assert!(!meets_itself(&vertex, outwards), "{i} {vertex:?} {outwards}");
            control += usize::from(meets_itself(&Vertex { error: 0.0, ..vertex }, outwards));
            lost += usize::from(!meets_itself(&vertex, -outwards));
            found += 1;
        }
        assert!(found > 500, "{i}: {found}");
        // Next to a sharp edge a ray may start behind the other side.
        assert!(lost <= 20, "{i}: {lost}");
    }
    assert!(control > 500, "{control}");
}

/// A ball with a normal map, and with tangents where asked for.
fn bumpy(tangents: bool) -> (Mesh, Material) {
    let ball = ball(DVec3::ZERO, 1.0, true);
    let uv = ball.normals.iter().map(|n| Vec2::new(n.x + n.z, n.y)).collect();
    let tangent = |n: &Vec3| n.cross(Vec3::new(0.3, 0.5, 0.8)).normalize().extend(1.0);
    let tangents = if tangents { ball.normals.iter().map(tangent).collect() } else { Vec::new() };
    let maps =
        Maps { normal: Some(NormalMap { map: map(0), scale: 0.8 }), base_color: Some(map(0)), ..Maps::default() };
    (Mesh { uv: [uv, Vec::new()], tangents, ..ball }, varying(MetallicRoughness::default(), maps, Alpha::Opaque))
}

/// Control: the copies are turned.
#[test]
fn vertices_of_copies_are_those_in_world_space() {
    for (tangents, place) in places().into_iter().enumerate().map(|(i, place)| (i % 2 == 0, place)) {
        let (mesh, material) = bumpy(tangents);
        let turned = place * DAffine3::from_rotation_y(0.05);
        let [baked, shared, control] = [(place, false), (place, true), (turned, true)]
            .map(|(place, shared)| scene(mesh.clone(), material.clone(), vec![place], shared));
        let worst = |other: &Scene| {
            let pairs = vertices(&baked, &place, 5).zip(vertices(other, &place, 5));
            let size = place.translation.distance(place.transform_point3(DVec3::ONE));
            let world = |scene: &Scene, v: &Vertex| scene.space.to_world().transform_point3(v.position.as_dvec3());
            let differences: Vec<_> = pairs
                .filter_map(|(a, b)| {
                    let (a, b) = (a?, b?);
                    let uv = baked.coordinates(&a).uv[0].distance(other.coordinates(&b).uv[0]);
                    let position = (world(&baked, &a).distance(world(other, &b)) / size) as f32;
                    let normals = a
                        .geometric_normal
                        .distance(b.geometric_normal)
                        .max(a.shading_normal.distance(b.shading_normal));
                    Some(position.max(normals).max(uv))
                })
                .collect();
            assert!(differences.len() > 500);
            // A few rays meet the neighbour of an edge.
            let mut sorted = differences;
            sorted.sort_by(f32::total_cmp);
            sorted[sorted.len() * 99 / 100]
        };
        assert!(worst(&shared) < 0.02, "{place:?}: {}", worst(&shared));
        assert!(worst(&control) > 0.04, "{place:?}: {}", worst(&control));
    }
}

/// Brushed metal under a smooth coat scatters on a copy as in world space. Control: the copies are turned.
#[test]
fn surfaces_of_copies_are_those_in_world_space() {
    let mesh = bumpy(false).0;
    let factors = MetallicRoughness {
        roughness: 0.5,
        anisotropy: Anisotropy { strength: 0.7, rotation: 0.4, ..Anisotropy::default() },
        clearcoat: 0.5,
        clearcoat_roughness: 0.5,
        ..MetallicRoughness::default()
    };
    let maps = Maps { normal: Some(NormalMap { map: map(0), scale: 0.3 }), ..Maps::default() };
    let material = varying(factors, maps, Alpha::Opaque);
    for place in places() {
        let turned = place * DAffine3::from_rotation_y(0.3);
        let [baked, shared, control] = [(place, false), (place, true), (turned, true)]
            .map(|(place, shared)| scene(mesh.clone(), material.clone(), vec![place], shared));
        let scattered = |scene: &Scene, vertex: &Vertex, aside: Vec3A| {
            let [to_light, to_eye] = [aside, -aside].map(|aside| (vertex.geometric_normal + 0.6 * aside).normalize());
            let found = scene.surface(vertex, &mut Resolved::default()).evaluate(to_light, to_eye);
            found.map_or(0.0, |found| found.value.x)
        };
        let typical = |other: &Scene| {
            let pairs = vertices(&baked, &place, 5).zip(vertices(other, &place, 5));
            let mut off: Vec<_> = pairs
                .filter_map(|(a, b)| {
                    let (a, b) = (a?, b?);
                    let aside = a.geometric_normal.any_orthonormal_vector();
                    let [x, y] = [(&baked, a), (other, b)].map(|(scene, vertex)| scattered(scene, &vertex, aside));
                    Some((x - y).abs() / (x + y + 1e-3))
                })
                .collect();
            off.sort_by(f32::total_cmp);
            off[off.len() * 9 / 10]
        };
        assert!(typical(&shared) < 0.02, "{place:?}: {}", typical(&shared));
        assert!(typical(&control) > 0.05, "{place:?}: {}", typical(&control));
    }
}

#[test]
fn prototypes_that_cannot_be_are_refused() {
    let triangle = Mesh { name: "bulb".to_owned(), ..quad([DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y]) };
    let error = |emission, triangles: usize, places: usize| {
        let mesh = Mesh { triangles: vec![[0, 1, 2]; triangles], ..triangle.clone() };
        let prototype = Prototype { meshes: vec![mesh], places: vec![DAffine3::IDENTITY; places] };
        let materials = vec![Material { emission, ..Material::default() }];
        let description = SceneDescription { prototypes: vec![prototype], materials, ..SceneDescription::default() };
        Scene::new(description).unwrap_err().to_string()
    };
    assert!(error(Rgb::ONE, 1, 2).contains("mesh \"bulb\" stands in several places and emits light"));
    assert!(
        error(Rgb::ZERO, 1 << 16, (1 << 15) + 1).contains("2147549184 triangles, copies included; at most 2147483648")
    );
    assert!(error(Rgb::ZERO, 1, 2).contains("no light"));
}
